// Six faces of a cube in place of shaders/projection.wgsl: a texel's direction is q = (u, v, 1), edges are straight, and the
// depth is near / z of the face. Goes with cube_face.wgsl.

const SQUARES: u32 = 6u;
// From 19 texels across on, with the guard band.
const LONGEST_DIRECTION: f32 = 1.8;

fn square_origin(view: View, square: u32) -> vec3<u32> {
    return vec3<u32>(view.left, view.top, SQUARES * view.layer + square);
}

fn square_space(view: View, relative: vec3<f32>, square: u32) -> vec3<f32> {
    let x = vec3<f32>(dot(view.right, relative), dot(view.up, relative), dot(view.forward, relative));
    return cube_to_face(x, square);
}

struct Corner {
    place: vec3<f32>,
    w: f32,
    map: vec2<f32>,
}

fn corner_of(view: View, relative: vec3<f32>, square: u32) -> Corner {
    let place = square_space(view, relative, square);
    // On the plane z = 0 counts as behind it.
    let w = select(min(place.z, -1e-30), place.z, place.z > 0.0);
    return Corner(place, w, place.xy / w);
}

// Whether a triangle lies outside of one plane of the face's pyramid.
fn is_outside(view: View, a: Corner, b: Corner, c: Corner) -> bool {
    let half_width = 0.5 * view.resolution * view.texel;
    let w = half_width * vec3<f32>(a.w, b.w, c.w);
    let u = vec3<f32>(a.place.x, b.place.x, c.place.x);
    let v = vec3<f32>(a.place.y, b.place.y, c.place.y);
    return all(w < vec3<f32>(0.0)) || all(u > w) || all(-u > w) || all(v > w) || all(-v > w);
}

fn scaled_direction(p: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(p, 1.0);
}

fn scaled_directions_z(u: f32, v: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(1.0);
}

fn is_near(a: Corner, b: Corner, c: Corner) -> bool {
    return min(a.w, min(b.w, c.w)) > 0.0;
}

fn arc_bow(square_of_chord: f32) -> f32 {
    return 0.0;
}

fn is_around_back(e0: vec3<f32>, e1: vec3<f32>, e2: vec3<f32>) -> bool {
    return false;
}

fn slope_along_row(e: vec3<f32>, u: f32) -> f32 {
    return e.x;
}

fn spread(e: vec3<f32>, c: vec2<f32>, h: vec2<f32>) -> f32 {
    return dot(abs(e.xy), h);
}

fn is_looked_up(view: View, p: vec2<f32>) -> bool {
    return true;
}

fn squares_of(view: View, low: vec3<f32>, high: vec3<f32>) -> u32 {
    let middle = 0.5 * (low + high);
    let half = 0.5 * (high - low);
    // The box around the box, along light space's axes: larger than it only where the light is turned.
    let centre = vec3<f32>(dot(view.right, middle), dot(view.up, middle), dot(view.forward, middle));
    let slack = 1e-5 * length(max(abs(low), abs(high)));
    let extent = vec3<f32>(dot(abs(view.right), half), dot(abs(view.up), half), dot(abs(view.forward), half)) + slack;
    let half_width = 0.5 * view.resolution * view.texel;
    // Each side of a face's pyramid against the box's corner farthest inside.
    let beside = abs(centre) - extent;
    let positive = half_width * (centre + extent);
    let negative = half_width * (extent - centre);
    let sees_positive = (positive >= beside.yzx) & (positive >= beside.zxy) & (positive >= vec3<f32>(0.0));
    let sees_negative = (negative >= beside.yzx) & (negative >= beside.zxy) & (negative >= vec3<f32>(0.0));
    let bits = select(vec3<u32>(0u), vec3<u32>(1u, 4u, 16u), sees_positive)
        | select(vec3<u32>(0u), vec3<u32>(2u, 8u, 32u), sees_negative);
    return (bits.x | bits.y | bits.z) & view.hemispheres;
}
