// Instanced: the vertices of an engine's shadow pass, from mesh space through the instance's transform to one view.

@group(0) @binding(0) var<uniform> view: InstancedView;

@vertex
fn vertex(
    @location(0) local: vec3<f32>,
    @location(1) instance: u32,
) -> @invariant @builtin(position) vec4<f32> {
    return clip_position(view, world_position(local, instance));
}
