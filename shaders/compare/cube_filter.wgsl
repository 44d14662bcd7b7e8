// The filters of filter.wgsl on a cube of depth maps, as engines have them: one reference for all taps, by the
// hardware's comparison of four texels. Goes with cube_lookup.wgsl.

// The receiver as the comparison takes it, and directions across its ray.
struct CubeTaps {
    moved: vec3<f32>,
    depth: f32,
    across: vec3<f32>,
    up: vec3<f32>,
}

fn cube_taps(x: vec3<f32>, normal: vec3<f32>) -> CubeTaps {
    let moved = cube_moved(x, cube_turned(normal), cube_light.depth_bias, cube_light.normal_bias);
    let d = normalize(moved);
    let s = select(-1.0, 1.0, d.z >= 0.0);
    let a = -1.0 / (s + d.z);
    let across = vec3<f32>(1.0 + s * d.x * d.x * a, s * d.x * d.y * a, -s * d.x);
    let up = vec3<f32>(d.x * d.y * a, s + d.y * d.y * a, -d.y);
    return CubeTaps(moved, cube_depth(cube_axis_distance(moved)), across, up);
}

// The mean of `2 reach + 1` comparisons each way, a texel apart.
fn cube_shadow_square(position: vec3<f32>, normal: vec3<f32>, reach: i32) -> f32 {
    let x = cube_turned(position - cube_light.position);
    if cube_is_out_of_range(x) {
        return 1.0;
    }
    let moved = cube_moved(x, cube_turned(normal), cube_light.depth_bias, cube_light.normal_bias);
    let distance = cube_axis_distance(moved);
    let depth = cube_depth(distance);
    let face = cube_face(moved);
    let step = cube_light.texel * distance;
    let right = step * cube_to_face(vec3<f32>(1.0, 0.0, 0.0), face);
    let up = step * cube_to_face(vec3<f32>(0.0, 1.0, 0.0), face);
    var sum = 0.0;
    for (var row = -reach; row <= reach; row++) {
        for (var column = -reach; column <= reach; column++) {
            sum += cube_compared(moved + f32(column) * right + f32(row) * up, depth);
        }
    }
    let side = f32(2 * reach + 1);
    return sum / (side * side);
}

// The direction number `tap` of a spiral of `taps` that fills a disc of `radius` around the receiver's.
fn cube_spiral(taps: CubeTaps, tap: u32, count: u32, radius: f32, noise: f32) -> vec3<f32> {
    let turn = 2.3999632 * f32(tap) + 6.2831853 * noise;
    let r = radius * length(taps.moved) * sqrt((f32(tap) + 0.5) / f32(count));
    return taps.moved + r * (cos(turn) * taps.across + sin(turn) * taps.up);
}

fn cube_disc(taps: CubeTaps, radius: f32, count: u32, noise: f32) -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < count; i++) {
        sum += cube_compared(cube_spiral(taps, i, count, radius, noise), taps.depth);
    }
    return sum / f32(count);
}

// The mean of `count` comparisons over a disc of `radius` radians.
fn cube_shadow_disc(position: vec3<f32>, normal: vec3<f32>, radius: f32, count: u32, noise: f32) -> f32 {
    let x = cube_turned(position - cube_light.position);
    if cube_is_out_of_range(x) {
        return 1.0;
    }
    return cube_disc(cube_taps(x, normal), radius, count, noise);
}

// Percentage-closer soft shadows: `count` texels for the mean blocker, as many comparisons over its penumbra.
fn cube_shadow_soft(position: vec3<f32>, normal: vec3<f32>, light_radius: f32, count: u32, noise: f32) -> f32 {
    let x = cube_turned(position - cube_light.position);
    if cube_is_out_of_range(x) {
        return 1.0;
    }
    let taps = cube_taps(x, normal);
    let size = light_radius / length(taps.moved);
    var depths = 0.0;
    var found = 0.0;
    for (var i = 0u; i < count; i++) {
        let direction = cube_direction(cube_spiral(taps, i, count, 4.0 * size, noise));
        let stored = textureSampleLevel(cube_map, cube_sampler, direction, 0u);
        depths += select(0.0, stored, stored > taps.depth);
        found += select(0.0, 1.0, stored > taps.depth);
    }
    if found == 0.0 {
        return 1.0;
    }
    let radius = size * (depths / (found * taps.depth) - 1.0);
    return cube_disc(taps, min(radius, 0.35), count, noise);
}
