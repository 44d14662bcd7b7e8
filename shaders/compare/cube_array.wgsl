// The hardware's comparison in the cubes of several lights without an orientation: cube_shadow_hardware of
// cube_lookup.wgsl, for passes that ask all lights at each pixel.

// Twin of `ArrayRecord` in src/compare/baselines/cube_array.rs.
struct CubeArrayLight {
    position: vec3<f32>,
    range: f32,
    // As those of `CubeLight`.
    half_width: f32,
    texel: f32,
    depth_scale: f32,
    depth_bias: f32,
    normal_bias: f32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

@group(CUBE_GROUP) @binding(0) var cube_maps: texture_depth_cube_array;
@group(CUBE_GROUP) @binding(1) var cube_comparison: sampler_comparison;
@group(CUBE_GROUP) @binding(2) var<storage, read> cube_lights: array<CubeArrayLight>;

fn cube_array_axis_distance(v: vec3<f32>) -> f32 {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

// Share of the light number `light` that reaches `position`.
fn cube_array_shadow(light: u32, position: vec3<f32>, normal: vec3<f32>) -> f32 {
    let x = position - cube_lights[light].position;
    if dot(x, x) > cube_lights[light].range * cube_lights[light].range {
        return 1.0;
    }
    let lit_side = normalize(normal) * -sign(dot(normal, x));
    let offset = lit_side * (cube_lights[light].normal_bias * cube_lights[light].texel * cube_array_axis_distance(x));
    let moved = x + offset - x * (cube_lights[light].depth_bias * inverseSqrt(dot(x, x)));
    let a = abs(moved);
    let is_x = a.x >= max(a.y, a.z);
    let is_y = !is_x && a.y >= a.z;
    let along = vec3<bool>(is_x, is_y, !is_x && !is_y);
    let direction = select(moved * (1.0 / cube_lights[light].half_width), moved, along);
    let depth = cube_lights[light].depth_scale / cube_array_axis_distance(moved);
    return textureSampleCompareLevel(cube_maps, cube_comparison, direction, light, depth);
}
