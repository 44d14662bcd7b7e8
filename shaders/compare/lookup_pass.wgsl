// A pass over the whole screen that asks a lookup at recorded positions and normals, as deferred renderers do.

@group(1) @binding(0) var positions: texture_2d<f32>;
@group(1) @binding(1) var normals: texture_2d<f32>;

// One triangle around the screen.
@vertex
fn screen(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32(index & 1u), f32(index >> 1u));
    return vec4<f32>(4.0 * corner - 1.0, 0.0, 1.0);
}

@fragment
fn shade(@builtin(position) at: vec4<f32>) -> @location(0) f32 {
    let pixel = vec2<i32>(at.xy);
    let position = textureLoad(positions, pixel, 0).xyz;
    let normal = textureLoad(normals, pixel, 0).xyz;
    return EXPRESSION;
}
