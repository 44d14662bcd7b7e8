// A work item, that is a light and the chunks that are drawn for it, and the workspace that its stages share. Twin of
// `View` in src/view.rs.

struct View {
    // Rows of the rotation from world to light space.
    right: vec3<f32>,
    near: f32,
    up: vec3<f32>,
    range: f32,
    forward: vec3<f32>,
    // Texels per unit of map coordinates.
    texels: f32,
    position: vec3<f32>,
    // Units of map coordinates per texel.
    texel: f32,
    // Texels across one map.
    resolution: f32,
    // A direction is behind a hemisphere when its z is below this.
    behind: f32,
    // Bit 0 the front, bit 1 the back; all bits set for all directions.
    hemispheres: u32,
    // Chunks are 0 to below this.
    end_chunk: u32,
    // Bit k is set if chunks of kind k take part.
    kinds: u32,
    // Tiles across one map.
    across: u32,
    // Where the item's share of the workspace begins: in tiles, in records, in jobs of the binning, in words of the chunks'
    // bits.
    first_tile: u32,
    first_record: u32,
    first_job: u32,
    first_bits: u32,
    // How many records and jobs there is room for.
    record_capacity: u32,
    job_capacity: u32,
    // The same of triangles that were drawn small.
    first_winner: u32,
    winner_capacity: u32,
    // Where the item's counters are.
    counters: u32,
    // Where the counters of all items' tiles begin, and their lists.
    tile_counters: u32,
    tile_lists: u32,
    // The map's upper left texel, the front's, and its layer.
    left: u32,
    top: u32,
    layer: u32,
    // FLAG_* below.
    @size(112) flags: u32,
}

// The map starts from that of the static casters, or from what the caller has drawn.
const FLAG_STATIC: u32 = 1u;
const FLAG_CUSTOM: u32 = 2u;
// There may be more of something than there is room for.
const FLAG_OVERFLOWS: u32 = 4u;

// Work items that the stages go through at a time; a workgroup's z says which.
const MOST_ITEMS: u32 = 8u;

// Texels across a tile, and in it.
const TILE: i32 = 16;
const TILE_TEXELS: u32 = 256u;
// Tiles across a block, which one job of the binning goes through at a time.
const BLOCK: u32 = 8u;

// Vectors of a record of a large triangle: three edges, each a unit normal of the plane through it and the light, and the
// plane of the depth. Their fourth words: the triangle's number and one with its hemisphere above; its tiles (first x, first
// y, last x, last y, a byte each); its least and its greatest depth.
const RECORD: u32 = 4u;
const SQUARE_SHIFT: u32 = 29u;

// Whether a record touches so few tiles that eight threads bin it, without jobs.
fn is_narrow(tiles: u32) -> bool {
    let size = ((tiles >> 16u) & 0xffu) - (tiles & 0xffu) + 1u;
    return size * ((tiles >> 24u) - ((tiles >> 8u) & 0xffu) + 1u) <= BLOCK;
}

// Number of a triangle, with one added so that 0 is none.
fn number_of(chunk: u32, t: u32) -> u32 {
    return ((chunk << 8u) | t) + 1u;
}

// An item's counters: records, jobs and winners wanted, whether there was room or not; entries of the lists below, and the
// most bands of any of them.
const COUNTER_RECORDS: u32 = 0u;
const COUNTER_JOBS: u32 = 1u;
const COUNTER_WINNERS: u32 = 2u;
const COUNTER_LISTS: u32 = 3u;
const COUNTER_BANDS: u32 = 6u;

// A *part* is a chunk as one map sees it: its number is `SQUARES` times the chunk's, and the map's. A part has bits of those of
// its triangles that won a texel when they were drawn, for where they find no room among the winners, and of those that are
// put off.
const BITS_DRAWN: u32 = 0u;
const BITS_DEFERRED: u32 = 1u;
const BITS: u32 = 2u;
// Lists of parts with bits: of masked triangles that are put off, of large ones in case that there isn't room, and of those
// without room among the winners.
const LIST_MASKED: u32 = 0u;
const LIST_LARGE: u32 = 1u;
const LIST_DRAWN: u32 = 2u;
// Words of a part's bits of each kind.
const PART_BITS: u32 = 8u;
// An entry of a list has the part's number and, above, into how many bands its rows are shared out, less one: a band is every
// so manieth row.
const LISTED_PART: u32 = 0x7ffffffu;
const BANDS_SHIFT: u32 = 27u;
const MOST_BANDS: u32 = 32u;

// Where a part's bits are.
fn bits_of(view: View, part: u32, kind: u32) -> u32 {
    return view.first_bits + (part * BITS + kind) * PART_BITS;
}

// Where a list begins.
fn list_of(view: View, list: u32) -> u32 {
    return view.first_bits + SQUARES * view.end_chunk * (BITS * PART_BITS + list);
}

// Map coordinates of a texel's centre.
fn texel_u(view: View, x: f32) -> f32 {
    return (x + 0.5 - 0.5 * view.resolution) * view.texel;
}

fn texel_v(view: View, y: f32) -> f32 {
    return (0.5 * view.resolution - 0.5 - y) * view.texel;
}

fn tile_of(view: View, hemisphere: u32, x: u32, y: u32) -> u32 {
    return view.first_tile + (hemisphere * view.across + y) * view.across + x;
}

// Where the workspace has a texel.
fn place_of_texel(view: View, hemisphere: u32, x: i32, y: i32) -> u32 {
    let tile = tile_of(view, hemisphere, u32(x / TILE), u32(y / TILE));
    return tile * TILE_TEXELS + u32((y % TILE) * TILE + x % TILE);
}
