// Cull: what of a chunk can't show is left out, what is small is drawn at once, what is large is recorded for the tiles.

@group(0) @binding(0) var<uniform> views: array<View, MOST_ITEMS>;
@group(0) @binding(1) var<storage, read> chunk_sources: array<ChunkSource>;
@group(0) @binding(2) var<storage, read> chunk_bounds: array<ChunkBounds>;
@group(0) @binding(3) var<storage, read> triangles: array<u32>;
@group(0) @binding(4) var<storage, read> vertices: array<CasterVertex>;
// Greatest depth of each texel, as the bits of a float.
@group(0) @binding(5) var<storage, read_write> depths: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> records: array<vec4<u32>>;
// Jobs of the binning, then the numbers of the triangles that won a texel when they were drawn small.
@group(0) @binding(7) var<storage, read_write> lists: array<u32>;
// Each item's counters, then the bits of all parts.
@group(0) @binding(8) var<storage, read_write> state: array<atomic<u32>>;

// Leaving out what can't change the map; off only to prove that it can't.
override REJECT: bool = true;
// Texels along a side of the largest box that is drawn at once.
override SMALL: i32 = 6;

// Parts to go through: their number, and with PART_CULLS that their triangles that face away don't cast; if the instance
// mirrors its mesh, PART_MIRRORED.
var<workgroup> parts: array<u32, 256>;
var<workgroup> part_count: atomic<u32>;
var<workgroup> part_total: u32;
const PART_CULLS: u32 = 0x80000000u;
const PART_MIRRORED: u32 = 0x40000000u;
const PART_NUMBER: u32 = 0x3fffffffu;

// Large triangles: their places in the chunk, with their first job's place in bits 8-31, and their tiles.
var<workgroup> large: array<u32, 256>;
var<workgroup> large_tiles: array<u32, 256>;
var<workgroup> large_count: atomic<u32>;
var<workgroup> job_count: atomic<u32>;
// Where the part's records, jobs and winners go.
var<workgroup> bases: vec3<u32>;
// Bits of the triangles that win, and of those that are put off.
var<workgroup> bits: array<atomic<u32>, 16>;

@compute @workgroup_size(THREADS)
fn cull(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let view = views[group.z];
    let end = SQUARES * view.end_chunk;
    // Each thread looks at a part, and then all threads go through those that are left, one by one.
    for (var start = group.x; start < end; start += groups.x * THREADS) {
        if thread == 0u {
            atomicStore(&part_count, 0u);
        }
        workgroupBarrier();
        let part = start + groups.x * thread;
        if part < end {
            choose_part(view, part);
        }
        workgroupBarrier();
        if thread == 0u {
            part_total = atomicLoad(&part_count);
        }
        let count = workgroupUniformLoad(&part_total);
        for (var i = 0u; i < count; i += 1u) {
            cull_part(view, parts[i], thread);
        }
    }
}

// Notes a part if anything of it may show.
fn choose_part(view: View, part: u32) {
    let source = chunk_sources[part / SQUARES];
    if triangle_count(source) == 0u || (view.kinds & (1u << kind(source))) == 0u {
        return;
    }
    let bounds = chunk_bounds[part / SQUARES];
    let low = bounds.min - view.position;
    let high = bounds.max - view.position;
    let nearest = max(max(low, -high), vec3<f32>(0.0));
    if dot(nearest, nearest) > view.range * view.range {
        return;
    }
    let culls = culls(view, source, bounds);
    if (squares_of(view, low, high) & (1u << (part % SQUARES))) == 0u || (culls && faces_away(bounds, view.position)) {
        return;
    }
    let flags = select(0u, PART_CULLS, culls) | select(0u, PART_MIRRORED, bounds.handedness < 0.0);
    parts[atomicAdd(&part_count, 1u)] = part | flags;
}

// Whether triangles that face away don't cast, or can't be seen to.
fn culls(view: View, source: ChunkSource, bounds: ChunkBounds) -> bool {
    // Outside by more than this, nothing of a closed piece is clipped, so a front face hides every back face.
    let near = view.near * LONGEST_DIRECTION;
    let is_outside = any(view.position < bounds.pieces_min - near) || any(view.position > bounds.pieces_max + near);
    return culling(source) == CULL_ALWAYS || (culling(source) == CULL_CLOSED && REJECT && is_outside);
}

