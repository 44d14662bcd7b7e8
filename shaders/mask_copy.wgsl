// Mask copy: a texture's alpha to bytes, four a word.

@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var<storage, read_write> alphas: array<u32>;
// The word that the first row begins with.
@group(0) @binding(2) var<storage, read> first: u32;

@compute @workgroup_size(8, 8)
fn mask_copy(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(image);
    let words = (size.x + 3u) / 4u;
    if id.x >= words || id.y >= size.y {
        return;
    }
    var alpha = vec4<f32>();
    for (var k = 0u; k < 4u; k += 1u) {
        let column = min(4u * id.x + k, size.x - 1u);
        alpha[k] = textureLoad(image, vec2<u32>(column, id.y), 0).a;
    }
    alphas[first + id.y * words + id.x] = pack4x8unorm(alpha);
}
