// Route: which triangles each hemisphere has to draw, and which have to be split first.
// One workgroup takes one chunk after the other; a vertex is projected once for all its triangles.

@group(0) @binding(0) var<uniform> views: array<View, MOST_JOBS>;
@group(0) @binding(1) var<storage, read_write> arguments: array<Arguments, MOST_JOBS>;
@group(0) @binding(2) var<storage, read> chunk_sources: array<ChunkSource>;
@group(0) @binding(3) var<storage, read> chunk_bounds: array<ChunkBounds>;
@group(0) @binding(4) var<storage, read> triangles: array<u32>;
@group(0) @binding(5) var<storage, read> vertices: array<CasterVertex>;
// A part for each job and hemisphere: what to draw from the front on, what to split from the end on.
@group(0) @binding(6) var<storage, read_write> lists: array<u32>;

// The workgroup's job and its number in the batch.
var<private> view: View;
var<private> job: u32;

// A thread for each vertex and each triangle of a chunk is best where barriers are cheap.
override THREADS: u32 = 256u;

const DROP: u32 = 0u;
const DRAW: u32 = 1u;
const SPLIT: u32 = 2u;
const KIND_MASK: u32 = 3u;
const CULL_SHIFT: u32 = 2u;
const PLACE_SHIFT: u32 = 4u;
const WORDS: u32 = 8u;
// Share of the tolerance that the edges of a triangle drawn whole may bend: depth is off by 4/3 of it at most, and the
// split, which cuts what is above the whole, never cuts the neighbour's side of such an edge, however it rounds.
const WHOLE_SHARE: f32 = 0.375;

// Map coordinates, signed w, and 1 where all triangles around the vertex face away, else 0.
var<workgroup> corners: array<vec4<f32>, 256>;
// Of each triangle its kind in bits 0-1, its list entry's cull flags in 2-3, and from bit 4 on its place among those of
// its kind in its word.
var<workgroup> fates: array<u32, 256>;
// A bit for each triangle that is drawn and that is split, 32 a word; then where those of each word begin in the lists. So
// they keep their order, in which neighbours mostly follow one another: the hardware keeps their vertices.
var<workgroup> drawn: array<atomic<u32>, WORDS>;
var<workgroup> to_split: array<atomic<u32>, WORDS>;
var<workgroup> draw_starts: array<u32, WORDS>;
var<workgroup> split_starts: array<u32, WORDS>;

@compute @workgroup_size(THREADS)
fn route(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    job = group.z;
    // What decides about barriers comes from here, since private variables aren't uniform.
    let own = views[group.z];
    view = own;
    for (var chunk = own.first_chunk + group.x; chunk < own.end_chunk; chunk += groups.x) {
        let dropped = culling_rule(own, chunk) != 0u && faces_away(chunk_bounds[chunk], own.position);
        let hemispheres = select(hemispheres_of(own, chunk), 0u, dropped);
        for (var hemisphere = 0u; hemisphere < 2u; hemisphere += 1u) {
            if (hemispheres & (1u << hemisphere)) != 0u {
                route_chunk(chunk, hemisphere, thread);
            }
        }
    }
}

// The hemispheres that the chunk may be seen in, as bits; none if it is unused, of another kind or out of range.
fn hemispheres_of(view: View, chunk: u32) -> u32 {
    let source = chunk_sources[chunk];
    if triangle_count(source) == 0u || (view.kinds & (1u << kind(source))) == 0u {
        return 0u;
    }
    let low = chunk_bounds[chunk].min - view.position;
    let high = chunk_bounds[chunk].max - view.position;
    let nearest = max(max(low, -high), vec3<f32>(0.0));
    if dot(nearest, nearest) > view.range * view.range {
        return 0u;
    }
    if !REJECT {
        return view.hemispheres;
    }
    // Highest and lowest z of light space in the box, and how far that still is inside a hemisphere.
    let centre = dot(view.forward, 0.5 * (low + high));
    let extent = dot(abs(view.forward), 0.5 * (high - low));
    let farthest = length(max(abs(low), abs(high)));
    let slack = (1e-5 - view.behind) * farthest;
    let front = centre + extent + slack >= 0.0;
    let back = extent - centre + slack >= 0.0;
    return (select(0u, 1u, front) | select(0u, 2u, back)) & view.hemispheres;
}

// What is done with triangles that face away: CULL_CLOSED, CULL_ALWAYS or 0.
fn culling_rule(view: View, chunk: u32) -> u32 {
    let rule = culling(chunk_sources[chunk]);
    if rule != CULL_CLOSED {
        return rule;
    }
    // Outside by more than near, nothing of a closed piece is clipped, so a front face hides every back face.
    let outside = any(view.position < chunk_bounds[chunk].pieces_min - view.near)
        || any(view.position > chunk_bounds[chunk].pieces_max + view.near);
    return select(0u, CULL_CLOSED, REJECT && outside);
}