fn cull_part(view: View, entry: u32, thread: u32) {
    let part = entry & PART_NUMBER;
    let square = part % SQUARES;
    let source = chunk_sources[part / SQUARES];
    let is_masked = (kind(source) & KIND_MASKED) != 0u;
    // All that a thread needs is asked for at once, since what takes time is to wait.
    let position = vertices[source.vertex + min(thread, vertex_count(source) - 1u)].position;
    let early = triangles[source.triangle + min(thread, triangle_count(source) - 1u)];
    if thread == 0u {
        atomicStore(&queued, 0u);
        atomicStore(&large_count, 0u);
        atomicStore(&job_count, 0u);
    }
    for (var word = thread; word < LISTS * PART_BITS; word += THREADS) {
        atomicStore(&bits[word], 0u);
    }
    place_corners(view, source, position, square, thread);
    workgroupBarrier();

    // Sign of the product with the normal of triangles that face away, 0 if that doesn't matter.
    let away = select(0.0, select(1.0, -1.0, (entry & PART_MIRRORED) != 0u), (entry & PART_CULLS) != 0u);
    for (var t = thread; t < triangle_count(source); t += THREADS) {
        var packed = early;
        if t != thread {
            packed = triangles[source.triangle + t];
        }
        sort_triangle(view, t, corners_of(packed), is_masked, away);
    }
    workgroupBarrier();

    let rows = atomicLoad(&queued);
    for (var row = thread; row < (rows >> 9u); row += THREADS) {
        draw_row(view, source, square, row, rows & 0x1ffu);
    }
    let larges = atomicLoad(&large_count);
    for (var i = thread; i < larges; i += THREADS) {
        let tiles = tiles_of(view, source, large[i], square);
        let block_rows = block_rows(tiles);
        large_tiles[i] = tiles;
        large[i] |= atomicAdd(&job_count, block_rows.y - block_rows.x + 1u) << 8u;
    }
    workgroupBarrier();
    if thread == 0u {
        bases = reserve(view, larges);
    }
    workgroupBarrier();
    for (var i = thread; i < larges; i += THREADS) {
        record_large(view, source, part, i);
    }
    note_winners(view, part, thread);
    note_deferred(view, part, is_masked, thread);
    workgroupBarrier();
}

