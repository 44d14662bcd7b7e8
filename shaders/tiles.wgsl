// What the binning and the tiles share.

// Triangles that a tile's list has room for. A tile with more goes through all records.
override ROOM: u32 = 128u;

// In a tile's list: the triangle covers the whole tile.
const FULL: u32 = 0x80000000u;

// Room for rounding in tests of unit planes against tiles, and in depths.
const BIN_SLACK: f32 = 1e-6;
const NEARER: f32 = 1.00001;
const FARTHER: f32 = 0.99999;

// First x, first y, last x and last y of a record's tiles.
fn tile_bounds(packed: u32) -> vec4<u32> {
    return (vec4<u32>(packed) >> vec4<u32>(0u, 8u, 16u, 24u)) & vec4<u32>(0xffu);
}

// Map coordinates of the middle of a tile.
fn tile_centre(view: View, x: u32, y: u32) -> vec2<f32> {
    let corner = vec2<f32>(vec2<u32>(x, y)) * f32(TILE) + 0.5 * f32(TILE) - 0.5 * view.resolution;
    return corner * vec2<f32>(1.0, -1.0) * view.texel;
}

// How far the centres of a tile's texels are from its middle, along each axis.
fn tile_reach(view: View) -> vec2<f32> {
    return vec2<f32>((0.5 * f32(TILE) - 0.5) * view.texel);
}

// Where a tile has its counters: how many triangles touch it, whether there was room or not; and a depth that all of its texels
// surely have at least, as the bits of a float.
fn counter_of(view: View, tile: u32) -> u32 {
    return view.tile_counters + 2u * tile;
}

const TILE_LEAST: u32 = 1u;

// Where a tile's list begins.
fn tile_list(view: View, tile: u32) -> u32 {
    return view.tile_lists + tile * ROOM;
}
