// Where a point goes in one hemisphere's map. May be pasted into shaders that draw casters of their own; DP_GROUP is the
// number of the group.

struct DpHemisphere {
    // Rows of the rotation from world to hemisphere space.
    right: vec3<f32>,
    near: f32,
    up: vec3<f32>,
    // Share of the map's half-width that the unit disc takes.
    scale: f32,
    forward: vec3<f32>,
    padding_0: u32,
    // The light's position in the world.
    origin: vec3<f32>,
    padding_1: u32,
}

@group(DP_GROUP) @binding(0) var<uniform> dp_hemisphere: DpHemisphere;

fn dp_caster_position(position: vec3<f32>) -> vec4<f32> {
    let relative = position - dp_hemisphere.origin;
    let x = vec3<f32>(
        dot(dp_hemisphere.right, relative),
        dot(dp_hemisphere.up, relative),
        dot(dp_hemisphere.forward, relative),
    );
    return dp_clip_position(x, dp_hemisphere.near, dp_hemisphere.scale);
}