// Whether a triangle is left out, drawn at once, or recorded.
fn sort_triangle(view: View, t: u32, local: vec3<u32>, is_masked: bool, away: f32) {
    let a = placed(local.x);
    let b = placed(local.y);
    let c = placed(local.z);
    if is_outside(view, a, b, c) {
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
    if away != 0.0 {
        let n = triangle_normal(a.place, b.place, c.place);
        if dot(n, a.place) * away > 1e-6 * length(n) * length(a.place) {
            return;
        }
    }
    if !is_masked && !is_large {
        enqueue(t, u32(box.high.y - box.low.y + 1));
        return;
    }
    set_bit(LIST_DEFERRED, t);
    if !is_masked {
        large[atomicAdd(&large_count, 1u)] = t;
    }
}

fn set_bit(list: u32, t: u32) {
    atomicOr(&bits[list * PART_BITS + t / 32u], 1u << (t % 32u));
}

fn draw_row(view: View, source: ChunkSource, square: u32, row: u32, count: u32) {
    let entry = triangle_of_row(row, count);
    let t = entry & 0xffu;
    let local = corners_of(triangles[source.triangle + t]);
    let triangle = placed_triangle(view, source, local, square);
    if triangle.is_edge_on {
        return;
    }
    let box = box_of(view, placed(local.x), placed(local.y), placed(local.z));
    let y = box.low.y + i32(row - (entry >> 8u));
    let v = texel_v(view, f32(y));
    let span = row_span(view, triangle, box, y);
    var may_win = false;
    for (var x = span.x; x <= span.y; x += 4) {
        // Four at a time, since what takes time is to wait for what they hold.
        let quad = row_texels(view, triangle, x, span.y, v);
        let at = row_places(view, square, x, y, span.y);
        let stored = stored_depths(at);
        for (var i = 0; i < 4; i += 1) {
            if quad[i] > stored[i] {
                atomicMax(&depths[at[i]], quad[i]);
            }
            may_win = may_win || (quad[i] > 0u && may_be_numbered(triangle, bitcast<f32>(quad[i]), bitcast<f32>(stored[i])));
        }
    }
    if may_win {
        set_bit(LIST_DRAWN, t);
    }
}

// Bits of the depths of four texels of a row, 0 where the triangle doesn't cover them or the row has ended.
fn row_texels(view: View, triangle: Triangle, x: i32, last: i32, v: f32) -> vec4<u32> {
    var result: vec4<u32>;
    for (var i = 0; i < 4; i += 1) {
        let q = scaled_direction(vec2<f32>(texel_u(view, f32(x + i)), v));
        let z = depth_at(triangle, q);
        let is_drawn = covers(triangle, q) && is_looked_up(view, q.xy) && z > 0.0 && z <= 1.0 && x + i <= last;
        result[i] = select(0u, bitcast<u32>(z), is_drawn);
    }
    return result;
}

// The tiles that a large triangle may touch: first x, first y, last x, last y, a byte each.
fn tiles_of(view: View, source: ChunkSource, t: u32, square: u32) -> u32 {
    let local = corners_of(triangles[source.triangle + t]);
    let triangle = placed_triangle(view, source, local, square);
    let box = whole_box_of(view, placed(local.x), placed(local.y), placed(local.z), triangle);
    let low = vec2<u32>(min(box.low / TILE, vec2<i32>(i32(view.across) - 1)));
    let high = vec2<u32>(max(box.high, vec2<i32>(0)) / TILE);
    return low.x | (low.y << 8u) | (high.x << 16u) | (high.y << 24u);
}

// First and last row of blocks of a record's tiles.
fn block_rows(tiles: u32) -> vec2<u32> {
    return ((vec2<u32>(tiles) >> vec2<u32>(8u, 24u)) & vec2<u32>(0xffu)) / BLOCK;
}

// Reserves places for a part's records, jobs and winners.
fn reserve(view: View, larges: u32) -> vec3<u32> {
    let winners = winners_before(256u);
    var result: vec3<u32>;
    if larges > 0u {
        result.x = atomicAdd(&state[view.counters + COUNTER_RECORDS], larges);
        result.y = atomicAdd(&state[view.counters + COUNTER_JOBS], atomicLoad(&job_count));
    }
    if winners > 0u {
        result.z = atomicAdd(&state[view.counters + COUNTER_WINNERS], winners);
    }
    return result;
}

// Winners among the first triangles of the chunk.
fn winners_before(t: u32) -> u32 {
    var count = 0u;
    for (var word = 0u; word < PART_BITS; word += 1u) {
        // Bits of the word that count: none, some, or all.
        let wanted = clamp(i32(t) - i32(32u * word), 0, 32);
        let mask = select((1u << u32(wanted)) - 1u, 0xffffffffu, wanted == 32);
        count += countOneBits(atomicLoad(&bits[LIST_DRAWN * PART_BITS + word]) & mask);
    }
    return count;
}

// Writes a part's `i`th large triangle. Without room for all, the item's large triangles are drawn another way
// (resolve.wgsl).
fn record_large(view: View, source: ChunkSource, part: u32, i: u32) {
    let t = large[i] & 0xffu;
    let rows = block_rows(large_tiles[i]);
    let record = bases.x + i;
    let job = bases.y + (large[i] >> 8u);
    if record >= view.record_capacity || job + rows.y - rows.x >= view.job_capacity {
        return;
    }
    let local = corners_of(triangles[source.triangle + t]);
    let square = part % SQUARES;
    let triangle = placed_triangle(view, source, local, square);
    let number = number_of(part / SQUARES, t);
    let at = (view.first_record + record) * RECORD;
    // Seen edge-on it has no tiles.
    let tiles = select(large_tiles[i], 0x0000ffffu, triangle.is_edge_on);
    records[at] = vec4<u32>(bitcast<vec3<u32>>(unit(triangle.e0)), number | (square << SQUARE_SHIFT));
    records[at + 1u] = vec4<u32>(bitcast<vec3<u32>>(unit(triangle.e1)), tiles);
    records[at + 2u] = vec4<u32>(bitcast<vec3<u32>>(unit(triangle.e2)), bitcast<u32>(triangle.limits.x));
    records[at + 3u] = vec4<u32>(bitcast<vec3<u32>>(triangle.plane), bitcast<u32>(triangle.limits.y));
    for (var row = rows.x; row <= rows.y; row += 1u) {
        lists[view.first_job + job + row - rows.x] = (record << 5u) | row;
    }
}

fn unit(e: vec3<f32>) -> vec3<f32> {
    let square = dot(e, e);
    return select(vec3<f32>(0.0), e * inverseSqrt(square), square > 0.0);
}

// Hands on the triangles that won a texel when they were drawn, or their bits where the list is full.
fn note_winners(view: View, part: u32, thread: u32) {
    let count = winners_before(256u);
    if count == 0u {
        return;
    }
    let first = view.first_winner + bases.z;
    if bases.z + count <= view.winner_capacity {
        for (var t = thread; t < 256u; t += THREADS) {
            if (atomicLoad(&bits[LIST_DRAWN * PART_BITS + t / 32u]) & (1u << (t % 32u))) != 0u {
                lists[first + winners_before(t)] = number_of(part / SQUARES, t) | ((part % SQUARES) << SQUARE_SHIFT);
            }
        }
        return;
    }
    // What is left of the list stays empty.
    for (var place = bases.z + thread; place < view.winner_capacity; place += THREADS) {
        lists[view.first_winner + place] = 0u;
    }
    note_bits(view, part, LIST_DRAWN, thread);
}

// Hands on what is drawn later: masked triangles, and large ones in case that there isn't room for all.
fn note_deferred(view: View, part: u32, is_masked: bool, thread: u32) {
    if is_masked || ((view.flags & FLAG_OVERFLOWS) != 0u && atomicLoad(&large_count) > 0u) {
        note_bits(view, part, LIST_DEFERRED, thread);
    }
}

fn note_bits(view: View, part: u32, list: u32, thread: u32) {
    for (var word = thread; word < PART_BITS; word += THREADS) {
        atomicStore(&state[bits_of(view, part, list) + word], atomicLoad(&bits[list * PART_BITS + word]));
    }
    if thread == 0u {
        let place = atomicAdd(&state[view.counters + COUNTER_LISTS + list], 1u);
        atomicStore(&state[list_of(view, list) + place], part);
    }
}
