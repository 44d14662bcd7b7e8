// Masked: what depth.wgsl does, for casters with holes. The hardware interpolates texture coordinates as it does depth,
// perspective-correctly under the paraboloid's w; a fragment shader leaves the holes out.

@group(2) @binding(0) var<storage, read> lists: array<u32>;
@group(2) @binding(1) var<storage, read> vertices: array<CasterVertex>;
@group(2) @binding(2) var<storage, read> pieces: array<vec4<f32>>;

struct MaskedVertex {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) coordinates: vec2<f32>,
    @location(1) @interpolate(flat, either) mask: u32,
}

@vertex
fn masked(@location(0) position: vec3<f32>, @location(1) data: u32) -> MaskedVertex {
    let vertex = mask_vertices[data];
    return MaskedVertex(dp_caster_position(position), vec2<f32>(vertex.u, vertex.v), vertex.mask);
}

// A corner of a piece. It has the piece's shift with its first corner, and with its second the triangle that it is of:
// its texture coordinates are found by its place in that.
@vertex
fn masked_piece(@builtin(vertex_index) corner: u32) -> MaskedVertex {
    let first = corner - corner % 3u;
    let at = 3u * u32(pieces[first + 1u].w);
    let a = vertices[lists[at] & VERTEX_MASK];
    let b = vertices[lists[at + 1u] & VERTEX_MASK];
    let c = vertices[lists[at + 2u] & VERTEX_MASK];
    let position = pieces[corner].xyz;
    let weights = barycentrics(
        a.position - dp_hemisphere.light,
        b.position - dp_hemisphere.light,
        c.position - dp_hemisphere.light,
        position,
    );
    let vertex = mask_vertices[a.data];
    let coordinates = weighted_coordinates(vertex, mask_vertices[b.data], mask_vertices[c.data], weights);
    return MaskedVertex(clip_position_of_piece(position, pieces[first].w), coordinates, vertex.mask);
}

@fragment
fn cut_out(vertex: MaskedVertex) {
    if is_hole(masks[vertex.mask], vertex.coordinates) {
        discard;
    }
}
