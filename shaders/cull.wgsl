// Cull: what of a chunk can't show is left out, what is small is drawn at once, what is large is recorded for the tiles.

@group(0) @binding(0) var<uniform> views: array<View, MOST_ITEMS>;
@group(0) @binding(1) var<storage, read> chunk_sources: array<ChunkSource>;
@group(0) @binding(2) var<storage, read> chunk_bounds: array<ChunkBounds>;
@group(0) @binding(3) var<storage, read> triangles: array<u32>;
@group(0) @binding(4) var<storage, read> vertices: array<CasterVertex>;
// Greatest depth of each texel, as the bits of a float.
@group(0) @binding(5) var<storage, read_write> depths: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> records: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read_write> jobs: array<u32>;
// Each item's counters, then the bits of all chunks.
@group(0) @binding(8) var<storage, read_write> state: array<atomic<u32>>;

// Leaving out what can't change the map; off only to prove that it can't.
override REJECT: bool = true;
// Texels along a side of the largest box that is drawn at once.
override SMALL: i32 = 12;

var<workgroup> large: array<u32, 256>;
var<workgroup> large_count: atomic<u32>;
var<workgroup> job_count: atomic<u32>;
var<workgroup> record_base: u32;
var<workgroup> job_base: u32;
var<workgroup> large_tiles: array<u32, 256>;
var<workgroup> bits: array<atomic<u32>, 16>;
// Whether there are bits in either list.
var<workgroup> has_bits: array<atomic<u32>, 2>;

@compute @workgroup_size(THREADS)
fn cull(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let view = views[group.z];
    let last = max(view.end_chunk, 1u) - 1u;
    var next_source = chunk_sources[min(group.x, last)];
    var next_bounds = chunk_bounds[min(group.x, last)];
    for (var chunk = group.x; chunk < view.end_chunk; chunk += groups.x) {
        // The next chunk is asked for while this one is dealt with, since what takes time is to wait.
        let source = next_source;
        let bounds = next_bounds;
        next_source = chunk_sources[min(chunk + groups.x, last)];
        next_bounds = chunk_bounds[min(chunk + groups.x, last)];
        let rule = culling_rule(view, source, bounds);
        let faces_away = rule != 0u && faces_away(bounds, view.position);
        let squares = select(squares_of_chunk(view, source, bounds), 0u, faces_away);
        if (squares & (1u << group.y)) != 0u {
            let vertex = vertices[source.vertex + min(thread, vertex_count(source) - 1u)].position;
            let packed = triangles[source.triangle + min(thread, triangle_count(source) - 1u)];
            cull_chunk(view, chunk, source, bounds, rule, vertex, packed, group.y, thread);
        }
    }
}

// The maps that the chunk may be seen in, as bits; none if it is unused, of another kind or out of range.
fn squares_of_chunk(view: View, source: ChunkSource, bounds: ChunkBounds) -> u32 {
    if triangle_count(source) == 0u || (view.kinds & (1u << kind(source))) == 0u {
        return 0u;
    }
    let low = bounds.min - view.position;
    let high = bounds.max - view.position;
    let nearest = max(max(low, -high), vec3<f32>(0.0));
    if dot(nearest, nearest) > view.range * view.range {
        return 0u;
    }
    return squares_of(view, low, high);
}

// What is done with triangles that face away: CULL_CLOSED, CULL_ALWAYS or 0.
fn culling_rule(view: View, source: ChunkSource, bounds: ChunkBounds) -> u32 {
    let rule = culling(source);
    if rule != CULL_CLOSED {
        return rule;
    }
    // Outside by more than near, nothing of a closed piece is clipped, so a front face hides every back face.
    let outside = any(view.position < bounds.pieces_min - view.near)
        || any(view.position > bounds.pieces_max + view.near);
    return select(0u, CULL_CLOSED, REJECT && outside);
}

