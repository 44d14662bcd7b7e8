// Resolve: draws what the culling put off, masked casters and, where records found no room, large triangles; and numbers
// their texels, and those of triangles that found no room among the winners.

@group(0) @binding(0) var<uniform> views: array<View, MOST_ITEMS>;
@group(0) @binding(1) var<storage, read> chunk_sources: array<ChunkSource>;
@group(0) @binding(2) var<storage, read> triangles: array<u32>;
@group(0) @binding(3) var<storage, read> vertices: array<CasterVertex>;
@group(0) @binding(4) var<storage, read_write> depths: array<atomic<u32>>;
// The greatest number, with one added, of the triangles that have a texel's depth.
@group(0) @binding(5) var<storage, read_write> numbers: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> state: array<atomic<u32>>;

// Numbers texels; else draws what was put off.
override NUMBERS: bool = true;

// Threads that share a row, as waiting is what takes time.
override LANES: u32 = 8u;

var<workgroup> share_total: u32;
var<workgroup> own_share: Share;
var<workgroup> chosen: array<u32, PART_BITS>;

// A band of a part.
struct Share {
    part: u32,
    // Which of its bits are asked for.
    kind: u32,
    band: u32,
    bands: u32,
}

@compute @workgroup_size(THREADS)
fn resolve(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let view = views[group.z];
    if thread == 0u {
        share_total = count_parts(view) * atomicLoad(&state[view.counters + COUNTER_BANDS]);
    }
    let count = workgroupUniformLoad(&share_total);
    for (var i = group.x; i < count; i += groups.x) {
        if thread == 0u {
            own_share = share_of(view, i);
        }
        let share = workgroupUniformLoad(&own_share);
        if share.band < share.bands {
            resolve_share(view, share, thread);
        }
    }
}

fn list_length(view: View, list: u32) -> u32 {
    return atomicLoad(&state[view.counters + COUNTER_LISTS + list]);
}

fn has_overflown(view: View) -> bool {
    return atomicLoad(&state[view.counters + COUNTER_RECORDS]) > view.record_capacity
        || atomicLoad(&state[view.counters + COUNTER_JOBS]) > view.job_capacity;
}

// Parts to go through: those with masked triangles; with large ones, if these found no room; to number, also those that found
// none among the winners.
fn count_parts(view: View) -> u32 {
    let large = select(0u, list_length(view, LIST_LARGE), has_overflown(view));
    return list_length(view, LIST_MASKED) + large + select(0u, list_length(view, LIST_DRAWN), NUMBERS);
}

// The `i`th band of all parts, of which some have fewer.
fn share_of(view: View, i: u32) -> Share {
    let parts = count_parts(view);
    let masked = list_length(view, LIST_MASKED);
    let large = select(0u, list_length(view, LIST_LARGE), has_overflown(view));
    var list = LIST_MASKED;
    var place = i % parts;
    if place >= masked + large {
        list = LIST_DRAWN;
        place -= masked + large;
    } else if place >= masked {
        list = LIST_LARGE;
        place -= masked;
    }
    let entry = atomicLoad(&state[list_of(view, list) + place]);
    let kind = select(BITS_DEFERRED, BITS_DRAWN, list == LIST_DRAWN);
    return Share(entry & LISTED_PART, kind, i / parts, (entry >> BANDS_SHIFT) + 1u);
}

fn resolve_share(view: View, share: Share, thread: u32) {
    let square = share.part % SQUARES;
    let source = chunk_sources[share.part / SQUARES];
    if thread == 0u {
        atomicStore(&queued, 0u);
    }
    for (var word = thread; word < PART_BITS; word += THREADS) {
        chosen[word] = atomicLoad(&state[bits_of(view, share.part, share.kind) + word]);
    }
    let last = max(vertex_count(source), 1u) - 1u;
    place_corners(view, source, vertices[source.vertex + min(thread, last)].position, square, thread);
    workgroupBarrier();
    
    for (var t = thread; t < triangle_count(source); t += THREADS) {
        if (chosen[t / 32u] & (1u << (t % 32u))) != 0u {
            let local = corners_of(triangles[source.triangle + t]);
            let triangle = placed_triangle(view, source, local, square);
            let box = whole_box_of(view, placed(local.x), placed(local.y), placed(local.z), triangle);
            let first = first_row(box, share);
            if box.high.y >= first && !triangle.is_edge_on {
                enqueue(t, u32(box.high.y - first) / share.bands + 1u);
            }
        }
    }
    workgroupBarrier();
    let all = atomicLoad(&queued);
    for (var i = thread; i < LANES * (all >> 9u); i += THREADS) {
        resolve_row(view, source, share, i / LANES, all & 0x1ffu, i32(i % LANES));
    }
    workgroupBarrier();
}

