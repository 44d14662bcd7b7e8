// Depth: one hemisphere's view of the triangles and pieces that the stages before have chosen. The hardware
// divides, clips, interpolates and tests; there is no fragment shader.

@vertex
fn depth(@location(0) position: vec3<f32>) -> @invariant @builtin(position) vec4<f32> {
    return dp_caster_position(position);
}

// A corner of a piece, with the piece's shift of 1/w.
@vertex
fn depth_of_piece(@location(0) corner: vec4<f32>) -> @invariant @builtin(position) vec4<f32> {
    let clip = dp_caster_position(corner.xyz);
    return vec4<f32>(clip.xy, clip.z * (1.0 + corner.w * clip.w), clip.w);
}
