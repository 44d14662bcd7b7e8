// Rasterise: each texel's greatest depth and the triangle that has it, of what was drawn small and of its tile's large
// triangles. A workgroup takes a tile, a thread PAIRS pairs of it: two texels of a column.

@group(0) @binding(0) var<uniform> views: array<View, MOST_ITEMS>;
@group(0) @binding(1) var<storage, read> records: array<vec4<u32>>;
// Counters of items, and of tiles; these are cleared for the next item.
@group(0) @binding(2) var<storage, read_write> state: array<u32>;
@group(0) @binding(3) var<storage, read> lists: array<u32>;
// Of what was drawn small: depths, and numbers with one added. Cleared for the next item.
@group(0) @binding(4) var<storage, read_write> depths: array<u32>;
@group(0) @binding(5) var<storage, read_write> numbers: array<u32>;
@group(0) @binding(6) var map_depths: texture_storage_2d_array<r32float, write>;
@group(0) @binding(7) var map_numbers: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(8) var static_depths: texture_2d_array<f32>;
@group(0) @binding(9) var static_numbers: texture_2d_array<u32>;
// What the caller has drawn, a layer for each item.
@group(0) @binding(10) var custom_depths: texture_depth_2d_array;

struct TileCounters {
    count: u32,
    // Records to go through: those of its list or, where that lacks room, all.
    entries: u32,
    least: u32,
}

// Whether records go through the workgroup's memory. In software a barrier costs more than it saves.
override BATCHED: bool = true;
// Whether records are gone through four at a time: for maps of few tiles, where what takes time is to wait and not that more
// registers leave room for fewer workgroups.
override IN_FOURS: bool = false;

// PAIRS is put before this text.
const THREADS: u32 = TILE_TEXELS / 2u / PAIRS;
// Records that go through the workgroup's memory at a time.
const BATCH: u32 = 64u;

// Stripes of four rows of a tile: what touches one alone is passed over in the others.
const STRIPES: u32 = 4u;
const PAIRS_OF_STRIPE: u32 = TILE_TEXELS / 2u / STRIPES;

// By how much edges of large triangles reach outward, as the sine of an angle at most: small ones are decided in another
// shader, which may round otherwise, and between them there must be no gap. Either product of three terms is off by at most
// 2^-22 of the lengths, of which that of the plane's normal is one.
const EDGE_SLACK: f32 = 2.4e-7 * LONGEST_DIRECTION;

var<workgroup> batch: array<vec4<u32>, 256>;
var<workgroup> kept: atomic<u32>;
// The tile's, which every thread has read before they are cleared.
var<workgroup> counters_of_tile: TileCounters;
// Least depth that any texel of the tile has so far.
var<workgroup> lowest: atomic<u32>;

// Two texels.
struct Pair {
    depth: vec2<f32>,
    number: vec2<u32>,
}

// What is known of a tile.
struct Tile {
    // Map coordinates of its middle, and how far its texels' centres are from it.
    centre: vec2<f32>,
    reach: vec2<f32>,
    // Its upper left texel.
    corner: vec2<i32>,
    x: u32,
    y: u32,
    square: u32,
    // A depth that all its texels have at least.
    least: f32,
}

