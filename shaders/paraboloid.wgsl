// The paraboloid mapping; twin of src/paraboloid.rs, where each function is documented. Same names with
// the prefix dp_, same arithmetic. Declares no bindings, so it may be pasted anywhere.

// Cosine (120 degrees from the axis) behind which a vertex can't belong to a triangle that touches the disc.
const DP_BEHIND: f32 = -0.5;

fn dp_to_hemisphere(light_space: vec3<f32>, back: bool) -> vec3<f32> {
    return select(light_space, vec3<f32>(-light_space.x, light_space.y, -light_space.z), back);
}

fn dp_is_back(light_space: vec3<f32>) -> bool {
    return light_space.z < 0.0;
}

fn dp_homogeneous_w(x: vec3<f32>) -> f32 {
    let l = length(x);
    // |X| + X.z cancels behind the seam; the other root of the same quadratic doesn't.
    return select(l + x.z, dot(x.xy, x.xy) / (l - x.z), x.z < 0.0);
}

fn dp_project(x: vec3<f32>) -> vec2<f32> {
    let w = dp_homogeneous_w(x);
    return select(vec2<f32>(1e18, 0.0), x.xy / w, w > 0.0);
}

fn dp_unproject_scaled(p: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(p.x, p.y, 0.5 - 0.5 * dot(p, p));
}

fn dp_unproject(p: vec2<f32>) -> vec3<f32> {
    return dp_unproject_scaled(p) * (2.0 / (1.0 + dot(p, p)));
}

fn dp_clip_position(x: vec3<f32>, near: f32, scale: f32) -> vec4<f32> {
    let l = length(x);
    let w = dp_homogeneous_w(x);
    let z = select(near, 2.0 * l, x.z < DP_BEHIND * l);
    return vec4<f32>(x.x * scale, x.y * scale, z, w);
}

fn dp_depth(x: vec3<f32>, near: f32) -> f32 {
    return near / dp_homogeneous_w(x);
}

fn dp_plane_depth(normal: vec3<f32>, distance: f32, p: vec2<f32>, near: f32) -> f32 {
    return (near / distance) * dot(normal, dp_unproject_scaled(p));
}

fn dp_solid_angle_density(p: vec2<f32>) -> f32 {
    let a = 2.0 / (1.0 + dot(p, p));
    return a * a;
}

fn dp_texel_angle(p: vec2<f32>, texel: f32) -> f32 {
    return texel * 2.0 / (1.0 + dot(p, p));
}
