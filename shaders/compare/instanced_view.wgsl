// A view of the instanced baselines; twin of `InstancedView` in src/compare/baselines/instanced.rs.

struct InstancedView {
    // Rows of the projection from world space, relative to the origin, to clip space.
    row_x: vec4<f32>,
    row_y: vec4<f32>,
    row_z: vec4<f32>,
    row_w: vec4<f32>,
    // World space. Subtracted first, so that a scene far from the world's origin keeps its precision.
    origin: vec3<f32>,
    padding: u32,
}

fn clip_position(view: InstancedView, world: vec3<f32>) -> vec4<f32> {
    let p = vec4<f32>(world - view.origin, 1.0);
    return vec4<f32>(dot(view.row_x, p), dot(view.row_y, p), dot(view.row_z, p), dot(view.row_w, p));
}