@compute @workgroup_size(THREADS)
fn rasterise(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let item = group.z / SQUARES;
    let square = group.z % SQUARES;
    let view = views[item];
    if max(group.x, group.y) >= view.across || (view.hemispheres & (1u << square)) == 0u {
        return;
    }
    let centre = tile_centre(view, group.x, group.y);
    let reach = tile_reach(view);
    if !is_looked_up(view, max(abs(centre) - reach, vec2<f32>(0.0))) {
        return;
    }
    let place = tile_of(view, square, group.x, group.y);
    // Asked for before anything waits.
    var stored: array<vec2<u32>, PAIRS>;
    for (var i = 0u; i < PAIRS; i += 1u) {
        stored[i] = stored_pair(place, i * THREADS + thread);
    }
    let counter = counter_of(view, place);
    if thread == 0u {
        let count = state[counter];
        var entries = count;
        if count > ROOM {
            entries = min(state[view.counters + COUNTER_RECORDS], view.record_capacity);
        }
        counters_of_tile = TileCounters(count, entries, state[counter + TILE_LEAST]);
    }
    let counters = workgroupUniformLoad(&counters_of_tile);
    let corner = vec2<i32>(group.xy) * TILE;
    let tile = Tile(centre, reach, corner, group.x, group.y, square, bitcast<f32>(counters.least));
    var pairs: array<Pair, PAIRS>;
    for (var i = 0u; i < PAIRS; i += 1u) {
        pairs[i] = start_pair(view, item, tile, place, i * THREADS + thread, stored[i]);
    }
    let lists_all = counters.count <= ROOM;
    let count = counters.entries;
    if BATCHED {
        if thread == 0u {
            atomicStore(&lowest, 0u);
        }
        for (var start = 0u; start < count; start += BATCH) {
            if thread == 0u {
                atomicStore(&kept, 0u);
            }
            workgroupBarrier();
            let least = max(tile.least, bitcast<f32>(atomicLoad(&lowest)));
            for (var i = start + thread; i < min(start + BATCH, count); i += THREADS) {
                keep_entry(view, tile, entry_of(view, place, i, lists_all), least);
            }
            workgroupBarrier();
            let end = atomicLoad(&kept);
            for (var i = 0u; i < end; i += select(1u, 4u, IN_FOURS)) {
                // The last one again where there are no four, which changes nothing.
                let at = min(vec4<u32>(i, i + 1u, i + 2u, i + 3u), vec4<u32>(end - 1u));
                var touched = touched_by(at.x);
                if IN_FOURS {
                    touched |= touched_by(at.y) | touched_by(at.z) | touched_by(at.w);
                }
                for (var j = 0u; j < PAIRS; j += 1u) {
                    let pair = j * THREADS + thread;
                    if (touched & stripe_bit(pair)) != 0u {
                        pairs[j] = with_kept(view, pairs[j], at, tile, pair);
                    }
                }
            }
            if start + BATCH < count {
                // It only ever grows, so the last batch's is forgotten first.
                workgroupBarrier();
                if thread == 0u {
                    atomicStore(&lowest, 0xffffffffu);
                }
                workgroupBarrier();
                for (var j = 0u; j < PAIRS; j += 1u) {
                    let d = pairs[j].depth;
                    atomicMin(&lowest, bitcast<u32>(min(d.x, d.y)));
                }
            }
        }
    } else {
        for (var i = 0u; i < count; i += 1u) {
            let entry = entry_of(view, place, i, lists_all);
            let words = words_of(view, entry);
            if may_show(words, tile, tile.least) {
                let record = record_of(words, entry);
                let stripes = stripes_touched(view, record, tile);
                // Two at a time, since the rounds of all loops are numbered (src/gpu.rs): both are of one stripe.
                for (var j = 0u; j < PAIRS; j += 2u) {
                    let pair = j * THREADS + thread;
                    if (stripes & stripe_bit(pair)) != 0u {
                        pairs[j] = with_triangle(view, pairs[j], record, tile, pair);
                        pairs[j + 1u] = with_triangle(view, pairs[j + 1u], record, tile, pair + THREADS);
                    }
                }
            }
        }
    }
    for (var i = 0u; i < PAIRS; i += 1u) {
        store_pair(view, pairs[i], tile, i * THREADS + thread);
    }
    if thread == 0u && counters.count + counters.least > 0u {
        state[counter] = 0u;
        state[counter + TILE_LEAST] = 0u;
    }
}

// A tile's entry: of its list or, where that lacks room, any record.
fn entry_of(view: View, place: u32, i: u32, lists_all: bool) -> u32 {
    if lists_all {
        return lists[tile_list(view, place) + i];
    }
    return i;
}

struct Record {
    // Edges and plane.
    e0: vec3<f32>,
    e1: vec3<f32>,
    e2: vec3<f32>,
    plane: vec3<f32>,
    // The triangle's number and one.
    number: u32,
    // Whether it covers all of the tile.
    is_full: bool,
    // Least and greatest depth.
    limits: vec2<f32>,
}

fn record_of(words: array<vec4<u32>, 4>, entry: u32) -> Record {
    return Record(
        bitcast<vec3<f32>>(words[0].xyz),
        bitcast<vec3<f32>>(words[1].xyz),
        bitcast<vec3<f32>>(words[2].xyz),
        bitcast<vec3<f32>>(words[3].xyz),
        words[0].w & ((1u << SQUARE_SHIFT) - 1u),
        (entry & FULL) != 0u,
        vec2<f32>(bitcast<f32>(words[2].w), bitcast<f32>(words[3].w)),
    );
}

fn words_of(view: View, entry: u32) -> array<vec4<u32>, 4> {
    let at = (view.first_record + (entry & ~FULL)) * RECORD;
    return array<vec4<u32>, 4>(records[at], records[at + 1u], records[at + 2u], records[at + 3u]);
}

