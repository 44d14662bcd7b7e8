// A triangle as one of the light's maps sees it: a cone of three planes through the light, and a depth that is linear in q.

struct Triangle {
    // Normals of the planes through the light and an edge, inward. Of neighbours the same bits but for the sign.
    e0: vec3<f32>,
    e1: vec3<f32>,
    e2: vec3<f32>,
    // The depth at q is the product with this, within the limits.
    plane: vec3<f32>,
    limits: vec2<f32>,
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

// The one of three points that is nearest to the light.
fn nearest_of(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec3<f32> {
    let squares = vec3<f32>(dot(a, a), dot(b, b), dot(c, c));
    let nearer = select(b, a, squares.x <= squares.y);
    return select(c, nearer, min(squares.x, squares.y) <= squares.z);
}

// A triangle by its corners and, along the world's axes, their positions relative to the light. Its plane is found before
// anything is turned, since that rounds: a floor a millimetre under the light may reach for kilometres.
fn triangle_of(view: View, square: u32, relative: array<vec3<f32>, 3>, a: Corner, b: Corner, c: Corner) -> Triangle {
    let n = triangle_normal(relative[0], relative[1], relative[2]);
    let d = dot(n, nearest_of(relative[0], relative[1], relative[2]));
    let facing = sign(d);
    return Triangle(
        facing * edge_normal(a.place, b.place),
        facing * edge_normal(b.place, c.place),
        facing * edge_normal(c.place, a.place),
        square_space(view, n, square) * (view.near / d),
        depth_limits(view.near, a, b, c),
        d == 0.0,
    );
}

// Extent of a triangle's corners in the map.
fn extent_of(a: Corner, b: Corner, c: Corner) -> vec2<f32> {
    return max(a.map, max(b.map, c.map)) - min(a.map, min(b.map, c.map));
}

// Texels whose centres a triangle may cover, if its corners are `is_near` and it isn't `is_around_back`.
fn box_of(view: View, a: Corner, b: Corner, c: Corner) -> Box {
    let low = min(a.map, min(b.map, c.map));
    let high = max(a.map, max(b.map, c.map));
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
fn whole_box_of(view: View, a: Corner, b: Corner, c: Corner, triangle: Triangle) -> Box {
    let extent = extent_of(a, b, c);
    // Corners around the axis behind are farther apart.
    let may_be_around = dot(extent, extent) > 1.0;
    if !is_near(a, b, c) || (may_be_around && is_around_back(triangle.e0, triangle.e1, triangle.e2)) {
        return Box(vec2<i32>(0), vec2<i32>(i32(view.resolution) - 1));
    }
    return box_of(view, a, b, c);
}

// Least and greatest depth of a triangle. Seen edge-on its plane may say anything, but no point of it has a greater w than
// its corners, nor, where it spans an angle of a, less than 1 - 0.53 a^2 of the least of theirs.
fn depth_limits(near: f32, a: Corner, b: Corner, c: Corner) -> vec2<f32> {
    let depths = near / abs(vec3<f32>(a.w, b.w, c.w));
    let extent = extent_of(a, b, c);
    // An angle is at most twice as large as its extent in the map.
    let shortening = 2.2 * dot(extent, extent);
    let is_bounded = shortening < 0.5 && min(a.w, min(b.w, c.w)) > 0.0;
    let nearest = max(depths.x, max(depths.y, depths.z)) / (1.0 - min(shortening, 0.5));
    let farthest = min(depths.x, min(depths.y, depths.z));
    return vec2<f32>(select(0.0, farthest, is_bounded), select(3e38, nearest, is_bounded));
}

// Products of a direction with the planes of a triangle's edges, none negative where the triangle covers it. Its neighbour at an
// edge finds the opposite with the same bits, or both cover it.
fn edges_at(triangle: Triangle, q: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(triangle.e0, q), dot(triangle.e1, q), dot(triangle.e2, q));
}

fn covers(triangle: Triangle, q: vec3<f32>) -> bool {
    return all(edges_at(triangle, q) >= vec3<f32>(0.0));
}

// Room in these products for what another shader, which may round otherwise, took for covered.
fn edge_slack(triangle: Triangle) -> vec3<f32> {
    return SAME_EDGE * vec3<f32>(length(triangle.e0), length(triangle.e1), length(triangle.e2));
}

// The sine of an angle.
const SAME_EDGE: f32 = 1e-6;

fn covers_nearly(triangle: Triangle, q: vec3<f32>) -> bool {
    return all(edges_at(triangle, q) >= -edge_slack(triangle));
}

// How far apart two shaders may find the depth of one triangle at one texel: relative to what is summed, which cancels where
// the triangle is seen at a grazing angle.
const SAME_DEPTH: f32 = 1e-6;

fn is_same_depth(triangle: Triangle, z: f32, depth: f32) -> bool {
    return abs(z - depth) <= same_depth_margin(triangle, depth);
}

fn same_depth_margin(triangle: Triangle, depth: f32) -> f32 {
    return SAME_DEPTH * (depth + LONGEST_DIRECTION * length(triangle.plane));
}

// Whether a triangle may have a texel's depth in the end, by what the texel holds so far. Whichever is drawn first, all that
// do are found.
fn may_be_numbered(triangle: Triangle, z: f32, so_far: f32) -> bool {
    return z >= so_far - 3.0 * same_depth_margin(triangle, so_far);
}

fn depth_at(triangle: Triangle, q: vec3<f32>) -> f32 {
    return clamp(dot(triangle.plane, q), triangle.limits.x, triangle.limits.y);
}

// The part of a row that a plane doesn't exclude, relative to its middle, which reaches `half` to either side.
fn trimmed(span: vec2<f32>, e: vec3<f32>, middle: vec2<f32>, half: f32) -> vec2<f32> {
    let at = dot(e, scaled_direction(middle));
    let bent = spread(vec3<f32>(0.0, 0.0, e.z), vec2<f32>(0.0), vec2<f32>(half, 0.0));
    let slope = slope_along_row(e, middle.x);
    let pad = bent + 1e-6 * (abs(e.x) + abs(e.y) + abs(e.z));
    let cut = clamp(-(at + pad) / slope, -2.0 * half, 2.0 * half);
    return vec2<f32>(select(span.x, max(span.x, cut), slope > 0.0), select(span.y, min(span.y, cut), slope < 0.0));
}

// Texels of a row of a box that a triangle may cover: first and last.
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

// Where the workspace has four texels of a row, the last one over where it has ended.
fn row_places(view: View, square: u32, x: i32, y: i32, last: i32) -> vec4<u32> {
    return vec4<u32>(
        place_of_texel(view, square, x, y),
        place_of_texel(view, square, min(x + 1, last), y),
        place_of_texel(view, square, min(x + 2, last), y),
        place_of_texel(view, square, min(x + 3, last), y),
    );
}
