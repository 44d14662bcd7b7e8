// Number: which triangle each texel's depth is of. Who wins a texel among the small ones is known only when all are drawn, so
// those that won one at some time are gone through once more, a thread for each.

@group(0) @binding(0) var<uniform> views: array<View, MOST_ITEMS>;
@group(0) @binding(1) var<storage, read> chunk_sources: array<ChunkSource>;
@group(0) @binding(2) var<storage, read> triangles: array<u32>;
@group(0) @binding(3) var<storage, read> vertices: array<CasterVertex>;
@group(0) @binding(4) var<storage, read> depths: array<u32>;
// The greatest number, with one added, of the triangles that have a texel's depth.
@group(0) @binding(5) var<storage, read_write> numbers: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read> lists: array<u32>;
@group(0) @binding(7) var<storage, read> state: array<u32>;

const THREADS: u32 = 64u;

@compute @workgroup_size(64)
fn number(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let view = views[group.z];
    let count = min(state[view.counters + COUNTER_WINNERS], view.winner_capacity);
    for (var i = group.x * THREADS + thread; i < count; i += groups.x * THREADS) {
        let winner = lists[view.first_winner + i];
        if winner != 0u {
            number_triangle(view, winner & ((1u << SQUARE_SHIFT) - 1u), winner >> SQUARE_SHIFT);
        }
    }
}

fn number_triangle(view: View, number: u32, square: u32) {
    let source = chunk_sources[(number - 1u) >> 8u];
    let local = corners_of(triangles[source.triangle + ((number - 1u) & 0xffu)]);
    let relative = array<vec3<f32>, 3>(
        vertices[source.vertex + local.x].position - view.position,
        vertices[source.vertex + local.y].position - view.position,
        vertices[source.vertex + local.z].position - view.position,
    );
    let a = corner_of(view, relative[0], square);
    let b = corner_of(view, relative[1], square);
    let c = corner_of(view, relative[2], square);
    let triangle = triangle_of(view, square, relative, a, b, c);
    let box = box_of(view, a, b, c);
    for (var y = box.low.y; y <= box.high.y; y += 1) {
        let v = texel_v(view, f32(y));
        let span = row_span(view, triangle, box, y);
        for (var x = span.x; x <= span.y; x += 4) {
            // Four at a time, as the culling does.
            let at = row_places(view, square, x, y, span.y);
            let stored = vec4<u32>(depths[at.x], depths[at.y], depths[at.z], depths[at.w]);
            for (var i = 0; i < 4; i += 1) {
                let q = scaled_direction(vec2<f32>(texel_u(view, f32(x + i)), v));
                let is_same = is_same_depth(triangle, depth_at(triangle, q), bitcast<f32>(stored[i]));
                if stored[i] != 0u && is_same && covers_nearly(triangle, q) && x + i <= span.y {
                    atomicMax(&numbers[at[i]], number);
                }
            }
        }
    }
}
