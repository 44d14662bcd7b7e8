// A triangle as the light sees it: a cone of three planes, drawn row by row.

// Threads of a workgroup.
override THREADS: u32 = 256u;

// Corners of the chunk's triangles: relative to the light along the world's axes, in the map's space, and map coordinates
// with w (`projected`).
var<workgroup> relatives: array<vec3<f32>, 256>;
var<workgroup> places: array<vec3<f32>, 256>;
var<workgroup> corners: array<vec3<f32>, 256>;
// Triangles whose rows are drawn: the number of the first row in bits 8-31, the place in the chunk in bits 0-7.
var<workgroup> queue: array<u32, 256>;
// Rows in bits 9-31, triangles in bits 0-8.
var<workgroup> queued: atomic<u32>;

struct Triangle {
    // Normals of the planes through the light and an edge, inward. Of neighbours the same bits but for the sign.
    e0: vec3<f32>,
    e1: vec3<f32>,
    e2: vec3<f32>,
    // The depth at q is the product with this.
    plane: vec3<f32>,
    // The light lies in its plane: it covers nothing.
    is_edge_on: bool,
}

// Texels of a map, ends included; none if an upper bound is below its lower one.
struct Box {
    low: vec2<i32>,
    high: vec2<i32>,
}

// Places of a triangle's corners in its chunk.
fn corners_of(packed: u32) -> vec3<u32> {
    return vec3<u32>(packed, packed >> 8u, packed >> 16u) & vec3<u32>(0xffu);
}

fn comes_first(a: vec3<f32>, b: vec3<f32>) -> bool {
    return a.x < b.x || (a.x == b.x && (a.y < b.y || (a.y == b.y && a.z < b.z)));
}

// Normal of the plane through the light and an edge: the same bits but for the sign, whichever end comes first.
fn edge_normal(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    let swap = comes_first(b, a);
    let p = select(a, b, swap);
    let q = select(b, a, swap);
    let e = cross(p, q - p);
    return select(e, -e, swap);
}

