// Lookups in a pair of maps from vertex_warp.wgsl, as engines have them: the hardware's comparison of four texels with
// one reference, with a fitted bias or the shipped one.

// Twin of `WarpRecord` in src/compare/baselines/vertex_warp.rs.
struct WarpLight {
    // Rows of the rotation from world to light space.
    right: vec3<f32>,
    range: f32,
    up: vec3<f32>,
    // World units toward the light.
    depth_bias: f32,
    forward: vec3<f32>,
    // Texel footprints along the normal.
    normal_bias: f32,
    position: vec3<f32>,
    padding: u32,
}

@group(WARP_GROUP) @binding(0) var warp_map: texture_depth_2d;
@group(WARP_GROUP) @binding(1) var warp_comparison: sampler_comparison;
@group(WARP_GROUP) @binding(2) var<storage, read> warp_light: WarpLight;

// What Godot 4 ships for omni lights: `shadow_bias` in world units, and `shadow_normal_bias` as it goes into the shader,
// in texels.
const WARP_SHIPPED_DEPTH_BIAS: f32 = 0.1;
const WARP_SHIPPED_NORMAL_BIAS: f32 = 10.0;

// A vector of world space in light space.
fn warp_turned(v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(warp_light.right, v), dot(warp_light.up, v), dot(warp_light.forward, v));
}

// The normal, of length 1 and on the light's side.
fn warp_lit_side(x: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    return normalize(normal) * -sign(dot(normal, x));
}

// The hardware's comparison of the four texels around a direction with the depth of a distance.
fn warp_compared(direction: vec3<f32>, distance: f32) -> f32 {
    let back = direction.z < 0.0;
    let d = normalize(select(direction, vec3<f32>(-direction.x, direction.y, -direction.z), back));
    let p = d.xy / (1.0 + d.z);
    // Half a texel off the border, so that the other hemisphere isn't read.
    let half_texel = 0.5 / f32(textureDimensions(warp_map).y);
    let uv = clamp(0.5 + p * vec2<f32>(0.5, -0.5), vec2<f32>(half_texel), vec2<f32>(1.0 - half_texel));
    let at = vec2<f32>(0.5 * (uv.x + select(0.0, 1.0, back)), uv.y);
    return textureSampleCompareLevel(warp_map, warp_comparison, at, 1.0 - distance / warp_light.range);
}

// Share of the light that reaches `position`. The receiver is moved along its normal and toward the light.
fn warp_shadow(position: vec3<f32>, normal: vec3<f32>) -> f32 {
    let x = warp_turned(position - warp_light.position);
    let distance = length(x);
    if distance > warp_light.range {
        return 1.0;
    }
    // A texel spans the angle 2 (2 / R) / (1 + r^2) = (2 / R) (1 + cosine to the axis).
    let footprint = 2.0 / f32(textureDimensions(warp_map).y) * (distance + abs(x.z));
    let moved = x + warp_lit_side(x, warp_turned(normal)) * (warp_light.normal_bias * footprint);
    return warp_compared(moved, length(moved) - warp_light.depth_bias);
}

// The same with the bias that an engine ships: the normal turns the direction alone, where light grazes.
fn warp_shadow_shipped(position: vec3<f32>, normal: vec3<f32>) -> f32 {
    let x = warp_turned(position - warp_light.position);
    let distance = length(x);
    if distance > warp_light.range {
        return 1.0;
    }
    let lit_side = warp_lit_side(x, warp_turned(normal));
    let turn = WARP_SHIPPED_NORMAL_BIAS / f32(textureDimensions(warp_map).y) * (1.0 + dot(lit_side, x) / distance);
    return warp_compared(x / distance + lit_side * turn, distance - WARP_SHIPPED_DEPTH_BIAS);
}
