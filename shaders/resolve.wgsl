// Resolve: which triangle each texel's depth is of. Who wins a texel among the small ones is known only when all are
// drawn, so the triangles that won one at some time are gone through once more. Before that, by the same way, what the
// culling put off is drawn: masked casters and, where records found no room, large triangles.

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

// How far apart, relatively, the depths may be that this shader and the culling's compute for one texel and triangle, and
// by how much, as the sine of an angle, a texel's direction may miss the triangle: compilers may round each in its own way.
const SAME_DEPTH: f32 = 1e-6;
const SAME_EDGE: f32 = 1e-6;

var<workgroup> parts: u32;
var<workgroup> chosen: array<u32, CHUNK_BITS>;
var<workgroup> wins: array<atomic<u32>, CHUNK_BITS>;

@compute @workgroup_size(THREADS)
fn resolve(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let view = views[group.z];
    if thread == 0u {
        parts = count_parts(view);
    }
    let count = workgroupUniformLoad(&parts);
    for (var i = group.x; i < count; i += groups.x) {
        resolve_part(view, part_at(view, i), group.y, thread);
    }
}

fn list_length(view: View, list: u32) -> u32 {
    return atomicLoad(&state[view.counters + COUNTER_LISTS + list]);
}

fn has_overflown(view: View) -> bool {
    return atomicLoad(&state[view.counters + COUNTER_RECORDS]) > view.record_capacity
        || atomicLoad(&state[view.counters + COUNTER_JOBS]) > view.job_capacity;
}

// Parts of chunks to go through: to draw, those with triangles that were put off; to number, those with triangles that won
// and, after an overflow, those that were put off too.
fn count_parts(view: View) -> u32 {
    let deferred = list_length(view, LIST_DEFERRED);
    if NUMBERS {
        return list_length(view, LIST_DRAWN) + select(0u, deferred, has_overflown(view));
    }
    return deferred;
}

fn part_at(view: View, i: u32) -> u32 {
    let drawn = select(0u, list_length(view, LIST_DRAWN), NUMBERS);
    if i < drawn {
        return atomicLoad(&state[list_of(view, LIST_DRAWN) + i]);
    }
    return atomicLoad(&state[list_of(view, LIST_DEFERRED) + i - drawn]);
}

