// The projection of the maps, as the rasteriser needs it: a texel's centre p is the direction q of `scaled_direction`, a
// plane through the light is one of q, and depth over a triangle is linear in q. Another projection takes this file's place
// in the comparison's cube (shaders/compare/cube_projection.wgsl).

// Maps of a light.
const SQUARES: u32 = 2u;
// Length of the longest q.
const LONGEST_DIRECTION: f32 = 1.0;

// A map's upper left texel, and its layer.
fn square_origin(view: View, square: u32) -> vec3<u32> {
    return vec3<u32>(view.left + square * u32(view.resolution), view.top, view.layer);
}

fn square_space(view: View, relative: vec3<f32>, square: u32) -> vec3<f32> {
    let x = vec3<f32>(dot(view.right, relative), dot(view.up, relative), dot(view.forward, relative));
    return dp_to_hemisphere(x, square == 1u);
}

// A vertex as a map sees it: in the map's space, its w, negative where it is behind the map, and its map coordinates.
struct Corner {
    place: vec3<f32>,
    w: f32,
    map: vec2<f32>,
}

fn corner_of(view: View, relative: vec3<f32>, square: u32) -> Corner {
    let place = square_space(view, relative, square);
    let w = dp_homogeneous_w(place);
    let is_behind = place.z < view.behind * length(place);
    return Corner(place, select(w, -max(w, 1e-30), is_behind), dp_project(place));
}

// Whether all corners are behind the map. Then so is all between them, since what is behind is a convex cone.
fn is_outside(view: View, a: Corner, b: Corner, c: Corner) -> bool {
    return max(a.w, max(b.w, c.w)) < 0.0;
}

fn scaled_direction(p: vec2<f32>) -> vec3<f32> {
    return dp_unproject_scaled(p);
}

// The third component of the directions of two texels of a column.
fn scaled_directions_z(u: f32, v: vec2<f32>) -> vec2<f32> {
    return 0.5 - 0.5 * (u * u + v * v);
}

// Whether edges between these corners are arcs no longer than `arc_bow` allows for.
fn is_near(a: Corner, b: Corner, c: Corner) -> bool {
    return max(dot(a.map, a.map), max(dot(b.map, b.map), dot(c.map, c.map))) < 2.0;
}

// How far the arc of an edge leaves its chord at most, in map coordinates, if `is_near`: edges curve by 1 at most.
fn arc_bow(square_of_chord: f32) -> f32 {
    return select(0.13 * square_of_chord, 0.5 * sqrt(square_of_chord), square_of_chord > 0.5);
}

// Whether the cone of three edges, whose normals point inward, has the axis behind in it: it then covers what is outside of
// its arcs.
fn is_around_back(e0: vec3<f32>, e1: vec3<f32>, e2: vec3<f32>) -> bool {
    return e0.z <= 0.0 && e1.z <= 0.0 && e2.z <= 0.0;
}

// How fast a plane's product with q grows along u.
fn slope_along_row(e: vec3<f32>, u: f32) -> f32 {
    return e.x - e.z * u;
}

// How much a plane's product with q may differ, within h of c along the axes, from that at c.
fn spread(e: vec3<f32>, c: vec2<f32>, h: vec2<f32>) -> f32 {
    return dot(abs(e.xy - e.z * c), h) + 0.5 * abs(e.z) * dot(h, h);
}

// Whether anything is looked up as near to the axis as p: within the guard band's disc.
fn is_looked_up(view: View, p: vec2<f32>) -> bool {
    let half_width = 0.5 * view.resolution * view.texel;
    return dot(p, p) <= half_width * half_width;
}

// The maps in which a box, relative to the light, may be seen, as bits.
fn squares_of(view: View, low: vec3<f32>, high: vec3<f32>) -> u32 {
    // Highest and lowest z of light space in the box, and how far that still is inside a hemisphere.
    let centre = dot(view.forward, 0.5 * (low + high));
    let extent = dot(abs(view.forward), 0.5 * (high - low));
    let slack = (1e-5 - view.behind) * length(max(abs(low), abs(high)));
    let front = centre + extent + slack >= 0.0;
    let back = extent - centre + slack >= 0.0;
    return (select(0u, 1u, front) | select(0u, 2u, back)) & view.hemispheres;
}
