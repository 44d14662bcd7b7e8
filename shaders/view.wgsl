// A job, that is a light and a stretch of the chunks, as the stages see it, and the layout of what they hand on; twins in
// src/view.rs.

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
    // How far a chord may bend at the outline of a triangle, in texels.
    tolerance: f32,
    // Texels across one map.
    resolution: f32,
    // A direction is behind a hemisphere when its z is below this.
    behind: f32,
    // Bit 0 the front, bit 1 the back.
    hemispheres: u32,
    first_chunk: u32,
    end_chunk: u32,
    // Where the job's share of the lists begins, in triangles, and how many each hemisphere has room for there.
    first_triangle: u32,
    list_capacity: u32,
    // The same of the pieces.
    first_piece: u32,
    piece_capacity: u32,
    // How far a chord may bend inside of a triangle, where its plane doesn't make it wrong.
    longest_bend: f32,
    // Bit k is set if chunks of kind k take part.
    @size(152) kinds: u32,
}

// Arguments of the indirect draws, and the counters they come from. Index 0 is the front, 1 the back.
struct DrawIndexed {
    index_count: atomic<u32>,
    instance_count: u32,
    first_index: u32,
    base_vertex: u32,
    first_instance: u32,
}

struct Draw {
    vertex_count: atomic<u32>,
    instance_count: atomic<u32>,
    first_vertex: u32,
    first_instance: u32,
}

struct Arguments {
    whole: array<DrawIndexed, 2>,
    pieces: array<Draw, 2>,
    // Triangles whose pieces found no room, drawn exactly, one instance each.
    exact: array<Draw, 2>,
    // Triangles that have to be split.
    to_split: array<atomic<u32>, 2>,
    // Pieces that the split made, whether there was room or not.
    pieces_wanted: array<atomic<u32>, 2>,
    // Middling parts of big triangles that the split's first time hands on.
    @size(136) parts: array<atomic<u32>, 2>,
}

// Jobs that the stages go through at a time; a workgroup's z says which.
const MOST_JOBS: u32 = 8u;

// Share of the tolerance by which a chord of a triangle's outline may miss its arc. Less would only cost more pieces: where
// the outline is decides which texels a triangle covers, and by then other errors are larger.
const OUTLINE_SHARE: f32 = 0.4;

// Where a hemisphere's part of the lists begins, in triangles.
fn list_start(hemisphere: u32) -> u32 {
    return view.first_triangle + view.list_capacity * hemisphere;
}

// Whether the job is of masked chunks; others never take part in it.
fn is_masked_job() -> bool {
    return (view.kinds & 3u) == 0u;
}

// Rejecting what can't change the map; off only to prove that it can't.
override REJECT: bool = true;

// Room for the rasteriser's snapping to 1/256 texel, for its arithmetic, and for ours.
fn raster_margin(view_resolution: f32) -> f32 {
    return 0.0078125 + view_resolution * 1e-6;
}

fn hemisphere_space(relative: vec3<f32>, hemisphere: u32) -> vec3<f32> {
    return dp_to_hemisphere(light_space(relative), hemisphere == 1u);
}

fn light_space(relative: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(view.right, relative), dot(view.up, relative), dot(view.forward, relative));
}

// A vertex as the tests below need it: map coordinates, then w, negative if the vertex is behind.
fn project_corner(x: vec3<f32>) -> vec3<f32> {
    let w = dp_homogeneous_w(x);
    let behind = x.z < view.behind * length(x);
    return vec3<f32>(dp_project(x), select(w, -max(w, 1e-30), behind));
}

// Of the edges from each corner to the next, how far they may bend, in texels.
fn edge_bends(a: vec2<f32>, b: vec2<f32>, c: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(
        dp_edge_bend(a, b, view.texels),
        dp_edge_bend(b, c, view.texels),
        dp_edge_bend(c, a, view.texels),
    );
}

// Of an edge of hemisphere space the sine of the angle to the axis: the share of the bend by which the edge curves at most,
// and by which the depth of any plane through it may be off along its normal. At least a half, since very long edges beside
// short ones make slivers.
fn edge_slant(a: vec3<f32>, b: vec3<f32>) -> f32 {
    let e = b - a;
    return max(sqrt(dot(e.xy, e.xy) / max(dot(e, e), 1e-36)), 0.5);
}

// Whether a triangle, given by its signed-w corners, is out of the hemisphere or in front of the near limit.
fn is_outside(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> bool {
    let behind = max(a.z, max(b.z, c.z)) < 0.0;
    let clipped = max(abs(a.z), max(abs(b.z), abs(c.z))) <= view.near;
    return behind || clipped;
}

// Whether the triangle that the hardware would draw covers no texel's centre.
fn is_between_texels(a: vec2<f32>, b: vec2<f32>, c: vec2<f32>) -> bool {
    let half = 0.5 * view.resolution - 0.5;
    let low = min(a, min(b, c)) * view.texels + half;
    let high = max(a, max(b, c)) * view.texels + half;
    let margin = raster_margin(view.resolution);
    let first = ceil(low - margin);
    let last = floor(high + margin);
    return last.x < first.x || last.y < first.y;
}

// Whether the drawn triangle surely has the culled orientation; `cull` is the area's sign that doesn't cast.
fn is_culled(a: vec2<f32>, b: vec2<f32>, c: vec2<f32>, cull: f32) -> bool {
    let e = (b - a) * view.texels;
    let f = (c - a) * view.texels;
    let g = f - e;
    let area = e.x * f.y - e.y * f.x;
    let longest = sqrt(max(dot(e, e), max(dot(f, f), dot(g, g))));
    return area * cull > longest * raster_margin(view.resolution) * 2.0;
}

// Height in texels below which a triangle is a sliver: the rasteriser's grid, of 1/256 texel, then makes the slope of its
// depth across a guess.
const SLIVER_HEIGHT: f32 = 0.03125;
// Texel footprints across a sliver, in units of its height, from where on that guess may be off by half a footprint.
const SLIVER_SLOPE: f32 = 64.0;

// What has to be added to 1/w of each corner so that a sliver seen edge-on has the depth of its longest edge all over. Else
// its depth, continued across, might come out nearer than all its corners. 0 for other triangles.
fn sliver_shifts(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec3<f32> {
    let e = b.xy - a.xy;
    let f = c.xy - b.xy;
    let g = a.xy - c.xy;
    let squares = vec3<f32>(dot(e, e), dot(f, f), dot(g, g));
    if squares.x >= max(squares.y, squares.z) {
        return vec3<f32>(0.0, 0.0, apex_shift(c, a, b));
    }
    if squares.y >= squares.z {
        return vec3<f32>(apex_shift(a, b, c), 0.0, 0.0);
    }
    return vec3<f32>(0.0, apex_shift(b, c, a), 0.0);
}

// The same for the corner that is opposite the longest edge, from p to q.
fn apex_shift(apex: vec3<f32>, p: vec3<f32>, q: vec3<f32>) -> f32 {
    let edge = q.xy - p.xy;
    let to_apex = apex.xy - p.xy;
    let square = max(dot(edge, edge), 1e-30);
    let height = abs(edge.x * to_apex.y - edge.y * to_apex.x) / sqrt(square) * view.texels;
    let on_edge = mix(1.0 / abs(p.z), 1.0 / abs(q.z), dot(edge, to_apex) / square);
    let shift = on_edge - 1.0 / abs(apex.z);
    let footprints = abs(shift * apex.z) * view.texels;
    return select(0.0, shift, height < SLIVER_HEIGHT && footprints > SLIVER_SLOPE * height);
}