// A box's first row of a band.
fn first_row(box: Box, share: Share) -> i32 {
    return box.low.y + i32((share.band + share.bands - u32(box.low.y) % share.bands) % share.bands);
}

fn resolve_row(view: View, source: ChunkSource, share: Share, row: u32, count: u32, lane: i32) {
    let square = share.part % SQUARES;
    let entry = triangle_of_row(row, count);
    let t = entry & 0xffu;
    let local = corners_of(triangles[source.triangle + t]);
    let triangle = placed_triangle(view, source, local, square);
    let box = whole_box_of(view, placed(local.x), placed(local.y), placed(local.z), triangle);
    let y = first_row(box, share) + i32((row - (entry >> 8u)) * share.bands);
    let v = texel_v(view, f32(y));
    let span = row_span(view, triangle, box, y);
    let number = number_of(share.part / SQUARES, t);
    for (var x = span.x + 4 * lane; x <= span.y; x += 4 * i32(LANES)) {
        // Four at a time, as the culling does.
        let at = row_places(view, square, x, y, span.y);
        let stored = stored_depths(at);
        resolve_texel(view, source, local, triangle, vec2<i32>(x, span.y), v, at.x, stored.x, number);
        resolve_texel(view, source, local, triangle, vec2<i32>(x + 1, span.y), v, at.y, stored.y, number);
        resolve_texel(view, source, local, triangle, vec2<i32>(x + 2, span.y), v, at.z, stored.z, number);
        resolve_texel(view, source, local, triangle, vec2<i32>(x + 3, span.y), v, at.w, stored.w, number);
    }
}

// Draws or numbers a texel, `x.x`, unless it is past the row's last one, `x.y`.
fn resolve_texel(
    view: View,
    source: ChunkSource,
    local: vec3<u32>,
    triangle: Triangle,
    x: vec2<i32>,
    v: f32,
    at: u32,
    stored: u32,
    number: u32,
) {
    let q = scaled_direction(vec2<f32>(texel_u(view, f32(x.x)), v));
    let z = depth_at(triangle, q);
    var shows = x.x <= x.y && is_looked_up(view, q.xy) && z > 0.0 && z <= 1.0;
    if NUMBERS {
        shows = shows && covers_nearly(triangle, q) && is_same_depth(triangle, z, bitcast<f32>(stored));
    } else {
        shows = shows && covers(triangle, q) && bitcast<u32>(z) > stored;
    }
    // Holes are looked for last, since that is what takes time.
    if !shows || is_in_hole(source, local, triangle, q) {
        return;
    }
    if NUMBERS {
        atomicMax(&numbers[at], number);
    } else {
        atomicMax(&depths[at], bitcast<u32>(z));
    }
}

// Whether a masked triangle has a hole where a ray in the direction q meets it: the corners' shares there are in proportion
// to the products with the planes of the opposite edges.
fn is_in_hole(source: ChunkSource, local: vec3<u32>, triangle: Triangle, q: vec3<f32>) -> bool {
    if (kind(source) & KIND_MASKED) == 0u {
        return false;
    }
    let a = dp_mask_vertex(vertices[source.vertex + local.x].data);
    let b = dp_mask_vertex(vertices[source.vertex + local.y].data);
    let c = dp_mask_vertex(vertices[source.vertex + local.z].data);
    let shares = max(
        vec3<f32>(dot(triangle.e1, q), dot(triangle.e2, q), dot(triangle.e0, q)),
        vec3<f32>(0.0),
    );
    let sum = shares.x + shares.y + shares.z;
    let weights = select(vec3<f32>(1.0, 0.0, 0.0), shares / sum, sum > 0.0);
    return dp_is_hole(a, b, c, weights);
}
