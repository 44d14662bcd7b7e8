// Bin: which tiles each large triangle touches. A workgroup takes a record and a row of blocks, a thread a tile.

@group(0) @binding(0) var<uniform> views: array<View, MOST_ITEMS>;
@group(0) @binding(1) var<storage, read> records: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> lists: array<u32>;
@group(0) @binding(3) var<storage, read> state: array<u32>;
@group(0) @binding(4) var<storage, read_write> tiles: array<TileCounters>;
@group(0) @binding(5) var<storage, read_write> tile_lists: array<u32>;

struct TileCounters {
    // Triangles that touch the tile, whether there was room or not.
    count: atomic<u32>,
    // A depth that all of the tile's texels surely have at least, as the bits of a float.
    least: atomic<u32>,
}

@compute @workgroup_size(64)
fn bin(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let view = views[group.z];
    let count = state[view.counters + COUNTER_JOBS];
    if count > view.job_capacity || state[view.counters + COUNTER_RECORDS] > view.record_capacity {
        return;
    }
    for (var number = group.x; number < count; number += groups.x) {
        let job = lists[view.first_job + number];
        let record = job >> 5u;
        let at = (view.first_record + record) * RECORD;
        let bounds = tile_bounds(records[at + 1u].w);
        let y = (job & 31u) * BLOCK + thread / BLOCK;
        for (var left = bounds.x / BLOCK * BLOCK; left <= bounds.z; left += BLOCK) {
            let x = left + thread % BLOCK;
            if x >= bounds.x && x <= bounds.z && y >= bounds.y && y <= bounds.w {
                bin_tile(view, record, at, x, y);
            }
        }
    }
}

fn bin_tile(view: View, record: u32, at: u32, x: u32, y: u32) {
    let c = tile_centre(view, x, y);
    let h = tile_reach(view);
    if !is_looked_up(view, max(abs(c) - h, vec2<f32>(0.0))) {
        return;
    }
    let q = scaled_direction(c);
    let e0 = bitcast<vec3<f32>>(records[at].xyz);
    let e1 = bitcast<vec3<f32>>(records[at + 1u].xyz);
    let e2 = bitcast<vec3<f32>>(records[at + 2u].xyz);
    let plane = bitcast<vec3<f32>>(records[at + 3u].xyz);
    let inside = vec3<f32>(dot(e0, q), dot(e1, q), dot(e2, q));
    let around = vec3<f32>(spread(e0, c, h), spread(e1, c, h), spread(e2, c, h));
    if any(inside + around < vec3<f32>(-BIN_SLACK)) {
        return;
    }
    let depth = dot(plane, q);
    let range = spread(plane, c, h);
    let least_depth = bitcast<f32>(records[at + 2u].w);
    let greatest_depth = bitcast<f32>(records[at + 3u].w);
    let farthest = clamp(depth - range, least_depth, greatest_depth);
    let nearest = clamp(depth + range, least_depth, greatest_depth);
    if nearest <= 0.0 || farthest > 1.0 {
        return;
    }
    let tile = tile_of(view, records[at].w >> SQUARE_SHIFT, x, y);
    let least = atomicLoad(&tiles[tile].least);
    if nearest * NEARER < bitcast<f32>(least) {
        return;
    }
    let is_full = all(inside >= around) && nearest <= 1.0;
    if is_full && farthest > 0.0 && bitcast<u32>(farthest * FARTHER) > least {
        atomicMax(&tiles[tile].least, bitcast<u32>(farthest * FARTHER));
    }
    let place = atomicAdd(&tiles[tile].count, 1u);
    if place < ROOM {
        tile_lists[tile * ROOM + place] = record | select(0u, FULL, is_full);
    }
}
