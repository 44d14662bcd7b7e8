// Number: which triangle each texel's depth is of. Who wins a texel among the small ones is known only when all are drawn, so
// those that won one at some time are gone through once more.

// Fewer triangles leave most of a GPU idle.
override FEW: u32 = 32768u;

fn number(view: View, group: u32, groups: u32, thread: u32) {
    let count = min(atomicLoad(&state[view.counters + COUNTER_WINNERS]), view.winner_capacity);
    // Eight threads share a triangle's rows, as waiting is what takes time; unless there are triangles enough for all.
    let shift = select(0u, 3u, count < FEW);
    let lane = i32(thread & ((1u << shift) - 1u));
    for (var i = (group * THREADS + thread) >> shift; i < count; i += (groups * THREADS) >> shift) {
        let winner = lists[view.first_winner + i];
        if winner != 0u {
            number_triangle(view, winner & ((1u << SQUARE_SHIFT) - 1u), winner >> SQUARE_SHIFT, lane, 1 << shift);
        }
    }
}

fn number_triangle(view: View, number: u32, square: u32, lane: i32, lanes: i32) {
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
    for (var y = box.low.y + lane; y <= box.high.y; y += lanes) {
        let v = texel_v(view, f32(y));
        let span = row_span(view, triangle, box, y);
        for (var x = span.x; x <= span.y; x += 4) {
            // Four at a time, as the culling does.
            let at = row_places(view, square, x, y, span.y);
            let stored = vec4<u32>(depths[at.x], depths[at.y], depths[at.z], depths[at.w]);
            number_texel(view, triangle, x, span.y, v, at.x, stored.x, number);
            number_texel(view, triangle, x + 1, span.y, v, at.y, stored.y, number);
            number_texel(view, triangle, x + 2, span.y, v, at.z, stored.z, number);
            number_texel(view, triangle, x + 3, span.y, v, at.w, stored.w, number);
        }
    }
}

fn number_texel(view: View, triangle: Triangle, x: i32, last: i32, v: f32, at: u32, stored: u32, number: u32) {
    let q = scaled_direction(vec2<f32>(texel_u(view, f32(x)), v));
    let is_same = is_same_depth(triangle, depth_at(triangle, q), bitcast<f32>(stored));
    if stored != 0u && is_same && covers_nearly(triangle, q) && x <= last {
        atomicMax(&numbers[at], number);
    }
}
