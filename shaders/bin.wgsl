// Bin: which tiles each large triangle touches. Eight threads take a record of few tiles; of others a workgroup takes a row of
// blocks, and a thread a tile.

fn bin(view: View, group: u32, groups: u32, thread: u32) {
    let count = atomicLoad(&state[view.counters + COUNTER_JOBS]);
    let total = atomicLoad(&state[view.counters + COUNTER_RECORDS]);
    if count > view.job_capacity || total > view.record_capacity {
        return;
    }
    let groups_of_records = (total + BLOCK - 1u) / BLOCK;
    for (var number = group; number < groups_of_records + count; number += groups) {
        if number < groups_of_records {
            let record = number * BLOCK + thread / BLOCK;
            if record < total {
                bin_narrow(view, record, thread % BLOCK);
            }
        } else {
            bin_job(view, lists[view.first_job + number - groups_of_records], thread);
        }
    }
}

fn bin_narrow(view: View, record: u32, lane: u32) {
    let large = large_of(view, record);
    let bounds = tile_bounds(large.tiles);
    let across = bounds.z - bounds.x + 1u;
    if is_narrow(large.tiles) && lane < across * (bounds.w - bounds.y + 1u) {
        bin_tile(view, large, record, bounds.x + lane % across, bounds.y + lane / across);
    }
}

fn bin_job(view: View, job: u32, thread: u32) {
    let record = job >> 5u;
    let large = large_of(view, record);
    let bounds = tile_bounds(large.tiles);
    let y = (job & 31u) * BLOCK + thread / BLOCK;
    for (var left = bounds.x / BLOCK * BLOCK; left <= bounds.z; left += BLOCK) {
        let x = left + thread % BLOCK;
        if x >= bounds.x && x <= bounds.z && y >= bounds.y && y <= bounds.w {
            bin_tile(view, large, record, x, y);
        }
    }
}

struct Large {
    e0: vec3<f32>,
    e1: vec3<f32>,
    e2: vec3<f32>,
    plane: vec3<f32>,
    limits: vec2<f32>,
    tiles: u32,
    square: u32,
}

fn large_of(view: View, record: u32) -> Large {
    let at = (view.first_record + record) * RECORD;
    let words = array<vec4<u32>, 4>(records[at], records[at + 1u], records[at + 2u], records[at + 3u]);
    return Large(
        bitcast<vec3<f32>>(words[0].xyz),
        bitcast<vec3<f32>>(words[1].xyz),
        bitcast<vec3<f32>>(words[2].xyz),
        bitcast<vec3<f32>>(words[3].xyz),
        vec2<f32>(bitcast<f32>(words[2].w), bitcast<f32>(words[3].w)),
        words[1].w,
        words[0].w >> SQUARE_SHIFT,
    );
}

fn bin_tile(view: View, large: Large, record: u32, x: u32, y: u32) {
    let c = tile_centre(view, x, y);
    let h = tile_reach(view);
    if !is_looked_up(view, max(abs(c) - h, vec2<f32>(0.0))) {
        return;
    }
    let q = scaled_direction(c);
    let inside = vec3<f32>(dot(large.e0, q), dot(large.e1, q), dot(large.e2, q));
    let around = vec3<f32>(spread(large.e0, c, h), spread(large.e1, c, h), spread(large.e2, c, h));
    if any(inside + around < vec3<f32>(-BIN_SLACK)) {
        return;
    }
    let depth = dot(large.plane, q);
    let range = spread(large.plane, c, h);
    let farthest = clamp(depth - range, large.limits.x, large.limits.y);
    let nearest = clamp(depth + range, large.limits.x, large.limits.y);
    if nearest <= 0.0 || farthest > 1.0 {
        return;
    }
    let tile = tile_of(view, large.square, x, y);
    let counter = counter_of(view, tile);
    let least = atomicLoad(&state[counter + TILE_LEAST]);
    if nearest * NEARER < bitcast<f32>(least) {
        return;
    }
    let is_full = all(inside >= around) && nearest <= 1.0;
    if is_full && farthest > 0.0 && bitcast<u32>(farthest * FARTHER) > least {
        atomicMax(&state[counter + TILE_LEAST], bitcast<u32>(farthest * FARTHER));
    }
    let place = atomicAdd(&state[counter], 1u);
    if place < ROOM {
        lists[tile_list(view, tile) + place] = record | select(0u, FULL, is_full);
    }
}
