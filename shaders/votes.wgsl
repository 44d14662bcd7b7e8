// Votes alone: four texels decide, without the casters' triangles. In place of exact.wgsl.

// What `dp_shadow` answers where the maps have to be asked. The edge is as wide as a texel, whatever a pixel spans.
fn dp_sample_sharp(
    light: u32,
    position: vec3<f32>,
    normal: vec3<f32>,
    view: vec4<f32>,
    receiver: DpReceiver,
) -> f32 {
    return dp_sample_bilinear(light, receiver);
}