// Whether a record is of this tile, and not hidden in all of it.
fn may_show(words: array<vec4<u32>, 4>, tile: Tile, least: f32) -> bool {
    let bounds = tile_bounds(words[1].w);
    let is_here = (words[0].w >> SQUARE_SHIFT) == tile.square
        && tile.x >= bounds.x && tile.y >= bounds.y && tile.x <= bounds.z && tile.y <= bounds.w;
    let plane = bitcast<vec3<f32>>(words[3].xyz);
    let nearest = dot(plane, scaled_direction(tile.centre)) + spread(plane, tile.centre, tile.reach);
    return is_here && clamp(nearest, bitcast<f32>(words[2].w), bitcast<f32>(words[3].w)) * NEARER >= least;
}

// Puts a record in the workgroup's memory, if it may show.
fn keep_entry(view: View, tile: Tile, entry: u32, least: f32) {
    let words = words_of(view, entry);
    if !may_show(words, tile, least) {
        return;
    }
    let stripes = stripes_touched(view, record_of(words, entry), tile);
    if stripes == 0u {
        return;
    }
    let at = RECORD * atomicAdd(&kept, 1u);
    batch[at] = words[0];
    batch[at + 1u] = vec4<u32>(words[1].xyz, (entry & FULL) | stripes);
    batch[at + 2u] = words[2];
    batch[at + 3u] = words[3];
}

// A pair with a kept record, or four.
fn with_kept(view: View, before: Pair, at: vec4<u32>, tile: Tile, pair: u32) -> Pair {
    let first = kept_record(at.x);
    if !IN_FOURS {
        return with_triangle(view, before, first, tile, pair);
    }
    let second = kept_record(at.y);
    let third = kept_record(at.z);
    let fourth = kept_record(at.w);
    let half = with_triangle(view, with_triangle(view, before, first, tile, pair), second, tile, pair);
    return with_triangle(view, with_triangle(view, half, third, tile, pair), fourth, tile, pair);
}

// Stripes that a kept record may touch, and FULL.
fn touched_by(i: u32) -> u32 {
    return batch[RECORD * i + 1u].w;
}

fn kept_record(i: u32) -> Record {
    let at = RECORD * i;
    let words = array<vec4<u32>, 4>(batch[at], batch[at + 1u], batch[at + 2u], batch[at + 3u]);
    return record_of(words, words[1].w);
}

// Bits of the stripes of a tile that a triangle may touch.
fn stripes_touched(view: View, record: Record, tile: Tile) -> u32 {
    if record.is_full {
        return (1u << STRIPES) - 1u;
    }
    if !BATCHED {
        // In software finer tests take more than they save.
        return select(0u, 3u, touches_rows(view, record, tile, 4.0, 3.5))
            | select(0u, 12u, touches_rows(view, record, tile, -4.0, 3.5));
    }
    return select(0u, 1u, touches_rows(view, record, tile, 6.0, 1.5))
        | select(0u, 2u, touches_rows(view, record, tile, 2.0, 1.5))
        | select(0u, 4u, touches_rows(view, record, tile, -2.0, 1.5))
        | select(0u, 8u, touches_rows(view, record, tile, -6.0, 1.5));
}

// The same of the rows around a place above the tile's middle.
fn touches_rows(view: View, record: Record, tile: Tile, above: f32, rows: f32) -> bool {
    let reach = vec2<f32>(7.5, rows) * view.texel;
    let c = tile.centre + vec2<f32>(0.0, above * view.texel);
    let q = scaled_direction(c);
    let inside = vec3<f32>(dot(record.e0, q), dot(record.e1, q), dot(record.e2, q));
    let around = vec3<f32>(spread(record.e0, c, reach), spread(record.e1, c, reach), spread(record.e2, c, reach));
    return all(inside + around >= vec3<f32>(-BIN_SLACK));
}

fn stripe_bit(pair: u32) -> u32 {
    return 1u << (pair / PAIRS_OF_STRIPE);
}

// First texel of a tile's pair, in the tile; the other is two rows below. Pairs side by side are texels side by side.
fn pair_place(pair: u32) -> vec2<u32> {
    let own = pair % PAIRS_OF_STRIPE;
    return vec2<u32>(own % u32(TILE), pair / PAIRS_OF_STRIPE * 4u + own / u32(TILE));
}

const PAIR_ROWS: u32 = 2u;

// Where the workspace has a pair.
fn places_of(place: u32, pair: u32) -> vec2<u32> {
    let own = pair_place(pair);
    let stride = PAIR_ROWS * u32(TILE);
    return place * TILE_TEXELS + own.y * u32(TILE) + own.x + vec2<u32>(0u, stride);
}

