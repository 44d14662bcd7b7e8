// Depth: one hemisphere's view of the triangles and pieces that the stages before have chosen. The hardware
// divides, clips, interpolates and tests; there is no fragment shader.

struct HemisphereView {
    // Rows of the rotation from world to hemisphere space.
    right: vec3<f32>,
    near: f32,
    up: vec3<f32>,
    // Share of the map's half-width that the unit disc takes.
    scale: f32,
    forward: vec3<f32>,
    padding_0: u32,
    // What vertices are relative to: the light's position for world space, 0 for pieces.
    origin: vec3<f32>,
    padding_1: u32,
    light: vec3<f32>,
    padding_2: u32,
}

@group(0) @binding(0) var<uniform> hemisphere: HemisphereView;

@vertex
fn depth(@location(0) position: vec3<f32>) -> @invariant @builtin(position) vec4<f32> {
    return clip_position(position);
}

// A corner of a piece, with its shift of 1/w.
@vertex
fn depth_of_piece(@location(0) corner: vec4<f32>) -> @invariant @builtin(position) vec4<f32> {
    return clip_position_of_piece(corner.xyz, corner.w);
}

fn clip_position_of_piece(corner: vec3<f32>, shift: f32) -> vec4<f32> {
    let clip = clip_position(corner);
    return vec4<f32>(clip.xy, clip.z * (1.0 + shift * clip.w), clip.w);
}

fn clip_position(position: vec3<f32>) -> vec4<f32> {
    let relative = position - hemisphere.origin;
    let x = vec3<f32>(
        dot(hemisphere.right, relative),
        dot(hemisphere.up, relative),
        dot(hemisphere.forward, relative),
    );
    return dp_clip_position(x, hemisphere.near, hemisphere.scale);
}
