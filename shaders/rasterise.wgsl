// Rasterise: each texel's greatest depth and the triangle that has it, of what was drawn small and of its tile's large
// triangles. A workgroup takes a tile, a thread QUADS quads of it: four texels of a column, four rows apart, so that threads
// side by side read and write texels side by side.

@group(0) @binding(0) var<uniform> views: array<View, MOST_ITEMS>;
@group(0) @binding(1) var<storage, read> records: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> state: array<u32>;
@group(0) @binding(3) var<storage, read_write> tiles: array<TileCounters>;
@group(0) @binding(4) var<storage, read> tile_lists: array<u32>;
// Of what was drawn small: depths, and numbers with one added. Cleared for the next item.
@group(0) @binding(5) var<storage, read_write> depths: array<u32>;
@group(0) @binding(6) var<storage, read_write> numbers: array<u32>;
@group(0) @binding(7) var map_depths: texture_storage_2d_array<r32float, write>;
@group(0) @binding(8) var map_numbers: texture_storage_2d_array<r32uint, write>;
@group(0) @binding(9) var static_depths: texture_2d_array<f32>;
@group(0) @binding(10) var static_numbers: texture_2d_array<u32>;
// What the caller has drawn, a layer for each item.
@group(0) @binding(11) var custom_depths: texture_depth_2d_array;

struct TileCounters {
    count: u32,
    least: u32,
}

// Whether records go through the workgroup's memory. In software a barrier costs more than it saves.
override BATCHED: bool = true;

const QUADS_OF_TILE: u32 = TILE_TEXELS / 4u;
// QUADS is put before this text.
const THREADS: u32 = QUADS_OF_TILE / QUADS;

// By how much edges of large triangles reach outward, as the sine of an angle at most: small ones are decided in another
// shader, which may round otherwise, and between them there must be no gap. Either product of three terms is off by at most
// 2^-22 of the lengths, of which that of the plane's normal is one.
const EDGE_SLACK: f32 = 2.4e-7 * LONGEST_DIRECTION;

var<workgroup> batch: array<vec4<u32>, 4u * THREADS>;
var<workgroup> kept: atomic<u32>;
// Least depth that any texel of the tile has so far.
var<workgroup> lowest: atomic<u32>;

struct Texels {
    depth: vec4<f32>,
    number: vec4<u32>,
}

// What is known of a tile.
struct Tile {
    // Direction of its middle, and how far its texels' centres are from that in the map.
    direction: vec3<f32>,
    centre: vec2<f32>,
    reach: f32,
    x: u32,
    y: u32,
    hemisphere: u32,
    // A depth that all its texels have at least.
    least: f32,
}