fn route_chunk(chunk: u32, hemisphere: u32, thread: u32) {
    let source = chunk_sources[chunk];
    for (var word = thread; word < WORDS; word += THREADS) {
        atomicStore(&drawn[word], 0u);
        atomicStore(&to_split[word], 0u);
    }
    for (var v = thread; v < vertex_count(source); v += THREADS) {
        let vertex = vertices[source.vertex + v];
        let corner = project_corner(hemisphere_space(vertex.position - view.position, hemisphere));
        // Only vertices of closed pieces have a cone; of others this says nothing, and isn't asked.
        corners[v] = vec4<f32>(corner, select(0.0, 1.0, all_face_away(vertex, view.position)));
    }
    workgroupBarrier();

    let rule = culling_rule(view, chunk);
    // A face turned to the light is clockwise in the map, since (u, v) is seen from the other side.
    let cull = select(0.0, chunk_bounds[chunk].handedness, rule != 0u);
    for (var t = thread; t < triangle_count(source); t += THREADS) {
        let fate = fate_of(corners_of(triangles[source.triangle + t]), rule, cull);
        if (fate & KIND_MASK) == DRAW {
            atomicOr(&drawn[t / 32u], 1u << (t % 32u));
        } else if (fate & KIND_MASK) == SPLIT {
            atomicOr(&to_split[t / 32u], 1u << (t % 32u));
        }
        fates[t] = fate;
    }
    workgroupBarrier();

    if thread == 0u {
        var draws = 0u;
        var splits = 0u;
        for (var word = 0u; word < WORDS; word += 1u) {
            draw_starts[word] = draws;
            split_starts[word] = splits;
            draws += countOneBits(atomicLoad(&drawn[word]));
            splits += countOneBits(atomicLoad(&to_split[word]));
        }
        let draw_base = atomicAdd(&arguments[job].whole[hemisphere].index_count, 3u * draws) / 3u;
        let split_base = atomicAdd(&arguments[job].to_split[hemisphere], splits);
        for (var word = 0u; word < WORDS; word += 1u) {
            draw_starts[word] += draw_base;
            split_starts[word] += split_base;
        }
    }
    for (var t = thread; t < triangle_count(source); t += THREADS) {
        let is_drawn = (fates[t] & KIND_MASK) == DRAW;
        let alike = select(atomicLoad(&to_split[t / 32u]), atomicLoad(&drawn[t / 32u]), is_drawn);
        fates[t] |= countOneBits(alike & ((1u << (t % 32u)) - 1u)) << PLACE_SHIFT;
    }
    workgroupBarrier();

    let part = 3u * list_start(hemisphere);
    for (var t = thread; t < triangle_count(source); t += THREADS) {
        let fate = fates[t];
        if (fate & KIND_MASK) != DROP {
            let draw_place = draw_starts[t / 32u] + (fate >> PLACE_SHIFT);
            let split_place = split_starts[t / 32u] + (fate >> PLACE_SHIFT);
            let place = select(view.list_capacity - 1u - split_place, draw_place, (fate & KIND_MASK) == DRAW);
            let entry = (corners_of(triangles[source.triangle + t]) + source.vertex) | entry_flags(fate);
            write_entry(part + 3u * place, entry);
        }
    }
}

// The upper bits of a list entry.
fn entry_flags(fate: u32) -> vec3<u32> {
    let culls = (vec3<u32>(fate >> CULL_SHIFT) >> vec3<u32>(0u, 0u, 1u)) & vec3<u32>(0u, 1u, 1u);
    return culls * CULL_FLAG;
}

// Places of a triangle's corners in its chunk.
fn corners_of(packed: u32) -> vec3<u32> {
    return vec3<u32>(packed, packed >> 8u, packed >> 16u) & vec3<u32>(0xffu);
}

// What becomes of a triangle, as `fates` has it. `cull` is the sign of the map area of triangles that
// face away, 0 if that doesn't matter.
fn fate_of(local: vec3<u32>, rule: u32, cull: f32) -> u32 {
    let a = corners[local.x].xyz;
    let b = corners[local.y].xyz;
    let c = corners[local.z].xyz;
    if is_outside(a, b, c) {
        return DROP;
    }
    let bends = edge_bends(a.xy, b.xy, c.xy);
    let x = unprojected(a);
    let y = unprojected(b);
    let z = unprojected(c);
    let slants = vec3<f32>(edge_slant(x, y), edge_slant(y, z), edge_slant(z, x));
    if any(bends * slants > vec3<f32>(WHOLE_SHARE * view.tolerance)) || any(bends > vec3<f32>(view.longest_bend)) {
        // Pieces of a closed piece's triangle are all kept: which of them are next to a turned one isn't known.
        let culls = select(0u, select(1u, 2u, cull < 0.0), rule == CULL_ALWAYS);
        return SPLIT | (culls << CULL_SHIFT);
    }
    // At a silhouette front and back meet, and the rasteriser's snapping decides which is nearer: there the back faces of
    // closed pieces are kept.
    let hidden = rule == CULL_ALWAYS || corners[local.x].w * corners[local.y].w * corners[local.z].w == 1.0;
    if hidden && is_culled(a.xy, b.xy, c.xy, cull) {
        return DROP;
    }
    if REJECT && is_between_texels(a.xy, b.xy, c.xy) {
        return DROP;
    }
    return select(DRAW, SPLIT, any(sliver_shifts(a, b, c) != vec3<f32>()));
}

// Hemisphere space again.
fn unprojected(corner: vec3<f32>) -> vec3<f32> {
    return dp_unproject_scaled(corner.xy) * abs(corner.z);
}

fn write_entry(at: u32, entry: vec3<u32>) {
    lists[at] = entry.x;
    lists[at + 1u] = entry.y;
    lists[at + 2u] = entry.z;
}