fn cull_chunk(
    view: View,
    chunk: u32,
    source: ChunkSource,
    bounds: ChunkBounds,
    rule: u32,
    vertex: vec3<f32>,
    early: u32,
    square: u32,
    thread: u32,
) {
    if thread == 0u {
        atomicStore(&queued, 0u);
        atomicStore(&large_count, 0u);
        atomicStore(&job_count, 0u);
    }
    for (var word = thread; word < LISTS * CHUNK_BITS; word += THREADS) {
        atomicStore(&bits[word], 0u);
    }
    for (var list = thread; list < LISTS; list += THREADS) {
        // Masked chunks are drawn later, and get the bits of those that win then.
        atomicStore(&has_bits[list], u32((kind(source) & KIND_MASKED) != 0u));
    }
    place_corners(view, source, vertex, square, thread);
    workgroupBarrier();

    let is_masked = (kind(source) & KIND_MASKED) != 0u;
    let cull = select(0.0, bounds.handedness, rule != 0u);
    for (var t = thread; t < triangle_count(source); t += THREADS) {
        var packed = early;
        if t != thread {
            packed = triangles[source.triangle + t];
        }
        sort_triangle(view, t, corners_of(packed), is_masked, cull);
    }
    workgroupBarrier();

    let all = atomicLoad(&queued);
    for (var row = thread; row < (all >> 9u); row += THREADS) {
        draw_row(view, source, square, row, all & 0x1ffu);
    }
    record_large(view, chunk, source, square, thread, atomicLoad(&large_count));
    workgroupBarrier();
    note_bits(view, SQUARES * chunk + square, thread);
}

// Hands a chunk's bits on, if there are any.
fn note_bits(view: View, part: u32, thread: u32) {
    for (var word = thread; word < LISTS * CHUNK_BITS; word += THREADS) {
        let list = word / CHUNK_BITS;
        if atomicLoad(&has_bits[list]) != 0u {
            atomicStore(&state[bits_of(view, part, list) + word % CHUNK_BITS], atomicLoad(&bits[word]));
            if word % CHUNK_BITS == 0u {
                let place = atomicAdd(&state[view.counters + COUNTER_LISTS + list], 1u);
                atomicStore(&state[list_of(view, list) + place], part);
            }
        }
    }
}

fn set_bit(list: u32, t: u32) {
    atomicOr(&bits[list * CHUNK_BITS + t / 32u], 1u << (t % 32u));
    atomicStore(&has_bits[list], 1u);
}

// Whether a triangle is left out, drawn at once, or recorded. Where `cull` isn't 0, those that face away don't cast; it is
// negative if the instance mirrors its mesh.
fn sort_triangle(view: View, t: u32, local: vec3<u32>, is_masked: bool, cull: f32) {
    let a = corners[local.x];
    let b = corners[local.y];
    let c = corners[local.z];
    if max(a.z, max(b.z, c.z)) < 0.0 {
        return;
    }
    var is_large = !is_near(a, b, c);
    var box: Box;
    if !is_large {
        box = box_of(view, a, b, c);
        let size = box.high - box.low;
        if any(size < vec2<i32>(0)) {
            return;
        }
        is_large = max(size.x, size.y) >= SMALL;
    }
    if cull != 0.0 || is_large {
        let x = relatives[local.x];
        let n = triangle_normal(x, relatives[local.y], relatives[local.z]);
        let d = dot(n, nearest_of(x, relatives[local.y], relatives[local.z]));
        if d == 0.0 || d * cull > 1e-6 * length(n) * length(x) {
            return;
        }
    }
    if is_masked {
        set_bit(LIST_DEFERRED, t);
    } else if is_large {
        set_bit(LIST_DEFERRED, t);
        large[atomicAdd(&large_count, 1u)] = t;
    } else {
        enqueue(t, u32(box.high.y - box.low.y + 1));
    }
}

fn draw_row(view: View, source: ChunkSource, square: u32, row: u32, count: u32) {
    let entry = triangle_of_row(row, count);
    let t = entry & 0xffu;
    let local = corners_of(triangles[source.triangle + t]);
    let triangle = triangle_of(view, local, square);
    if triangle.is_edge_on {
        return;
    }
    let box = box_of(view, corners[local.x], corners[local.y], corners[local.z]);
    let y = box.low.y + i32(row - (entry >> 8u));
    let v = texel_v(view, f32(y));
    let limits = depth_limits(view.near, corners[local.x], corners[local.y], corners[local.z]);
    let span = row_span(view, triangle, box, y);
    var may_win = false;
    for (var x = span.x; x <= span.y; x += 4) {
        // Four at a time, since what takes time is to wait for what they hold.
        let quad = row_texels(view, triangle, limits, x, span.y, v);
        let at = row_places(view, square, x, y, span.y);
        let stored = vec4<u32>(
            atomicLoad(&depths[at.x]),
            atomicLoad(&depths[at.y]),
            atomicLoad(&depths[at.z]),
            atomicLoad(&depths[at.w]),
        );
        for (var i = 0; i < 4; i += 1) {
            if quad[i] > 0u && stored[i] <= quad[i] {
                atomicMax(&depths[at[i]], quad[i]);
                may_win = true;
            }
        }
    }
    if may_win {
        set_bit(LIST_DRAWN, t);
    }
}