@compute @workgroup_size(THREADS)
fn rasterise(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let view = views[group.z / SQUARES];
    let hemisphere = group.z % SQUARES;
    if max(group.x, group.y) >= view.across || (view.hemispheres & (1u << hemisphere)) == 0u {
        return;
    }
    let centre = tile_centre(view, group.x, group.y);
    let reach = tile_reach(view);
    if !is_looked_up(view, max(abs(centre) - reach, vec2<f32>(0.0))) {
        return;
    }
    let place = tile_of(view, hemisphere, group.x, group.y);
    let counters = tiles[place];
    let tile = Tile(
        scaled_direction(centre),
        centre,
        reach,
        group.x,
        group.y,
        hemisphere,
        bitcast<f32>(counters.least),
    );
    var texels: array<Texels, QUADS>;
    for (var i = 0u; i < QUADS; i += 1u) {
        texels[i] = start_texels(view, group.z / SQUARES, tile, place, thread * QUADS + i);
    }
    let lists_all = counters.count <= ROOM;
    let count = select(min(state[view.counters + COUNTER_RECORDS], view.record_capacity), counters.count, lists_all);
    if BATCHED {
        // Of the entries that a batch of threads reads, those that may show go to the workgroup's memory.
        if thread == 0u {
            atomicStore(&lowest, 0u);
        }
        for (var start = 0u; start < count; start += THREADS) {
            if thread == 0u {
                atomicStore(&kept, 0u);
            }
            workgroupBarrier();
            if start + thread < count {
                keep_entry(view, tile, entry_of(place, start + thread, lists_all), bitcast<f32>(atomicLoad(&lowest)));
            }
            workgroupBarrier();
            let end = atomicLoad(&kept);
            for (var i = 0u; i < end; i += 1u) {
                let record = kept_record(i);
                for (var j = 0u; j < QUADS; j += 1u) {
                    texels[j] = with_triangle(view, texels[j], record, tile, thread * QUADS + j);
                }
            }
            if start + THREADS < count {
                // It only ever grows, so the last batch's is forgotten first.
                workgroupBarrier();
                if thread == 0u {
                    atomicStore(&lowest, 0xffffffffu);
                }
                workgroupBarrier();
                for (var j = 0u; j < QUADS; j += 1u) {
                    let d = texels[j].depth;
                    atomicMin(&lowest, bitcast<u32>(min(min(d.x, d.y), min(d.z, d.w))));
                }
            }
        }
    } else {
        for (var i = 0u; i < count; i += 1u) {
            let entry = entry_of(place, i, lists_all);
            let words = words_of(view, entry);
            if may_show(words, tile, tile.least) {
                let record = record_of(words, entry);
                for (var j = 0u; j < QUADS; j += 1u) {
                    texels[j] = with_triangle(view, texels[j], record, tile, thread * QUADS + j);
                }
            }
        }
    }
    for (var i = 0u; i < QUADS; i += 1u) {
        store_texels(view, texels[i], tile, thread * QUADS + i);
    }
    if thread == 0u && counters.count + counters.least > 0u {
        tiles[place] = TileCounters(0u, 0u);
    }
}