fn stored_pair(place: u32, pair: u32) -> vec2<u32> {
    let at = places_of(place, pair);
    return vec2<u32>(depths[at.x], depths[at.y]);
}

// The number of a texel of the workspace, which is cleared.
fn taken_number(at: u32, stored: u32) -> u32 {
    if stored == 0u {
        return 0u;
    }
    let number = numbers[at];
    depths[at] = 0u;
    numbers[at] = 0u;
    return number;
}

// What a pair has before any large triangle; clears it.
fn start_pair(view: View, item: u32, tile: Tile, place: u32, pair: u32, stored: vec2<u32>) -> Pair {
    let own = pair_place(pair);
    let at = places_of(place, pair);
    let taken = vec2<u32>(
        taken_number(at.x, stored.x),
        taken_number(at.y, stored.y),
    );
    var result = Pair(bitcast<vec2<f32>>(stored), taken);
    if (view.flags & (FLAG_STATIC | FLAG_CUSTOM)) != 0u {
        let beside = tile.corner + vec2<i32>(own) + vec2<i32>(i32(tile.square) * i32(view.resolution), 0);
        for (var i = 0; i < 2; i += 1) {
            let texel = beside + vec2<i32>(0, i * i32(PAIR_ROWS));
            if (view.flags & FLAG_STATIC) != 0u {
                let source = texel + vec2<i32>(vec2<u32>(view.left, view.top));
                let depth = textureLoad(static_depths, source, view.layer, 0).x;
                result = nearer(result, i, depth, textureLoad(static_numbers, source, view.layer, 0).x + 1u);
            }
            if (view.flags & FLAG_CUSTOM) != 0u {
                result = nearer(result, i, textureLoad(custom_depths, texel, item, 0), 0u);
            }
        }
    }
    return result;
}

// A pair with something in its `i`th texel. Of equal depths the greatest number shows.
fn nearer(pair: Pair, i: i32, depth: f32, number: u32) -> Pair {
    var result = pair;
    if depth > pair.depth[i] || (depth == pair.depth[i] && number > pair.number[i]) {
        result.depth[i] = depth;
        result.number[i] = number;
    }
    return result;
}

// A pair with a large triangle.
fn with_triangle(view: View, before: Pair, record: Record, tile: Tile, pair: u32) -> Pair {
    let at = vec2<f32>(tile.corner + vec2<i32>(pair_place(pair)));
    let u = texel_u(view, at.x);
    let v = (0.5 * view.resolution - 0.5 - (at.y + vec2<f32>(0.0, f32(PAIR_ROWS)))) * view.texel;
    let h = scaled_directions_z(u, v);
    let z = clamp(products(record.plane, u, v, h), vec2<f32>(record.limits.x), vec2<f32>(record.limits.y));
    var shows = (z <= vec2<f32>(1.0)) & (z > vec2<f32>(0.0));
    if !record.is_full {
        let inside = min(products(record.e0, u, v, h), min(products(record.e1, u, v, h), products(record.e2, u, v, h)));
        shows = shows & (inside >= vec2<f32>(-EDGE_SLACK));
    }
    let number = vec2<u32>(record.number);
    shows = shows & ((z > before.depth) | ((z == before.depth) & (number > before.number)));
    return Pair(select(before.depth, z, shows), select(before.number, number, shows));
}

// Products of a plane with the directions of two texels of a column.
fn products(e: vec3<f32>, u: f32, v: vec2<f32>, h: vec2<f32>) -> vec2<f32> {
    return e.x * u + e.y * v + e.z * h;
}

fn store_pair(view: View, pair: Pair, tile: Tile, number: u32) {
    let own = tile.corner + vec2<i32>(pair_place(number));
    let rows = vec2<i32>(0, i32(PAIR_ROWS));
    store_texel(view, tile, own, pair.depth.x, pair.number.x);
    store_texel(view, tile, own + rows, pair.depth.y, pair.number.y);
}

fn store_texel(view: View, tile: Tile, texel: vec2<i32>, depth: f32, number: u32) {
    if max(texel.x, texel.y) < i32(view.resolution) {
        let origin = square_origin(view, tile.square);
        let at = vec2<i32>(origin.xy) + texel;
        textureStore(map_depths, at, origin.z, vec4<f32>(depth, 0.0, 0.0, 0.0));
        textureStore(map_numbers, at, origin.z, vec4<u32>(number - 1u, 0u, 0u, 0u));
    }
}