// Normal of a triangle, from its two shorter edges: those of thin ones keep their digits. What rounding tilts it along the
// longest edge is taken off again, since the thinner a triangle, the more that is.
fn triangle_normal(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec3<f32> {
    let e = b - a;
    let f = c - b;
    let g = a - c;
    let squares = vec3<f32>(dot(e, e), dot(f, f), dot(g, g));
    if squares.x >= max(squares.y, squares.z) {
        return without(cross(f, g), e, squares.x);
    }
    if squares.y >= squares.z {
        return without(cross(g, e), f, squares.y);
    }
    return without(cross(e, f), g, squares.z);
}

// A vector without what it has of another one, whose square is given.
fn without(n: vec3<f32>, along: vec3<f32>, square: f32) -> vec3<f32> {
    return n - along * (dot(n, along) / max(square, 1e-37));
}

// A triangle of the chunk. Its plane is found before anything is turned, since that rounds: a floor a millimetre under the
// light may reach for kilometres.
fn triangle_of(view: View, local: vec3<u32>, square: u32) -> Triangle {
    let r = relatives[local.x];
    let s = relatives[local.y];
    let t = relatives[local.z];
    let n = triangle_normal(r, s, t);
    let d = dot(n, nearest_of(r, s, t));
    let facing = sign(d);
    let a = places[local.x];
    let b = places[local.y];
    let c = places[local.z];
    return Triangle(
        facing * edge_normal(a, b),
        facing * edge_normal(b, c),
        facing * edge_normal(c, a),
        square_space(view, n, square) * (view.near / d),
        d == 0.0,
    );
}

// The one of three points that is nearest to the light.
fn nearest_of(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec3<f32> {
    let squares = vec3<f32>(dot(a, a), dot(b, b), dot(c, c));
    let nearer = select(b, a, squares.x <= squares.y);
    return select(c, nearer, min(squares.x, squares.y) <= squares.z);
}

// Texels whose centres a triangle may cover. `a`, `b` and `c` are `projected`.
fn box_of(view: View, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> Box {
    let low = min(a.xy, min(b.xy, c.xy));
    let high = max(a.xy, max(b.xy, c.xy));
    let extent = high - low;
    let pad = view.texels * arc_bow(dot(extent, extent)) + view.resolution * 1e-6;
    let half = 0.5 * view.resolution - 0.5;
    let first = vec2<f32>(low.x, -high.y) * view.texels + half - pad;
    let last = vec2<f32>(high.x, -low.y) * view.texels + half + pad;
    let most = vec2<f32>(view.resolution);
    return Box(
        vec2<i32>(clamp(ceil(first), vec2<f32>(0.0), most)),
        vec2<i32>(clamp(floor(last), vec2<f32>(-1.0), most - 1.0)),
    );
}

// The same for any triangle, however it lies.
fn whole_box_of(view: View, local: vec3<u32>, square: u32) -> Box {
    let a = corners[local.x];
    let b = corners[local.y];
    let c = corners[local.z];
    let whole = Box(vec2<i32>(0), vec2<i32>(i32(view.resolution) - 1));
    if !is_near(a, b, c) {
        return whole;
    }
    let extent = max(a.xy, max(b.xy, c.xy)) - min(a.xy, min(b.xy, c.xy));
    if dot(extent, extent) > 1.0 {
        let triangle = triangle_of(view, local, square);
        if is_around_back(triangle.e0, triangle.e1, triangle.e2) {
            return whole;
        }
    }
    return box_of(view, a, b, c);
}

// Puts the corners of a chunk where its triangles find them. `vertex` is that of the thread.
fn place_corners(view: View, source: ChunkSource, vertex: vec3<f32>, square: u32, thread: u32) {
    for (var v = thread; v < vertex_count(source); v += THREADS) {
        var position = vertex;
        if v != thread {
            position = vertices[source.vertex + v].position;
        }
        let relative = position - view.position;
        let x = square_space(view, relative, square);
        relatives[v] = relative;
        places[v] = x;
        corners[v] = projected(view, x);
    }
}

// Has `count` rows drawn of a chunk's triangle `t`.
fn enqueue(t: u32, count: u32) {
    let before = atomicAdd(&queued, (count << 9u) | 1u);
    queue[before & 0x1ffu] = ((before >> 9u) << 8u) | t;
}

// The queue's last triangle whose rows begin at `row` or before.
fn triangle_of_row(row: u32, count: u32) -> u32 {
    var low = 0u;
    var high = count;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if (queue[middle] >> 8u) <= row {
            low = middle;
        } else {
            high = middle;
        }
    }
    return queue[low];
}

// The part of a row, from `box`'s left to its right, that a plane doesn't exclude; relative to the middle.
fn trimmed(span: vec2<f32>, e: vec3<f32>, middle: vec2<f32>, half: f32) -> vec2<f32> {
    let at = dot(e, scaled_direction(middle));
    let bent = spread(vec3<f32>(0.0, 0.0, e.z), vec2<f32>(0.0), half);
    let slope = slope_along_row(e, middle.x);
    let pad = bent + 1e-6 * (abs(e.x) + abs(e.y) + abs(e.z));
    let cut = clamp(-(at + pad) / slope, -2.0 * half, 2.0 * half);
    return vec2<f32>(select(span.x, max(span.x, cut), slope > 0.0), select(span.y, min(span.y, cut), slope < 0.0));
}

// Texels of a row that a triangle may cover: first and last.
fn row_span(view: View, triangle: Triangle, box: Box, y: i32) -> vec2<i32> {
    if box.high.x - box.low.x <= 3 {
        return vec2<i32>(box.low.x, box.high.x);
    }
    let half = 0.5 * f32(box.high.x - box.low.x) * view.texel;
    let middle = vec2<f32>(texel_u(view, f32(box.low.x)) + half, texel_v(view, f32(y)));
    var span = vec2<f32>(-half, half);
    span = trimmed(span, triangle.e0, middle, half);
    span = trimmed(span, triangle.e1, middle, half);
    span = trimmed(span, triangle.e2, middle, half);
    let first = box.low.x + i32(ceil((span.x + half) * view.texels - 0.01));
    let last = box.low.x + i32(floor((span.y + half) * view.texels + 0.01));
    return vec2<i32>(max(box.low.x, first), min(box.high.x, last));
}

// Whether a triangle covers the direction q. Its neighbour at an edge says the opposite with the same bits, or both do.
fn covers(triangle: Triangle, q: vec3<f32>) -> bool {
    return dot(triangle.e0, q) >= 0.0 && dot(triangle.e1, q) >= 0.0 && dot(triangle.e2, q) >= 0.0;
}

// Least and greatest depth of a triangle by its `projected` corners. Seen edge-on its plane may say anything, but no point
// of it has a greater w than its corners, nor, where it spans an angle of a, less than 1 - 0.53 a^2 of the least of theirs.
fn depth_limits(near: f32, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec2<f32> {
    let depths = near / abs(vec3<f32>(a.z, b.z, c.z));
    let extent = max(a.xy, max(b.xy, c.xy)) - min(a.xy, min(b.xy, c.xy));
    // An angle is at most twice as large as its extent in the map.
    let shortening = 2.2 * dot(extent, extent);
    let is_bounded = shortening < 0.5 && min(a.z, min(b.z, c.z)) > 0.0;
    let nearest = max(depths.x, max(depths.y, depths.z)) / (1.0 - min(shortening, 0.5));
    let farthest = min(depths.x, min(depths.y, depths.z));
    return vec2<f32>(select(0.0, farthest, is_bounded), select(3e38, nearest, is_bounded));
}

// Where the workspace has four texels of a row, the last one over where it has ended.
fn row_places(view: View, square: u32, x: i32, y: i32, last: i32) -> vec4<u32> {
    return vec4<u32>(
        place_of_texel(view, square, x, y),
        place_of_texel(view, square, min(x + 1, last), y),
        place_of_texel(view, square, min(x + 2, last), y),
        place_of_texel(view, square, min(x + 3, last), y),
    );
}