fn resolve_part(view: View, part: u32, band: u32, thread: u32) {
    let chunk = part / SQUARES;
    let square = part % SQUARES;
    let source = chunk_sources[chunk];
    // Large triangles are the tiles' unless there was no room.
    let is_asked = NUMBERS || (kind(source) & KIND_MASKED) != 0u || has_overflown(view);
    if thread == 0u {
        atomicStore(&queued, 0u);
    }
    for (var word = thread; word < CHUNK_BITS; word += THREADS) {
        let stored = atomicLoad(&state[bits_of(view, part, select(LIST_DEFERRED, LIST_DRAWN, NUMBERS)) + word]);
        chosen[word] = select(0u, stored, is_asked);
        atomicStore(&wins[word], 0u);
    }
    let last = max(vertex_count(source), 1u) - 1u;
    place_corners(view, source, vertices[source.vertex + min(thread, last)].position, square, thread);
    workgroupBarrier();
    let rows = band_of(view, band);
    for (var t = thread; t < triangle_count(source); t += THREADS) {
        if (chosen[t / 32u] & (1u << (t % 32u))) != 0u {
            let box = box_in_band(view, source, t, square, rows);
            if box.high.y >= box.low.y {
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
    if !NUMBERS {
        for (var word = thread; word < CHUNK_BITS; word += THREADS) {
            atomicOr(&state[bits_of(view, part, LIST_DRAWN) + word], atomicLoad(&wins[word]));
        }
    }
}

// First and last row of a band.
fn band_of(view: View, band: u32) -> vec2<i32> {
    let size = (i32(view.resolution) + i32(BANDS) - 1) / i32(BANDS);
    return vec2<i32>(i32(band) * size, min((i32(band) + 1) * size, i32(view.resolution)) - 1);
}

fn box_in_band(view: View, source: ChunkSource, t: u32, square: u32, rows: vec2<i32>) -> Box {
    let local = corners_of(triangles[source.triangle + t]);
    let box = whole_box_of(view, local, square);
    return Box(vec2<i32>(box.low.x, max(box.low.y, rows.x)), vec2<i32>(box.high.x, min(box.high.y, rows.y)));
}

fn resolve_row(view: View, source: ChunkSource, chunk: u32, square: u32, rows: vec2<i32>, row: u32, count: u32) {
    let entry = triangle_of_row(row, count);
    let t = entry & 0xffu;
    let local = corners_of(triangles[source.triangle + t]);
    let triangle = triangle_of(view, local, square);
    if triangle.is_edge_on {
        return;
    }
    let box = box_in_band(view, source, t, square, rows);
    let y = box.low.y + i32(row - (entry >> 8u));
    let v = texel_v(view, f32(y));
    let limits = depth_limits(view.near, corners[local.x], corners[local.y], corners[local.z]);
    let span = row_span(view, triangle, box, y);
    let number = ((chunk << 8u) | t) + 1u;
    var may_win = false;
    for (var x = span.x; x <= span.y; x += 4) {
        // Four at a time, as the culling does.
        let quad = row_texels(view, source, local, triangle, limits, x, span.y, v);
        let at = row_places(view, square, x, y, span.y);
        let stored = vec4<u32>(
            atomicLoad(&depths[at.x]),
            atomicLoad(&depths[at.y]),
            atomicLoad(&depths[at.z]),
            atomicLoad(&depths[at.w]),
        );
        for (var i = 0; i < 4; i += 1) {
            if NUMBERS {
                let depth = bitcast<f32>(stored[i]);
                if quad[i] > 0u && abs(bitcast<f32>(quad[i]) - depth) <= SAME_DEPTH * depth {
                    atomicMax(&numbers[at[i]], number);
                }
            } else if quad[i] > 0u && stored[i] <= quad[i] {
                atomicMax(&depths[at[i]], quad[i]);
                may_win = true;
            }
        }
    }
    if may_win {
        atomicOr(&wins[t / 32u], 1u << (t % 32u));
    }
}

// Bits of the depths of four texels of a row, 0 where the triangle doesn't cover them or the row has ended.
fn row_texels(
    view: View,
    source: ChunkSource,
    local: vec3<u32>,
    triangle: Triangle,
    limits: vec2<f32>,
    x: i32,
    last: i32,
    v: f32,
) -> vec4<u32> {
    var result: vec4<u32>;
    for (var i = 0; i < 4; i += 1) {
        let q = scaled_direction(vec2<f32>(texel_u(view, f32(x + i)), v));
        let z = clamp(dot(triangle.plane, q), limits.x, limits.y);
        let is_covered = select(covers(triangle, q), covers_nearly(triangle, q), NUMBERS);
        if is_covered && is_looked_up(view, q.xy) && z > 0.0 && z <= 1.0 && x + i <= last {
            result[i] = select(bitcast<u32>(z), 0u, is_in_hole(source, local, triangle, q));
        }
    }
    return result;
}

fn covers_nearly(triangle: Triangle, q: vec3<f32>) -> bool {
    let edges = vec3<f32>(dot(triangle.e0, q), dot(triangle.e1, q), dot(triangle.e2, q));
    let lengths = vec3<f32>(length(triangle.e0), length(triangle.e1), length(triangle.e2));
    return all(edges >= -SAME_EDGE * lengths);
}

// Whether a masked triangle has a hole where a ray in the direction q meets it: the corners' shares there are in proportion
// to the products with the planes of the opposite edges.
fn is_in_hole(source: ChunkSource, local: vec3<u32>, triangle: Triangle, q: vec3<f32>) -> bool {
    if (kind(source) & KIND_MASKED) == 0u {
        return false;
    }
    let a = mask_vertices[vertices[source.vertex + local.x].data];
    let b = mask_vertices[vertices[source.vertex + local.y].data];
    let c = mask_vertices[vertices[source.vertex + local.z].data];
    let shares = max(
        vec3<f32>(dot(triangle.e1, q), dot(triangle.e2, q), dot(triangle.e0, q)),
        vec3<f32>(0.0),
    );
    let sum = shares.x + shares.y + shares.z;
    let weights = select(vec3<f32>(1.0, 0.0, 0.0), shares / sum, sum > 0.0);
    return is_hole(mask_at(a.mask), weighted_coordinates(a, b, c, weights));
}
