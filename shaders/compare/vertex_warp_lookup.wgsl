// Lookup in a pair of maps from vertex_warp.wgsl, as engines have it: the hardware's comparison of four texels with
// one reference, which a constant moves toward the light.

// Twin of `WarpRecord` in src/compare/baselines/vertex_warp.rs.
struct WarpLight {
    // Rows of the rotation from world to light space.
    right: vec3<f32>,
    range: f32,
    up: vec3<f32>,
    // World units toward the light.
    bias: f32,
    forward: vec3<f32>,
    padding_0: u32,
    position: vec3<f32>,
    padding_1: u32,
}

@group(WARP_GROUP) @binding(0) var warp_map: texture_depth_2d;
@group(WARP_GROUP) @binding(1) var warp_comparison: sampler_comparison;
@group(WARP_GROUP) @binding(2) var<storage, read> warp_light: WarpLight;

// Share of the light that reaches `position`.
fn warp_shadow(position: vec3<f32>) -> f32 {
    let relative = position - warp_light.position;
    let x = vec3<f32>(
        dot(warp_light.right, relative),
        dot(warp_light.up, relative),
        dot(warp_light.forward, relative),
    );
    let distance = length(x);
    if distance > warp_light.range {
        return 1.0;
    }
    let back = x.z < 0.0;
    let d = select(x, vec3<f32>(-x.x, x.y, -x.z), back) / distance;
    let p = d.xy / (1.0 + d.z);
    // Half a texel off the border, so that the other hemisphere isn't read.
    let half_texel = 0.5 / f32(textureDimensions(warp_map).y);
    let uv = clamp(0.5 + p * vec2<f32>(0.5, -0.5), vec2<f32>(half_texel), vec2<f32>(1.0 - half_texel));
    let at = vec2<f32>(0.5 * (uv.x + select(0.0, 1.0, back)), uv.y);
    let reference = 1.0 - (distance - warp_light.bias) / warp_light.range;
    return textureSampleCompareLevel(warp_map, warp_comparison, at, reference);
}
