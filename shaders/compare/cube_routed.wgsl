// Depth of a cube's face from triangles that cube_route.wgsl chose, already in world space.

@group(0) @binding(0) var<uniform> view: InstancedView;

@vertex
fn vertex(@location(0) world: vec3<f32>) -> @invariant @builtin(position) vec4<f32> {
    return clip_position(view, world);
}
