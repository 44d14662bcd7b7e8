// Depth: one hemisphere's view of the triangles and pieces that the stages before have chosen. The hardware
// divides, clips, interpolates and tests; there is no fragment shader.

@vertex
fn depth(@location(0) position: vec3<f32>) -> @invariant @builtin(position) vec4<f32> {
    return dp_caster_position(position);
}

// A corner of a piece, with its shift of 1/w.
@vertex
fn depth_of_piece(@location(0) corner: vec4<f32>) -> @invariant @builtin(position) vec4<f32> {
    return clip_position_of_piece(corner.xyz, corner.w);
}

fn clip_position_of_piece(corner: vec3<f32>, shift: f32) -> vec4<f32> {
    let clip = dp_caster_position(corner);
    return vec4<f32>(clip.xy, clip.z * (1.0 + shift * clip.w), clip.w);
}
