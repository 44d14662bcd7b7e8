// Vertex warp: the paraboloid pair as published (Brabec, Annen and Seidel 2002) and as engines ship it. Each vertex
// is normalised and warped with w = 1, so edges stay straight that should bend, and distance is interpolated
// linearly over the map.

// Twin of `WarpView` in src/compare/baselines/vertex_warp.rs.
struct WarpView {
    // Rows of the rotation from world to hemisphere space.
    right: vec3<f32>,
    range: f32,
    up: vec3<f32>,
    padding_0: u32,
    forward: vec3<f32>,
    padding_1: u32,
    origin: vec3<f32>,
    padding_2: u32,
}

@group(0) @binding(0) var<uniform> view: WarpView;

struct Warped {
    @builtin(position) position: vec4<f32>,
    // Distance in front of the light.
    @location(0) ahead: f32,
}

@vertex
fn vertex(@location(0) local: vec3<f32>, @location(1) instance: u32) -> Warped {
    let relative = world_position(local, instance) - view.origin;
    let x = vec3<f32>(dot(view.right, relative), dot(view.up, relative), dot(view.forward, relative));
    let distance = length(x);
    let d = x / distance;
    // The published division by 1 + z is by zero straight behind the light.
    let p = d.xy / max(1.0 + d.z, 1e-6);
    var result: Warped;
    // Reversed, as all depths here.
    result.position = vec4<f32>(p, 1.0 - distance / view.range, 1.0);
    result.ahead = x.z;
    return result;
}

@fragment
fn fragment(warped: Warped) {
    if warped.ahead < 0.0 {
        discard;
    }
}
