// Cull: what of a chunk can't show is left out, what is small is drawn at once, what is large is recorded for the tiles.
// Workgroups along x share the chunks out; those along y, where there are few chunks, each chunk's triangles.

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
override SMALL: i32 = 8;
// Rows of triangles that are put off that make one more band (view.wgsl).
override ROWS_OF_BAND: u32 = 64u;

// Parts to go through: their number, and with PART_CULLS that their triangles that face away don't cast; if the instance
// mirrors its mesh, PART_MIRRORED.
var<workgroup> parts: array<u32, 256>;
var<workgroup> part_count: atomic<u32>;
var<workgroup> part_total: u32;
const PART_CULLS: u32 = 0x80000000u;
const PART_MIRRORED: u32 = 0x40000000u;
const PART_NUMBER: u32 = 0x3fffffffu;

// Triangles of a chunk at most.
const MOST_TRIANGLES: u32 = 256u;

// Large triangles: their places in the chunk, with their first job's place in bits 8-31, and their tiles.
var<workgroup> large: array<u32, 256>;
var<workgroup> large_tiles: array<u32, 256>;
var<workgroup> large_count: atomic<u32>;
var<workgroup> job_count: atomic<u32>;
// Rows of all triangles that are put off.
var<workgroup> deferred_rows: atomic<u32>;
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
    let share = MOST_TRIANGLES / groups.y;
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
            cull_part(view, parts[i], group.y * share, share, thread);
        }
    }
}

