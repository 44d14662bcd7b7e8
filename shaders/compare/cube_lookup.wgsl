// Lookups in a cube of depth maps, to set against the pair's: one as engines have it, one with the bias of
// shaders/lookup.wgsl. The faces lie along the world's axes.

// Twin of `CubeRecord` in src/compare/baselines/cube_lookup.rs.
struct CubeLight {
    position: vec3<f32>,
    near: f32,
    range: f32,
    // World units toward the light.
    depth_bias: f32,
    // Along the normal, per unit of distance.
    normal_bias: f32,
    // Width of a texel at distance 1 along the face's axis.
    texel: f32,
}

@group(CUBE_GROUP) @binding(0) var cube_map: texture_depth_cube;
@group(CUBE_GROUP) @binding(1) var cube_faces: texture_depth_2d_array;
@group(CUBE_GROUP) @binding(2) var cube_comparison: sampler_comparison;
@group(CUBE_GROUP) @binding(3) var cube_sampler: sampler;
@group(CUBE_GROUP) @binding(4) var<storage, read> cube_light: CubeLight;

// As in shaders/lookup.wgsl, in texels of the cube. The pair's tolerance along the normal has no counterpart: a flat
// view's chords don't bend.
const CUBE_BIAS: f32 = 0.05;
const CUBE_RAMP: f32 = 0.5;
const CUBE_FADE: f32 = 0.1;
const CUBE_QUORUM: f32 = 0.02;
const CUBE_SLOPE_LOW: f32 = 0.25;
const CUBE_SLOPE_HIGH: f32 = 4.0;

// Distance along the axis of the face that a direction lies in: what the depth is made of.
fn cube_axis_distance(v: vec3<f32>) -> f32 {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

// The receiver relative to the light, moved along its normal, in proportion to the texel's size there, and by a constant
// toward the light.
fn cube_moved(position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let from_light = position - cube_light.position;
    // Engines have normals that face the viewer, and light nothing from behind: here either sign may come.
    let lit_side = normalize(normal) * -sign(dot(normal, from_light));
    let offset = lit_side * (cube_light.normal_bias * cube_axis_distance(from_light));
    let toward_light = from_light * (cube_light.depth_bias * inverseSqrt(dot(from_light, from_light)));
    return from_light + offset - toward_light;
}

// Share of the light that reaches `position`, by the hardware's comparison of four texels with one reference.
fn cube_shadow_hardware(position: vec3<f32>, normal: vec3<f32>) -> f32 {
    let from_light = position - cube_light.position;
    if dot(from_light, from_light) > cube_light.range * cube_light.range {
        return 1.0;
    }
    let moved = cube_moved(position, normal);
    let depth = cube_light.near / cube_axis_distance(moved);
    return textureSampleCompareLevel(cube_map, cube_comparison, moved, depth);
}

// Number of the face that a direction lies in.
fn cube_face(v: vec3<f32>) -> u32 {
    let a = abs(v);
    if a.x >= max(a.y, a.z) {
        return select(0u, 1u, v.x < 0.0);
    }
    if a.y >= a.z {
        return select(2u, 3u, v.y < 0.0);
    }
    return select(4u, 5u, v.z < 0.0);
}

// A vector of world space by a face's axes: right, up, forward.
fn cube_to_face(v: vec3<f32>, face: u32) -> vec3<f32> {
    let s = select(1.0, -1.0, (face & 1u) != 0u);
    if face < 2u {
        return vec3<f32>(-s * v.z, v.y, s * v.x);
    }
    if face < 4u {
        return vec3<f32>(v.x, -s * v.z, s * v.y);
    }
    return vec3<f32>(s * v.x, v.y, s * v.z);
}

// Share of the light that reaches `position`: four texels, each held against the receiver's plane at its own centre,
// and their votes weighted bilinearly, as `dp_shadow` does. At a face's border the face's own last texels stand in for
// those of its neighbour.
fn cube_shadow_plane(position: vec3<f32>, normal: vec3<f32>) -> f32 {
    let from_light = position - cube_light.position;
    let distance_squared = dot(from_light, from_light);
    if distance_squared > cube_light.range * cube_light.range {
        return 1.0;
    }
    let face = cube_face(from_light);
    let x = cube_to_face(from_light, face);
    let n = cube_to_face(normal, face);
    let texel = cube_light.texel;
    let resolution = f32(textureDimensions(cube_faces).x);
    let p = x.xy / x.z;
    let at = 0.5 * resolution + p * vec2<f32>(1.0, -1.0) / texel - 0.5;
    let base = clamp(floor(at), vec2<f32>(0.0), vec2<f32>(max(resolution - 2.0, 0.0)));
    let f = clamp(at - base, vec2<f32>(0.0), vec2<f32>(1.0));
    let stored = textureGather(cube_faces, cube_sampler, (base + 1.0) / resolution, face);
    let low = (base + 0.5 - 0.5 * resolution) * vec2<f32>(texel, -texel);
    let high = low + vec2<f32>(texel, -texel);
    let here = dot(n, vec3<f32>(p, 1.0));
    // The order in which textureGather gives the texels: row below, then row above, counter-clockwise.
    let there = n.z + n.x * vec4<f32>(low.x, high.x, high.x, low.x) + n.y * vec4<f32>(high.y, high.y, low.y, low.y);
    let slopes = clamp(there / here, vec4<f32>(CUBE_SLOPE_LOW), vec4<f32>(CUBE_SLOPE_HIGH));
    // Without a plane (no normal, or the light in it) the receiver's own depth has to do.
    let plane = cube_light.near / x.z * select(vec4<f32>(1.0), slopes, abs(here) > 0.0);
    // A texel's footprint, as an angle and in its wider direction, is its width over the ray's length at distance 1.
    let footprint = texel * x.z * inverseSqrt(distance_squared);
    let incidence = abs(here) / max(length(n) * length(vec3<f32>(p, 1.0)), 1e-30);
    let spread = 1.0 + 1.0 / max(incidence, 1e-3);
    let margin = (stored / plane - 1.0) / footprint;
    let before = max(1.0 - margin / CUBE_BIAS, vec4<f32>(0.0));
    let behind = 1.0 / (1.0 - min(margin, vec4<f32>(0.0)) / (CUBE_FADE * spread));
    let votes_dark = clamp((margin - CUBE_BIAS) / (CUBE_RAMP * spread), vec4<f32>(0.0), vec4<f32>(1.0));
    let votes_lit = select(before, behind, margin < vec4<f32>(0.0));
    let weights = vec4<f32>((1.0 - f.x) * f.y, f.x * f.y, f.x * (1.0 - f.y), (1.0 - f.x) * (1.0 - f.y));
    let dark = dot(weights, votes_dark);
    return max(1.0 - dark / max(dot(weights, votes_lit) + dark, CUBE_QUORUM), 0.0);
}
