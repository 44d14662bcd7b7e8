// A pass over the whole screen that asks a lookup at recorded positions and normals, as deferred renderers do: in
// compute, or by a triangle around the screen.

@group(3) @binding(0) var positions: texture_2d<f32>;
@group(3) @binding(1) var normals: texture_2d<f32>;
// Its position, and the angle of a pixel.
@group(3) @binding(2) var<uniform> camera: vec4<f32>;
// Of the compute pass alone.
@group(3) @binding(3) var answers: texture_storage_2d<r32float, write>;

fn answer(at: vec2<i32>) -> f32 {
    let position = textureLoad(positions, at, 0).xyz;
    let normal = textureLoad(normals, at, 0).xyz;
    return EXPRESSION;
}

@compute @workgroup_size(8, 8)
fn light_pixels(@builtin(global_invocation_id) id: vec3<u32>) {
    if all(id.xy < textureDimensions(answers)) {
        textureStore(answers, id.xy, vec4<f32>(answer(vec2<i32>(id.xy))));
    }
}

// One triangle around the screen.
@vertex
fn screen(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32(index & 1u), f32(index >> 1u));
    return vec4<f32>(4.0 * corner - 1.0, 0.0, 1.0);
}

@fragment
fn shade(@builtin(position) at: vec4<f32>) -> @location(0) f32 {
    return answer(vec2<i32>(at.xy));
}
