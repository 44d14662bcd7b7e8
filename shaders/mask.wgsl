// Masks: where masked casters have holes. Alpha is sampled bilinearly at the texture's finest level, as its own sampler
// does it close by.

// What a vertex of a masked mesh has beside its position.
struct MaskVertex {
    u: f32,
    v: f32,
    mask: u32,
    // Of deforming meshes its place among the positions that the caller writes.
    source: u32,
}

struct Mask {
    // First word of its alphas: four bytes a word, rows begin with a word of their own.
    first: u32,
    // Width in bits 0-15, height in bits 16-31, in texels.
    size: u32,
    // Least alpha that casts, in 255ths.
    cutoff: f32,
    // How coordinates go on past the texture, across in bits 0-1 and down in bits 2-3.
    address_modes: u32,
}

@group(1) @binding(0) var<storage, read> mask_vertices: array<MaskVertex>;
// Masks, four words each, and the alphas of their textures.
@group(1) @binding(1) var<storage, read> mask_words: array<u32>;

const CLAMP_TO_EDGE: u32 = 0u;
const REPEAT: u32 = 1u;
const MIRROR_REPEAT: u32 = 2u;

fn mask_at(first: u32) -> Mask {
    let cutoff = bitcast<f32>(mask_words[first + 2u]);
    return Mask(mask_words[first], mask_words[first + 1u], cutoff, mask_words[first + 3u]);
}

fn is_hole(mask: Mask, coordinates: vec2<f32>) -> bool {
    let modes = vec2<u32>(mask.address_modes & 3u, mask.address_modes >> 2u);
    let size = vec2<i32>(vec2<u32>(mask.size & 0xffffu, mask.size >> 16u));
    let inside = vec2<f32>(one_period(coordinates.x, modes.x), one_period(coordinates.y, modes.y));
    let at = inside * vec2<f32>(size) - 0.5;
    let low = floor(at);
    let left = texel_place(i32(low.x), size.x, modes.x);
    let right = texel_place(i32(low.x) + 1, size.x, modes.x);
    let above = texel_place(i32(low.y), size.y, modes.y);
    let below = texel_place(i32(low.y) + 1, size.y, modes.y);
    let share = at - low;
    let upper = between(alpha(mask, left, above), alpha(mask, right, above), share.x);
    let lower = between(alpha(mask, left, below), alpha(mask, right, below), share.x);
    return between(upper, lower, share.y) < mask.cutoff;
}

// Keeps the bits of `a` where `b` is the same, so that an even alpha is on one side of the cutoff.
fn between(a: f32, b: f32, share: f32) -> f32 {
    return a + (b - a) * share;
}

// A coordinate of the same texel within what the texture repeats after, so that it fits an integer.
fn one_period(coordinate: f32, mode: u32) -> f32 {
    switch mode {
        case REPEAT: {
            return coordinate - floor(coordinate);
        }
        case MIRROR_REPEAT: {
            return coordinate - 2.0 * floor(0.5 * coordinate);
        }
        default: {
            return clamp(coordinate, 0.0, 1.0);
        }
    }
}

// The texel at a place up to one past the period.
fn texel_place(place: i32, size: i32, mode: u32) -> u32 {
    switch mode {
        case REPEAT: {
            return u32((place + size) % size);
        }
        case MIRROR_REPEAT: {
            return u32(clamp(select(place, 2 * size - 1 - place, place >= size), 0, size - 1));
        }
        default: {
            return u32(clamp(place, 0, size - 1));
        }
    }
}

// Alpha of a texel, in 255ths.
fn alpha(mask: Mask, column: u32, row: u32) -> f32 {
    let words = ((mask.size & 0xffffu) + 3u) / 4u;
    let word = mask_words[mask.first + row * words + column / 4u];
    return f32((word >> (8u * (column % 4u))) & 0xffu);
}

// Texture coordinates by the weights of three vertices.
fn weighted_coordinates(a: MaskVertex, b: MaskVertex, c: MaskVertex, weights: vec3<f32>) -> vec2<f32> {
    return vec2<f32>(a.u, a.v) * weights.x + vec2<f32>(b.u, b.v) * weights.y + vec2<f32>(c.u, c.v) * weights.z;
}
