// Masks: where masked casters have holes. Alpha is sampled bilinearly at the texture's finest level, as its own sampler
// does it close by. All of it lies in the mesh records, which `dp_mesh_record` reads.

// What a vertex of a masked mesh has beside its position, a record.
struct DpMaskVertex {
    coordinates: vec2<f32>,
    // Record of its mask.
    mask: u32,
    // Of deforming meshes its place among the positions that the caller writes.
    source: u32,
}

// A record.
struct DpMask {
    // First word of its alphas: four bytes a word, rows begin with a word of their own.
    first: u32,
    // Width in bits 0-15, height in bits 16-31, in texels.
    size: u32,
    // Least alpha that casts, in 255ths.
    cutoff: f32,
    // How coordinates go on past the texture, across in bits 0-1 and down in bits 2-3.
    address_modes: u32,
}

const DP_REPEAT: u32 = 1u;
const DP_MIRROR_REPEAT: u32 = 2u;

fn dp_mask_vertex(place: u32) -> DpMaskVertex {
    let record = dp_mesh_record(place);
    return DpMaskVertex(bitcast<vec2<f32>>(record.xy), record.z, record.w);
}

fn dp_mask(place: u32) -> DpMask {
    let record = dp_mesh_record(place);
    return DpMask(record.x, record.y, bitcast<f32>(record.z), record.w);
}

// Whether the triangle of three vertices has a hole where these are its corners' shares.
fn dp_is_hole(a: DpMaskVertex, b: DpMaskVertex, c: DpMaskVertex, shares: vec3<f32>) -> bool {
    return dp_mask_margin(a, b, c, shares) < 0.0;
}

// By how much alpha is above the cutoff there, in 255ths.
fn dp_mask_margin(a: DpMaskVertex, b: DpMaskVertex, c: DpMaskVertex, shares: vec3<f32>) -> f32 {
    let coordinates = a.coordinates * shares.x + b.coordinates * shares.y + c.coordinates * shares.z;
    let mask = dp_mask(a.mask);
    let modes = vec2<u32>(mask.address_modes & 3u, mask.address_modes >> 2u);
    let size = vec2<i32>(vec2<u32>(mask.size & 0xffffu, mask.size >> 16u));
    let inside = vec2<f32>(dp_one_period(coordinates.x, modes.x), dp_one_period(coordinates.y, modes.y));
    let at = inside * vec2<f32>(size) - 0.5;
    let low = floor(at);
    let left = dp_mask_texel(i32(low.x), size.x, modes.x);
    let right = dp_mask_texel(i32(low.x) + 1, size.x, modes.x);
    let above = dp_mask_texel(i32(low.y), size.y, modes.y);
    let below = dp_mask_texel(i32(low.y) + 1, size.y, modes.y);
    let share = at - low;
    let upper = dp_between(dp_alpha(mask, left, above), dp_alpha(mask, right, above), share.x);
    let lower = dp_between(dp_alpha(mask, left, below), dp_alpha(mask, right, below), share.x);
    return dp_between(upper, lower, share.y) - mask.cutoff;
}

// Keeps the bits of `a` where `b` is the same, so that an even alpha is on one side of the cutoff.
fn dp_between(a: f32, b: f32, share: f32) -> f32 {
    return a + (b - a) * share;
}

// A coordinate of the same texel within what the texture repeats after, so that it fits an integer.
fn dp_one_period(coordinate: f32, mode: u32) -> f32 {
    switch mode {
        case DP_REPEAT: {
            return coordinate - floor(coordinate);
        }
        case DP_MIRROR_REPEAT: {
            return coordinate - 2.0 * floor(0.5 * coordinate);
        }
        default: {
            return clamp(coordinate, 0.0, 1.0);
        }
    }
}

// The texel at a place up to one past the period.
fn dp_mask_texel(place: i32, size: i32, mode: u32) -> u32 {
    switch mode {
        case DP_REPEAT: {
            return u32((place + size) % size);
        }
        case DP_MIRROR_REPEAT: {
            return u32(clamp(select(place, 2 * size - 1 - place, place >= size), 0, size - 1));
        }
        default: {
            return u32(clamp(place, 0, size - 1));
        }
    }
}

// Alpha of a texel, in 255ths.
fn dp_alpha(mask: DpMask, column: u32, row: u32) -> f32 {
    let words = ((mask.size & 0xffffu) + 3u) / 4u;
    let place = mask.first + row * words + column / 4u;
    let word = dp_mesh_record(place / 4u)[place % 4u];
    return f32((word >> (8u * (column % 4u))) & 0xffu);
}
