// Lookups in a cube of depth maps, to set against the pair's: as engines have it, with a fitted bias or the shipped one, and
// with the votes of shaders/lookup.wgsl. The faces lie along light space's axes. A guard band around each face holds all
// texels that bilinear filtering of the face's own directions takes. Goes with cube_face.wgsl.

// Twin of `CubeRecord` in src/compare/baselines/cube_lookup.rs.
struct CubeLight {
    // Rows of the rotation from world to light space.
    right: vec3<f32>,
    range: f32,
    up: vec3<f32>,
    // Half a face's width at distance 1 along its axis: 1 and the guard band.
    half_width: f32,
    forward: vec3<f32>,
    // Width of a texel at distance 1 along the face's axis.
    texel: f32,
    position: vec3<f32>,
    // The depth of what is at distance z along the face's axis is depth_scale / z + depth_offset.
    depth_scale: f32,
    depth_offset: f32,
    // Of the hardware's comparison: world units toward the light, texel footprints along the normal.
    depth_bias: f32,
    normal_bias: f32,
    // Of the comparison with planes: texel footprints along the ray and along the normal.
    plane_ray_bias: f32,
    plane_normal_bias: f32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

@group(CUBE_GROUP) @binding(0) var cube_map: texture_depth_cube;
@group(CUBE_GROUP) @binding(1) var cube_faces: texture_2d_array<f32>;
@group(CUBE_GROUP) @binding(2) var cube_comparison: sampler_comparison;
@group(CUBE_GROUP) @binding(3) var cube_sampler: sampler;
@group(CUBE_GROUP) @binding(4) var<storage, read> cube_light: CubeLight;

// As in shaders/lookup.wgsl, in texels of the cube.
const CUBE_RAMP: f32 = 0.5;
const CUBE_FADE: f32 = 0.1;
const CUBE_QUORUM: f32 = 0.02;
const CUBE_SLOPE_LOW: f32 = 0.25;
const CUBE_SLOPE_HIGH: f32 = 4.0;

// Whether the light may have an orientation: engines' cubes lie along the world's axes and don't turn anything.
const CUBE_IS_TURNED: bool = CUBE_TURNED;

// What bevy 0.20 ships for point lights: 0.08 world units, and 0.6 diagonals of a texel.
const CUBE_SHIPPED_DEPTH_BIAS: f32 = 0.08;
const CUBE_SHIPPED_NORMAL_BIAS: f32 = 0.8485281;

// A vector of world space in light space.
fn cube_turned(v: vec3<f32>) -> vec3<f32> {
    if !CUBE_IS_TURNED {
        return v;
    }
    return vec3<f32>(dot(cube_light.right, v), dot(cube_light.up, v), dot(cube_light.forward, v));
}

// Distance along the axis of the face that a direction lies in: what the depth is made of.
fn cube_axis_distance(v: vec3<f32>) -> f32 {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

fn cube_depth(axis_distance: f32) -> f32 {
    return cube_light.depth_scale / axis_distance + cube_light.depth_offset;
}

// The direction in which a cube texture has what the faces hold in direction `v`: nearer to the face's axis, since a face
// reaches past its border.
fn cube_direction(v: vec3<f32>) -> vec3<f32> {
    let a = abs(v);
    let is_x = a.x >= max(a.y, a.z);
    let is_y = !is_x && a.y >= a.z;
    return select(v * (1.0 / cube_light.half_width), v, vec3<bool>(is_x, is_y, !is_x && !is_y));
}

fn cube_is_out_of_range(from_light: vec3<f32>) -> bool {
    return dot(from_light, from_light) > cube_light.range * cube_light.range;
}

// A receiver of light space, moved along its normal, in proportion to the texel's size there, and by a constant
// toward the light.
fn cube_moved(x: vec3<f32>, normal: vec3<f32>, depth_bias: f32, normal_bias: f32) -> vec3<f32> {
    // Engines have normals that face the viewer, and light nothing from behind: here either sign may come.
    let lit_side = normalize(normal) * -sign(dot(normal, x));
    let offset = lit_side * (normal_bias * cube_light.texel * cube_axis_distance(x));
    let toward_light = x * (depth_bias * inverseSqrt(dot(x, x)));
    return x + offset - toward_light;
}

// The hardware's comparison of the four texels around a direction with one reference.
fn cube_compared(direction: vec3<f32>, depth: f32) -> f32 {
    return textureSampleCompareLevel(cube_map, cube_comparison, cube_direction(direction), depth);
}

fn cube_shadow_biased(position: vec3<f32>, normal: vec3<f32>, depth_bias: f32, normal_bias: f32) -> f32 {
    let x = cube_turned(position - cube_light.position);
    if cube_is_out_of_range(x) {
        return 1.0;
    }
    let moved = cube_moved(x, cube_turned(normal), depth_bias, normal_bias);
    return cube_compared(moved, cube_depth(cube_axis_distance(moved)));
}

// Share of the light that reaches `position`, by the hardware's comparison of four texels with one reference.
fn cube_shadow_hardware(position: vec3<f32>, normal: vec3<f32>) -> f32 {
    return cube_shadow_biased(position, normal, cube_light.depth_bias, cube_light.normal_bias);
}

// The same with the bias that an engine ships.
fn cube_shadow_shipped(position: vec3<f32>, normal: vec3<f32>) -> f32 {
    return cube_shadow_biased(position, normal, CUBE_SHIPPED_DEPTH_BIAS, CUBE_SHIPPED_NORMAL_BIAS);
}

// Share of the light that reaches `position`: four texels, each held against the receiver's plane at its own centre,
// and their votes weighted bilinearly, as `dp_shadow` does. For cubes whose depth has no offset.
fn cube_shadow_plane(position: vec3<f32>, normal: vec3<f32>) -> f32 {
    let from_light = cube_turned(position - cube_light.position);
    if cube_is_out_of_range(from_light) {
        return 1.0;
    }
    let face = cube_face(from_light);
    let x = cube_to_face(from_light, face);
    let n = cube_to_face(cube_turned(normal), face);
    let texel = cube_light.texel;
    let resolution = f32(textureDimensions(cube_faces).x);
    let p = x.xy / x.z;
    let at = 0.5 * resolution + p * vec2<f32>(1.0, -1.0) / texel - 0.5;
    let base = floor(at);
    let f = at - base;
    let stored = textureGather(0, cube_faces, cube_sampler, (base + 1.0) / resolution, face);
    let low = (base + 0.5 - 0.5 * resolution) * vec2<f32>(texel, -texel);
    let high = low + vec2<f32>(texel, -texel);
    let here = dot(n, vec3<f32>(p, 1.0));
    // The order in which textureGather gives the texels: row below, then row above, counter-clockwise.
    let there = n.z + n.x * vec4<f32>(low.x, high.x, high.x, low.x) + n.y * vec4<f32>(high.y, high.y, low.y, low.y);
    let slopes = clamp(there / here, vec4<f32>(CUBE_SLOPE_LOW), vec4<f32>(CUBE_SLOPE_HIGH));
    // Without a plane (no normal, or the light in it) the receiver's own depth has to do.
    let plane = cube_light.depth_scale / x.z * select(vec4<f32>(1.0), slopes, abs(here) > 0.0);
    // A texel's footprint, as an angle and in its wider direction, is its width over the ray's length at distance 1.
    let footprint = texel * x.z * inverseSqrt(dot(x, x));
    let incidence = abs(here) / max(length(n) * length(vec3<f32>(p, 1.0)), 1e-30);
    let grazing = 1.0 / max(incidence, 1e-3);
    let spread = 1.0 + grazing;
    let bias = max(cube_light.plane_ray_bias + cube_light.plane_normal_bias * grazing, 1e-6);
    let margin = (stored / plane - 1.0) / footprint;
    let before = max(1.0 - margin / bias, vec4<f32>(0.0));
    let behind = 1.0 / (1.0 - min(margin, vec4<f32>(0.0)) / (CUBE_FADE * spread));
    let votes_dark = clamp((margin - bias) / (CUBE_RAMP * spread), vec4<f32>(0.0), vec4<f32>(1.0));
    let votes_lit = select(before, behind, margin < vec4<f32>(0.0));
    let weights = vec4<f32>((1.0 - f.x) * f.y, f.x * f.y, f.x * (1.0 - f.y), (1.0 - f.x) * (1.0 - f.y));
    let dark = dot(weights, votes_dark);
    return max(1.0 - dark / max(dot(weights, votes_lit) + dark, CUBE_QUORUM), 0.0);
}
