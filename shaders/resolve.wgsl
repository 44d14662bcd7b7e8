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
// Bands of rows that workgroups share a map out in.
override BANDS: u32 = 1u;

var<workgroup> part_total: u32;
var<workgroup> chosen: array<u32, PART_BITS>;

@compute @workgroup_size(THREADS)
fn resolve(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let view = views[group.z];
    if thread == 0u {
        part_total = count_parts(view);
    }
    let count = workgroupUniformLoad(&part_total);
    for (var i = group.x; i < count; i += groups.x) {
        resolve_part(view, i, group.y, thread);
    }
}

fn list_length(view: View, list: u32) -> u32 {
    return atomicLoad(&state[view.counters + COUNTER_LISTS + list]);
}

fn has_overflown(view: View) -> bool {
    return atomicLoad(&state[view.counters + COUNTER_RECORDS]) > view.record_capacity
        || atomicLoad(&state[view.counters + COUNTER_JOBS]) > view.job_capacity;
}

// Parts to go through: to draw, those with triangles that were put off; to number, those and the ones that found no room.
fn count_parts(view: View) -> u32 {
    return list_length(view, LIST_DEFERRED) + select(0u, list_length(view, LIST_DRAWN), NUMBERS);
}

fn resolve_part(view: View, i: u32, band: u32, thread: u32) {
    let deferred = list_length(view, LIST_DEFERRED);
    let list = select(LIST_DRAWN, LIST_DEFERRED, i < deferred);
    let part = atomicLoad(&state[list_of(view, list) + select(i - deferred, i, i < deferred)]);
    let chunk = part / SQUARES;
    let square = part % SQUARES;
    let source = chunk_sources[chunk];
    // Large triangles are the tiles' unless there was no room.
    let is_asked = list == LIST_DRAWN || (kind(source) & KIND_MASKED) != 0u || has_overflown(view);
    if thread == 0u {
        atomicStore(&queued, 0u);
    }
    for (var word = thread; word < PART_BITS; word += THREADS) {
        chosen[word] = select(0u, atomicLoad(&state[bits_of(view, part, list) + word]), is_asked);
    }
    let last = max(vertex_count(source), 1u) - 1u;
    place_corners(view, source, vertices[source.vertex + min(thread, last)].position, square, thread);
    workgroupBarrier();
    let rows = band_of(view, band);
    for (var t = thread; t < triangle_count(source); t += THREADS) {
        if (chosen[t / 32u] & (1u << (t % 32u))) != 0u {
            let local = corners_of(triangles[source.triangle + t]);
            let triangle = placed_triangle(view, source, local, square);
            let box = box_in_band(view, local, triangle, rows);
            if box.high.y >= box.low.y && !triangle.is_edge_on {
                enqueue(t, u32(box.high.y - box.low.y + 1));
            }
        }
    }
    workgroupBarrier();
    let all = atomicLoad(&queued);
    for (var row = thread; row < (all >> 9u); row += THREADS) {
        resolve_row(view, source, chunk, square, rows, row, all & 0x1ffu);
    }
    workgroupBarrier();
}

// First and last row of a band.
fn band_of(view: View, band: u32) -> vec2<i32> {
    let size = (i32(view.resolution) + i32(BANDS) - 1) / i32(BANDS);
    return vec2<i32>(i32(band) * size, min((i32(band) + 1) * size, i32(view.resolution)) - 1);
}

fn box_in_band(view: View, local: vec3<u32>, triangle: Triangle, rows: vec2<i32>) -> Box {
    let box = whole_box_of(view, placed(local.x), placed(local.y), placed(local.z), triangle);
    return Box(vec2<i32>(box.low.x, max(box.low.y, rows.x)), vec2<i32>(box.high.x, min(box.high.y, rows.y)));
}

fn resolve_row(view: View, source: ChunkSource, chunk: u32, square: u32, rows: vec2<i32>, row: u32, count: u32) {
    let entry = triangle_of_row(row, count);
    let t = entry & 0xffu;
    let local = corners_of(triangles[source.triangle + t]);
    let triangle = placed_triangle(view, source, local, square);
    let box = box_in_band(view, local, triangle, rows);
    let y = box.low.y + i32(row - (entry >> 8u));
    let v = texel_v(view, f32(y));
    let span = row_span(view, triangle, box, y);
    let number = number_of(chunk, t);
    for (var x = span.x; x <= span.y; x += 4) {
        // Four at a time, as the culling does.
        let quad = row_texels(view, source, local, triangle, x, span.y, v);
        let at = row_places(view, square, x, y, span.y);
        let stored = stored_depths(at);
        for (var i = 0; i < 4; i += 1) {
            if NUMBERS {
                if quad[i] > 0u && is_same_depth(triangle, bitcast<f32>(quad[i]), bitcast<f32>(stored[i])) {
                    atomicMax(&numbers[at[i]], number);
                }
            } else if quad[i] > 0u && stored[i] <= quad[i] {
                atomicMax(&depths[at[i]], quad[i]);
            }
        }
    }
}

// Bits of the depths of four texels of a row, 0 where the triangle doesn't cover them or the row has ended.
fn row_texels(
    view: View,
    source: ChunkSource,
    local: vec3<u32>,
    triangle: Triangle,
    x: i32,
    last: i32,
    v: f32,
) -> vec4<u32> {
    var result: vec4<u32>;
    for (var i = 0; i < 4; i += 1) {
        let q = scaled_direction(vec2<f32>(texel_u(view, f32(x + i)), v));
        let z = depth_at(triangle, q);
        let is_covered = select(covers(triangle, q), covers_nearly(triangle, q), NUMBERS);
        if is_covered && is_looked_up(view, q.xy) && z > 0.0 && z <= 1.0 && x + i <= last {
            result[i] = select(bitcast<u32>(z), 0u, is_in_hole(source, local, triangle, q));
        }
    }
    return result;
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