// Bits of the depths of four texels of a row, 0 where the triangle doesn't cover them or the row has ended.
fn row_texels(view: View, triangle: Triangle, limits: vec2<f32>, x: i32, last: i32, v: f32) -> vec4<u32> {
    var result: vec4<u32>;
    for (var i = 0; i < 4; i += 1) {
        let q = scaled_direction(vec2<f32>(texel_u(view, f32(x + i)), v));
        let z = clamp(dot(triangle.plane, q), limits.x, limits.y);
        let is_drawn = covers(triangle, q) && is_looked_up(view, q.xy) && z > 0.0 && z <= 1.0 && x + i <= last;
        result[i] = select(0u, bitcast<u32>(z), is_drawn);
    }
    return result;
}

fn record_large(view: View, chunk: u32, source: ChunkSource, square: u32, thread: u32, count: u32) {
    for (var i = thread; i < count; i += THREADS) {
        let tiles = tiles_of(view, source, large[i], square);
        let rows = block_rows(tiles);
        large_tiles[i] = tiles;
        large[i] |= atomicAdd(&job_count, rows.y - rows.x + 1u) << 8u;
    }
    workgroupBarrier();
    if thread == 0u && count > 0u {
        record_base = atomicAdd(&state[view.counters + COUNTER_RECORDS], count);
        job_base = atomicAdd(&state[view.counters + COUNTER_JOBS], atomicLoad(&job_count));
    }
    workgroupBarrier();
    for (var i = thread; i < count; i += THREADS) {
        let record = record_base + i;
        let t = large[i] & 0xffu;
        let rows = block_rows(large_tiles[i]);
        let job = job_base + (large[i] >> 8u);
        // Without room for all, the item's large triangles are drawn another way (resolve.wgsl).
        if record < view.record_capacity && job + rows.y - rows.x < view.job_capacity {
            write_record(view, source, square, record, ((chunk << 8u) | t) + 1u, large_tiles[i], t);
            for (var row = rows.x; row <= rows.y; row += 1u) {
                jobs[view.first_job + job + row - rows.x] = (record << 5u) | row;
            }
        }
    }
}

// First and last row of blocks of a record's tiles.
fn block_rows(tiles: u32) -> vec2<u32> {
    return ((vec2<u32>(tiles) >> vec2<u32>(8u, 24u)) & vec2<u32>(0xffu)) / BLOCK;
}

fn write_record(view: View, source: ChunkSource, square: u32, record: u32, number: u32, tiles: u32, t: u32) {
    let local = corners_of(triangles[source.triangle + t]);
    let triangle = triangle_of(view, local, square);
    let limits = depth_limits(view.near, corners[local.x], corners[local.y], corners[local.z]);
    let at = (view.first_record + record) * RECORD;
    records[at] = vec4<u32>(bitcast<vec3<u32>>(unit(triangle.e0)), number | (square << SQUARE_SHIFT));
    records[at + 1u] = vec4<u32>(bitcast<vec3<u32>>(unit(triangle.e1)), tiles);
    records[at + 2u] = vec4<u32>(bitcast<vec3<u32>>(unit(triangle.e2)), bitcast<u32>(limits.x));
    records[at + 3u] = vec4<u32>(bitcast<vec3<u32>>(triangle.plane), bitcast<u32>(limits.y));
}

fn unit(e: vec3<f32>) -> vec3<f32> {
    let square = dot(e, e);
    return select(vec3<f32>(0.0), e * inverseSqrt(square), square > 0.0);
}

// The tiles that a large triangle may touch: first x, first y, last x, last y, a byte each.
fn tiles_of(view: View, source: ChunkSource, t: u32, square: u32) -> u32 {
    let local = corners_of(triangles[source.triangle + t]);
    let box = whole_box_of(view, local, square);
    let low = vec2<u32>(min(box.low / TILE, vec2<i32>(i32(view.across) - 1)));
    let high = vec2<u32>(max(box.high, vec2<i32>(0)) / TILE);
    return low.x | (low.y << 8u) | (high.x << 16u) | (high.y << 24u);
}
