// Multiview: as instanced.wgsl, for all six faces of a cube in one pass.

@group(0) @binding(0) var<uniform> views: array<InstancedView, 6>;

@vertex
fn vertex(
    @location(0) local: vec3<f32>,
    @location(1) instance: u32,
    @builtin(view_index) face: u32,
) -> @invariant @builtin(position) vec4<f32> {
    return clip_position(views[face], world_position(local, instance));
}