// A tile's entry: of its list or, where that lacks room, any record.
fn entry_of(place: u32, i: u32, lists_all: bool) -> u32 {
    if lists_all {
        return tile_lists[place * ROOM + i];
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
    let is_here = (words[0].w >> SQUARE_SHIFT) == tile.hemisphere
        && tile.x >= bounds.x && tile.y >= bounds.y && tile.x <= bounds.z && tile.y <= bounds.w;
    let plane = bitcast<vec3<f32>>(words[3].xyz);
    let nearest = dot(plane, tile.direction) + spread(plane, tile.centre, tile.reach);
    return is_here && clamp(nearest, bitcast<f32>(words[2].w), bitcast<f32>(words[3].w)) * NEARER >= least;
}

fn keep_entry(view: View, tile: Tile, entry: u32, lowest: f32) {
    let words = words_of(view, entry);
    if may_show(words, tile, max(tile.least, lowest)) {
        let at = RECORD * atomicAdd(&kept, 1u);
        batch[at] = words[0];
        batch[at + 1u] = vec4<u32>(words[1].xyz, entry);
        batch[at + 2u] = words[2];
        batch[at + 3u] = words[3];
    }
}

fn kept_record(i: u32) -> Record {
    let at = RECORD * i;
    let words = array<vec4<u32>, 4>(batch[at], batch[at + 1u], batch[at + 2u], batch[at + 3u]);
    return record_of(words, words[1].w);
}

// First texel of a tile's quad, in its map.
fn quad_corner(tile: Tile, quad: u32) -> vec2<i32> {
    return vec2<i32>(vec2<u32>(tile.x, tile.y)) * TILE + vec2<i32>(vec2<u32>(quad % 16u, quad / 16u));
}

// From one texel of a quad to the next: in rows, and in the workspace.
const QUAD_STEP: i32 = 4;
const QUAD_STRIDE: u32 = 64u;

// What a quad's texels have before any large triangle, and clears it.
fn start_texels(view: View, item: u32, tile: Tile, place: u32, quad: u32) -> Texels {
    let at = place * TILE_TEXELS + quad + vec4<u32>(0u, QUAD_STRIDE, 2u * QUAD_STRIDE, 3u * QUAD_STRIDE);
    let stored = vec4<u32>(depths[at.x], depths[at.y], depths[at.z], depths[at.w]);
    var texels = Texels(bitcast<vec4<f32>>(stored), vec4<u32>(0u));
    for (var i = 0; i < 4; i += 1) {
        if stored[i] != 0u {
            texels.number[i] = numbers[at[i]];
            depths[at[i]] = 0u;
            numbers[at[i]] = 0u;
        }
    }
    if (view.flags & (FLAG_STATIC | FLAG_CUSTOM)) != 0u {
        let corner = quad_corner(tile, quad) + vec2<i32>(i32(tile.hemisphere) * i32(view.resolution), 0);
        for (var i = 0; i < 4; i += 1) {
            let texel = corner + vec2<i32>(0, i * QUAD_STEP);
            if (view.flags & FLAG_STATIC) != 0u {
                let source = texel + vec2<i32>(vec2<u32>(view.left, view.top));
                let depth = textureLoad(static_depths, source, view.layer, 0).x;
                let number = textureLoad(static_numbers, source, view.layer, 0).x + 1u;
                texels = nearer(texels, i, depth, number);
            }
            if (view.flags & FLAG_CUSTOM) != 0u {
                texels = nearer(texels, i, textureLoad(custom_depths, texel, item, 0), 0u);
            }
        }
    }
    return texels;
}

// Quads with something in one texel, if it is nearer.
fn nearer(texels: Texels, i: i32, depth: f32, number: u32) -> Texels {
    var result = texels;
    if depth > texels.depth[i] || (depth == texels.depth[i] && number > texels.number[i]) {
        result.depth[i] = depth;
        result.number[i] = number;
    }
    return result;
}

// A quad with a large triangle. Of those of equal depth the greatest number shows.
fn with_triangle(view: View, texels: Texels, record: Record, tile: Tile, quad: u32) -> Texels {
    let corner = vec2<f32>(quad_corner(tile, quad));
    let u = texel_u(view, corner.x);
    let v = vec4<f32>(
        texel_v(view, corner.y),
        texel_v(view, corner.y + 4.0),
        texel_v(view, corner.y + 8.0),
        texel_v(view, corner.y + 12.0),
    );
    let h = scaled_directions_z(u, v);
    let z = clamp(products(record.plane, u, v, h), vec4<f32>(record.limits.x), vec4<f32>(record.limits.y));
    var shows = (z <= vec4<f32>(1.0)) & (z > vec4<f32>(0.0));
    if !record.is_full {
        let inside = min(products(record.e0, u, v, h), min(products(record.e1, u, v, h), products(record.e2, u, v, h)));
        shows = shows & (inside >= vec4<f32>(-EDGE_SLACK));
    }
    let number = vec4<u32>(record.number);
    shows = shows & ((z > texels.depth) | ((z == texels.depth) & (number > texels.number)));
    return Texels(select(texels.depth, z, shows), select(texels.number, number, shows));
}

// Products of a plane with the directions of four texels.
fn products(e: vec3<f32>, u: f32, v: vec4<f32>, h: vec4<f32>) -> vec4<f32> {
    return e.x * u + e.y * v + e.z * h;
}

fn store_texels(view: View, texels: Texels, tile: Tile, quad: u32) {
    let corner = quad_corner(tile, quad);
    let size = i32(view.resolution);
    let origin = square_origin(view, tile.hemisphere);
    let target_corner = corner + vec2<i32>(origin.xy);
    for (var i = 0; i < 4; i += 1) {
        let row = i * QUAD_STEP;
        if corner.x < size && corner.y + row < size {
            let at = target_corner + vec2<i32>(0, row);
            textureStore(map_depths, at, origin.z, vec4<f32>(texels.depth[i], 0.0, 0.0, 0.0));
            textureStore(map_numbers, at, origin.z, vec4<u32>(texels.number[i] - 1u, 0u, 0u, 0u));
        }
    }
}