// Notes a part if anything of it may show.
fn choose_part(view: View, part: u32) {
    // Both are asked for at once, since what takes time is to wait.
    let source = chunk_sources[part / SQUARES];
    let bounds = chunk_bounds[part / SQUARES];
    if triangle_count(source) == 0u || (view.kinds & (1u << kind(source))) == 0u {
        return;
    }
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

// Goes through a part's triangles from `first` on, at most `share`.
fn cull_part(view: View, entry: u32, first: u32, share: u32, thread: u32) {
    let part = entry & PART_NUMBER;
    let square = part % SQUARES;
    let source = chunk_sources[part / SQUARES];
    let is_masked = (kind(source) & KIND_MASKED) != 0u;
    let position = vertices[source.vertex + min(thread, vertex_count(source) - 1u)].position;
    let early = triangles[source.triangle + min(first + thread, triangle_count(source) - 1u)];
    if thread == 0u {
        atomicStore(&queued, 0u);
        atomicStore(&large_count, 0u);
        atomicStore(&job_count, 0u);
        atomicStore(&deferred_rows, 0u);
    }
    for (var word = thread; word < BITS * PART_BITS; word += THREADS) {
        atomicStore(&bits[word], 0u);
    }
    place_corners(view, source, position, square, thread);
    workgroupBarrier();

    // Sign of the product with the normal of triangles that face away, 0 if that doesn't matter.
    let away = select(0.0, select(1.0, -1.0, (entry & PART_MIRRORED) != 0u), (entry & PART_CULLS) != 0u);
    for (var t = first + thread; t < min(first + share, triangle_count(source)); t += THREADS) {
        var packed = early;
        if t != first + thread {
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
        large_tiles[i] = tiles;
        large[i] |= atomicAdd(&job_count, jobs_of(tiles)) << 8u;
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
    let is_far = !is_near(a, b, c);
    var is_large = is_far;
    var box: Box;
    if !is_far {
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
    set_bit(BITS_DEFERRED, t);
    let rows = select(box.high.y - box.low.y + 1, i32(view.resolution), is_far);
    atomicAdd(&deferred_rows, u32(rows));
    if !is_masked {
        large[atomicAdd(&large_count, 1u)] = t;
    }
}

fn set_bit(kind: u32, t: u32) {
    atomicOr(&bits[kind * PART_BITS + t / 32u], 1u << (t % 32u));
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
    let slack = 3.0 * edge_slack(triangle);
    var may_win = false;
    for (var x = span.x; x <= span.y; x += 4) {
        // Four at a time, since what takes time is to wait for what they hold.
        let at = row_places(view, square, x, y, span.y);
        let stored = stored_depths(at);
        let first = draw_texel(view, triangle, slack, vec2<i32>(x, span.y), v, at.x, stored.x);
        let second = draw_texel(view, triangle, slack, vec2<i32>(x + 1, span.y), v, at.y, stored.y);
        let third = draw_texel(view, triangle, slack, vec2<i32>(x + 2, span.y), v, at.z, stored.z);
        let fourth = draw_texel(view, triangle, slack, vec2<i32>(x + 3, span.y), v, at.w, stored.w);
        may_win = may_win || first || second || third || fourth;
    }
    if may_win {
        set_bit(BITS_DRAWN, t);
    }
}

// Draws a texel; returns whether the triangle may be the one that it has in the end. The number stage may find that it covers
// a texel by a hair, up to `slack`, where this stage doesn't, and who wins must not hang on that.
fn draw_texel(
    view: View,
    triangle: Triangle,
    slack: vec3<f32>,
    x: vec2<i32>,
    v: f32,
    at: u32,
    stored: u32,
) -> bool {
    let q = scaled_direction(vec2<f32>(texel_u(view, f32(x.x)), v));
    let z = depth_at(triangle, q);
    let edges = edges_at(triangle, q);
    let is_seen = all(edges >= -slack) && is_looked_up(view, q.xy) && z > 0.0 && z <= 1.0 && x.x <= x.y;
    if is_seen && all(edges >= vec3<f32>(0.0)) && bitcast<u32>(z) > stored {
        atomicMax(&depths[at], bitcast<u32>(z));
    }
    return is_seen && may_be_numbered(triangle, z, bitcast<f32>(stored));
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

// Jobs of a record: rows of blocks of its tiles.
fn jobs_of(tiles: u32) -> u32 {
    let rows = block_rows(tiles);
    return select(rows.y - rows.x + 1u, 0u, is_narrow(tiles));
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
        count += countOneBits(atomicLoad(&bits[BITS_DRAWN * PART_BITS + word]) & mask);
    }
    return count;
}

// Writes a part's `i`th large triangle. Without room for all, the item's large triangles are drawn another way
// (resolve.wgsl).
fn record_large(view: View, source: ChunkSource, part: u32, i: u32) {
    let t = large[i] & 0xffu;
    let first_row = block_rows(large_tiles[i]).x;
    let jobs = jobs_of(large_tiles[i]);
    let record = bases.x + i;
    let job = bases.y + (large[i] >> 8u);
    if record >= view.record_capacity || job + jobs > view.job_capacity {
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
    for (var k = 0u; k < jobs; k += 1u) {
        lists[view.first_job + job + k] = (record << 5u) | (first_row + k);
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
            if (atomicLoad(&bits[BITS_DRAWN * PART_BITS + t / 32u]) & (1u << (t % 32u))) != 0u {
                lists[first + winners_before(t)] = number_of(part / SQUARES, t) | ((part % SQUARES) << SQUARE_SHIFT);
            }
        }
        return;
    }
    // What is left of the list stays empty.
    for (var place = bases.z + thread; place < view.winner_capacity; place += THREADS) {
        lists[view.first_winner + place] = 0u;
    }
    note_bits(view, part, MOST_BANDS, BITS_DRAWN, LIST_DRAWN, thread);
}

// Hands on what is drawn later: masked triangles, and large ones in case that there isn't room for all.
fn note_deferred(view: View, part: u32, is_masked: bool, thread: u32) {
    let rows = atomicLoad(&deferred_rows);
    if rows > 0u && (is_masked || (view.flags & FLAG_OVERFLOWS) != 0u) {
        let bands = min(1u + rows / ROWS_OF_BAND, MOST_BANDS);
        note_bits(view, part, bands, BITS_DEFERRED, select(LIST_LARGE, LIST_MASKED, is_masked), thread);
    }
}

fn note_bits(view: View, part: u32, bands: u32, kind: u32, list: u32, thread: u32) {
    for (var word = thread; word < PART_BITS; word += THREADS) {
        atomicStore(&state[bits_of(view, part, kind) + word], atomicLoad(&bits[kind * PART_BITS + word]));
    }
    if thread == 0u {
        let place = atomicAdd(&state[view.counters + COUNTER_LISTS + list], 1u);
        atomicStore(&state[list_of(view, list) + place], part | ((bands - 1u) << BANDS_SHIFT));
        atomicMax(&state[view.counters + COUNTER_BANDS], bands);
    }
}
