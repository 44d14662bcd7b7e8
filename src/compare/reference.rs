//! The truth: what a point light sees, by ray casting in double precision against the casters' triangles.
//!
//! Everything is relative to the light (world axes, the light at the origin, world units): the light's position is
//! subtracted once, in double precision, from corners that were widened from single precision, so coordinates far from
//! the world's origin cost nothing. Rays start at the origin, or close by for a light that has a size. A triangle
//! `A, B, C` seen from there is a cone of three planes, and the ray along `d` is inside it when the three triple products `(A x B).d`, `(B x C).d` and
//! `(C x A).d` have one sign. A shared edge gives both its triangles the same product but for the sign, to the bit,
//! so no ray slips through between them; a margin of the product's own rounding error does the same for corners.
//!
//! The tree comes from the crate `bvh`: it is generic over the float, so it can be built in double precision, splits by
//! the surface-area heuristic, builds in parallel and is maintained. Its own traversals return a list or an iterator of
//! candidates in no strict order; nearest-hit queries in millions want the near child first and an early end, so its
//! nodes are repacked (boxes rounded outward to single precision, two children to a node) and walked here.

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy};
use bvh::bvh::{Bvh, BvhNode};
use glam::{DQuat, DVec3, Vec3A};
use nalgebra::Point3;
use rayon::prelude::*;

use super::CutOuts;
use super::closed_pieces::hidden_sides;
use crate::chunks::ClosedPiece;
use crate::paraboloid::double as paraboloid;

/// Bound of the rounding error of a triple product `(A x B).d`, relative to `|A| |B|`, for a unit `d`.
const TRIPLE_PRODUCT_ERROR: f64 = 16.0 * f64::EPSILON;

/// How much the interval of a ray inside a box is widened for the rounding of single precision, relative.
const BOX_MARGIN: f32 = 1e-6;

/// Which sides of a triangle cast shadows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides {
    /// Both, whatever way the triangle faces.
    #[default]
    Both,
    /// Only the front (corners anticlockwise as the light sees them): a triangle that shows the light its back casts
    /// nothing, as in engines that cull back faces in their shadow passes.
    Front,
}

/// Where a light looks from: what turns world directions into map coordinates, and what a map clips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The light's position in the world.
    pub position: DVec3,
    /// Rotation from light space to the world.
    pub orientation: DQuat,
    /// Clip distance in world units: a map doesn't hold what has `w = |X| + X.z < near` in its hemisphere.
    pub near: f64,
    /// Farthest distance, in world units, at which receivers are lit and casters have to be in the map. May be
    /// infinite.
    pub range: f64,
}

impl View {
    /// A vector relative to the light (world axes) in hemisphere space, and whether that is the back hemisphere.
    #[must_use]
    pub fn to_hemisphere(&self, relative: DVec3) -> (DVec3, bool) {
        let light_space = self.orientation.inverse() * relative;
        let back = paraboloid::is_back(light_space);
        (paraboloid::to_hemisphere(light_space, back), back)
    }

    /// A vector of hemisphere space in world axes.
    #[must_use]
    pub fn to_world(&self, x: DVec3, back: bool) -> DVec3 {
        // Half a turn about Y undoes itself.
        self.orientation * paraboloid::to_hemisphere(x, back)
    }

    /// Distance, in world units, at which a map starts to hold casters in a unit direction of its hemisphere:
    /// `w >= near`. Half of `near` on the axis, `near` at the rim.
    #[must_use]
    pub fn clip_distance(&self, hemisphere_direction: DVec3) -> f64 {
        self.near / paraboloid::homogeneous_w(hemisphere_direction)
    }
}

/// The nearest caster in a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance from the light in world units.
    pub t: f64,
    /// Index of the triangle, in the order they were given.
    pub triangle: u32,
}

/// The triangles of a scene, relative to a light, and the tree over those of them that cast shadows.
pub struct Reference {
    light_position: DVec3,
    triangles: Vec<[DVec3; 3]>,
    cut_outs: CutOuts,
    /// One for each triangle, or none at all: all are double-sided then.
    double_sided: Vec<bool>,
    /// Whether a triangle's side that faces the light is hidden inside a closed piece; none are if it's empty.
    hidden: Vec<bool>,
    nodes: Vec<Node>,
    /// Deepest level of the tree: what a traversal's stack has to hold.
    depth: usize,
}

impl Reference {
    /// Reads world triangles (corners widened from single precision) and builds the tree.
    ///
    /// `sides` says for each triangle which of its sides cast; `None` is [`Sides::Both`] for all. Triangles with no
    /// area or with corners that aren't finite cast nothing, but keep their index.
    ///
    /// # Panics
    /// When `sides` has another length than `triangles`, or there are more than 2^31 triangles.
    #[must_use]
    pub fn new(triangles: &[[DVec3; 3]], sides: Option<&[Sides]>, light_position: DVec3) -> Self {
        assert!(sides.is_none_or(|sides| sides.len() == triangles.len()), "one entry of `sides` a triangle");
        assert!(triangles.len() < LEAF as usize, "at most 2^31 triangles");
        let triangles: Vec<[DVec3; 3]> =
            triangles.par_iter().map(|corners| corners.map(|corner| corner - light_position)).collect();
        let casters: Vec<u32> = (0..triangles.len())
            .into_par_iter()
            .filter(|&i| casts(&triangles[i], sides.map_or(Sides::Both, |sides| sides[i])))
            .map(|i| i as u32)
            .collect();
        let (nodes, depth) = build_tree(&triangles, &casters);
        let (cut_outs, double_sided, hidden) = (CutOuts::default(), Vec::new(), Vec::new());
        Self { light_position, triangles, cut_outs, double_sided, hidden, nodes, depth }
    }

    /// Cuts holes into triangles: rays go through them.
    ///
    /// # Panics
    /// When there are cut-outs for another number of triangles, but for none at all.
    #[must_use]
    pub fn with_cut_outs(self, cut_outs: CutOuts) -> Self {
        let count = cut_outs.triangles.len();
        assert!(count == 0 || count == self.triangles.len(), "one cut-out a triangle");
        Self { cut_outs, ..self }
    }

    /// Says which triangles a renderer draws and lights on both sides; of the others only the front (corners
    /// anticlockwise). Which sides cast is another matter: see [`Self::new`].
    ///
    /// # Panics
    /// When there is not one entry a triangle.
    #[must_use]
    pub fn with_double_sided(self, double_sided: Vec<bool>) -> Self {
        assert!(double_sided.len() == self.triangles.len(), "one entry of `double_sided` a triangle");
        Self { double_sided, ..self }
    }

    /// Says which triangles make closed pieces whose insides are hidden from outside: receivers aren't drawn there unless
    /// the light is inside ([`sample_receivers`](super::error_figures::sample_receivers)). Rays are unaffected.
    ///
    /// # Panics
    /// When there are pieces for another number of triangles, but for none at all.
    #[must_use]
    pub(super) fn with_closed_pieces(self, pieces: &[Option<ClosedPiece>]) -> Self {
        let hidden = if pieces.is_empty() { Vec::new() } else { hidden_sides(&self.triangles, pieces) };
        Self { hidden, ..self }
    }

    /// The light's position in the world.
    #[must_use]
    pub fn light_position(&self) -> DVec3 {
        self.light_position
    }

    /// All triangles, casters or not, relative to the light.
    #[must_use]
    pub fn triangles(&self) -> &[[DVec3; 3]] {
        &self.triangles
    }

    /// Unit normal of a triangle (corners anticlockwise around it), zero for one of no area.
    #[must_use]
    pub fn normal(&self, triangle: u32) -> DVec3 {
        normal(&self.triangles[triangle as usize]).normalize_or_zero()
    }

    /// Whether a renderer draws the side of a triangle that `from` (relative to the light) is on: its front, or either
    /// side of a double-sided one. `false` in the triangle's plane.
    #[must_use]
    pub fn shows(&self, triangle: u32, from: DVec3) -> bool {
        let corners = &self.triangles[triangle as usize];
        let facing = normal(corners).dot(from - corners[0]);
        facing > 0.0 || (facing < 0.0 && self.is_double_sided(triangle))
    }

    /// Whether `from` (relative to the light) is on the front of a triangle. `false` in the triangle's plane.
    #[must_use]
    pub fn shows_front(&self, triangle: u32, from: DVec3) -> bool {
        let corners = &self.triangles[triangle as usize];
        normal(corners).dot(from - corners[0]) > 0.0
    }

    /// Whether someone may see the light on a triangle: a renderer draws the side that faces the light, and it isn't
    /// hidden inside a closed piece. What [`sample_receivers`](super::error_figures::sample_receivers) draws from.
    #[must_use]
    pub fn receives(&self, triangle: u32) -> bool {
        self.shows(triangle, DVec3::ZERO) && !self.hidden.get(triangle as usize).is_some_and(|hidden| *hidden)
    }

    fn is_double_sided(&self, triangle: u32) -> bool {
        self.double_sided.get(triangle as usize).is_none_or(|both| *both)
    }

    /// Whether the direction of a triangle's point is that of a hole in it.
    #[must_use]
    pub fn is_hole(&self, triangle: u32, direction: DVec3) -> bool {
        self.cut_outs.is_hole(triangle, &self.triangles[triangle as usize], direction)
    }

    /// The nearest caster in a unit direction at a distance of at least `t_min`.
    #[must_use]
    pub fn nearest(&self, direction: DVec3, t_min: f64) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        self.traverse(&Ray::new(DVec3::ZERO, direction), f64::INFINITY, |triangle, t, t_max| {
            if t < t_min || t >= t_max {
                return t_max;
            }
            nearest = Some(Hit { t, triangle });
            t
        });
        nearest
    }

    /// The nearest caster that a camera at `eye` (relative to the light) shows in a unit direction: one that shows the
    /// camera its back is looked through, as renderers cull it, unless it is double-sided. `t` is the distance from the
    /// eye.
    #[must_use]
    pub fn seen_from(&self, eye: DVec3, direction: DVec3) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        self.traverse(&Ray::new(eye, direction), f64::INFINITY, |triangle, t, t_max| {
            if t >= t_max || !self.shows(triangle, eye) {
                return t_max;
            }
            nearest = Some(Hit { t, triangle });
            t
        });
        nearest
    }

    /// Whether a caster stands between the light and a point (relative to the light), at a distance of at least
    /// `t_min` from the light.
    ///
    /// The receiver's own triangle, `ignore`, doesn't occlude it. Nor does a surface that `target` lies *on*: one whose
    /// plane it is within `slack` world units of, where the ray enters it within 50 `slack` of `target` (a surface at
    /// more than about 1 degree to the ray). `slack` is how far rounding may have moved the target.
    #[must_use]
    pub fn occluded(&self, target: DVec3, ignore: Option<u32>, t_min: f64, slack: f64) -> bool {
        self.occluded_from(DVec3::ZERO, target, ignore, t_min, slack)
    }

    /// [`Self::occluded`] for a ray that starts elsewhere (relative to the light), with `t_min` the distance from there.
    #[must_use]
    pub fn occluded_from(&self, from: DVec3, target: DVec3, ignore: Option<u32>, t_min: f64, slack: f64) -> bool {
        let distance = target.distance(from);
        let mut occluded = false;
        self.traverse(&Ray::new(from, (target - from) / distance), distance, |triangle, t, t_max| {
            if t < t_min
                || t >= distance
                || Some(triangle) == ignore
                || self.lies_on(target, distance - t, triangle, slack)
            {
                return t_max;
            }
            occluded = true;
            f64::NEG_INFINITY
        });
        occluded
    }

    /// Whether `target` counts as a point of a triangle that its ray enters `gap` world units before it.
    pub(super) fn lies_on(&self, target: DVec3, gap: f64, triangle: u32, slack: f64) -> bool {
        gap <= 50.0 * slack && self.height(target, triangle).abs() <= slack
    }

    /// Signed distance of a point (relative to the light) from a triangle's plane, in world units.
    #[must_use]
    pub fn height(&self, point: DVec3, triangle: u32) -> f64 {
        self.normal(triangle).dot(point - self.triangles[triangle as usize][0])
    }

    /// Walks the tree near child first. `visit` gets each triangle that the ray meets at `t <= t_max`, with `t` and
    /// `t_max`, and returns the new `t_max`; minus infinity ends the walk.
    fn traverse(&self, ray: &Ray, mut t_max: f64, mut visit: impl FnMut(u32, f64, f64) -> f64) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack: Vec<(u32, f32)> = Vec::with_capacity(self.depth + 1);
        let mut next = Some(0);
        while let Some(index) = next {
            if index & LEAF != 0 {
                let triangle = index & !LEAF;
                let corners = self.triangles[triangle as usize].map(|corner| corner - ray.origin);
                if let Some(t) = intersect(&corners, ray.direction)
                    && t <= t_max
                    && !self.cut_outs.is_hole(triangle, &corners, ray.direction)
                {
                    t_max = visit(triangle, t, t_max);
                }
                next = pop_nearer(&mut stack, t_max);
                continue;
            }
            let node = &self.nodes[index as usize];
            let entries = node.boxes.map(|bounds| bounds.entry(ray, t_max));
            next = match entries {
                [Some(left), Some(right)] => {
                    let near = usize::from(right < left);
                    stack.push((node.children[1 - near], left.max(right)));
                    Some(node.children[near])
                }
                [Some(_), None] => Some(node.children[0]),
                [None, Some(_)] => Some(node.children[1]),
                [None, None] => pop_nearer(&mut stack, t_max),
            };
        }
    }
}

/// A ray in the light's own space.
struct Ray {
    origin: DVec3,
    direction: DVec3,
    /// The origin for boxes, if it isn't zero.
    start: Option<Vec3A>,
    inverse: Vec3A,
}

impl Ray {
    fn new(origin: DVec3, direction: DVec3) -> Self {
        let start = (origin != DVec3::ZERO).then(|| origin.as_vec3a());
        Self { origin, direction, start, inverse: finite_inverse(direction) }
    }
}

/// The last node put off that the ray enters before `t_max`.
fn pop_nearer(stack: &mut Vec<(u32, f32)>, t_max: f64) -> Option<u32> {
    while let Some((index, entry)) = stack.pop() {
        if f64::from(entry) <= t_max {
            return Some(index);
        }
    }
    None
}

/// Twice a triangle's area along its normal.
fn normal(corners: &[DVec3; 3]) -> DVec3 {
    (corners[1] - corners[0]).cross(corners[2] - corners[0])
}

/// Whether a triangle (relative to the light) casts anything.
fn casts(corners: &[DVec3; 3], sides: Sides) -> bool {
    let normal = normal(corners);
    let facing = normal.dot(corners[0]);
    normal.is_finite() && normal != DVec3::ZERO && (sides == Sides::Both || facing < 0.0)
}

/// Distance at which the ray from the origin along the unit `direction` meets a triangle, its edges and corners
/// included. `None` too for a triangle that lies in a plane with the ray: it has no width.
fn intersect(corners: &[DVec3; 3], direction: DVec3) -> Option<f64> {
    let [a, b, c] = *corners;
    let products = [a.cross(b).dot(direction), b.cross(c).dot(direction), c.cross(a).dot(direction)];
    if !one_sign(products) && !one_sign_within_rounding(products, corners) {
        return None;
    }
    let normal = normal(corners);
    let slope = normal.dot(direction);
    if slope == 0.0 {
        return None;
    }
    let along = corners.map(|corner| corner.dot(direction));
    let (nearest, farthest) = (along[0].min(along[1]).min(along[2]), along[0].max(along[1]).max(along[2]));
    // The clamp binds for triangles seen almost edge-on, where the quotient is mostly rounding error.
    let t = (normal.dot(a) / slope).clamp(nearest, farthest);
    (t > 0.0).then_some(t)
}

fn one_sign(products: [f64; 3]) -> bool {
    products.iter().all(|&e| e >= 0.0) || products.iter().all(|&e| e <= 0.0)
}

/// As [`one_sign`], with products that are smaller than their rounding error counted as zero.
fn one_sign_within_rounding(products: [f64; 3], corners: &[DVec3; 3]) -> bool {
    let squares = corners.map(DVec3::length_squared);
    let rounded: [f64; 3] = std::array::from_fn(|i| {
        let bound = TRIPLE_PRODUCT_ERROR * TRIPLE_PRODUCT_ERROR * squares[i] * squares[(i + 1) % 3];
        if products[i] * products[i] <= bound { 0.0 } else { products[i] }
    });
    one_sign(rounded)
}

/// Componentwise inverse of a direction, with infinity replaced by a number that can still be multiplied by zero.
fn finite_inverse(direction: DVec3) -> Vec3A {
    direction.as_vec3a().map(
        |component| {
            if component.abs() < 1e-30 { 1e30_f32.copysign(component) } else { 1.0 / component }
        },
    )
}

/// Marks a child as a triangle in place of a node.
const LEAF: u32 = 1 << 31;

/// Inner node of the tree: two children, each with its bounds.
struct Node {
    boxes: [Bounds; 2],
    children: [u32; 2],
}

/// An axis-aligned box in single precision, rounded outward.
#[derive(Clone, Copy)]
struct Bounds {
    min: Vec3A,
    max: Vec3A,
}

impl Bounds {
    fn new(bounds: &Aabb<f64, 3>) -> Self {
        let corner =
            |point: &Point3<f64>, round: fn(f64) -> f32| Vec3A::new(round(point.x), round(point.y), round(point.z));
        Self { min: corner(&bounds.min, round_down), max: corner(&bounds.max, round_up) }
    }

    /// Distance at which a ray enters the box, if it does at `t_max` at the latest. A lower bound.
    ///
    /// That rays start at the origin is what makes single precision enough: each bound is one product, without
    /// cancellation. For others the box is wider by the rounding of the difference.
    #[inline]
    fn entry(&self, ray: &Ray, t_max: f64) -> Option<f32> {
        let inverse = ray.inverse;
        let (one, other) = match ray.start {
            None => (self.min * inverse, self.max * inverse),
            Some(start) => {
                let rounding = BOX_MARGIN * (start.abs() + self.min.abs().max(self.max.abs()));
                ((self.min - start - rounding) * inverse, (self.max - start + rounding) * inverse)
            }
        };
        let entry = one.min(other).max_element().max(0.0) * (1.0 - BOX_MARGIN);
        let exit = one.max(other).min_element() * (1.0 + BOX_MARGIN);
        (entry <= exit && f64::from(entry) <= t_max).then_some(entry)
    }
}

fn round_down(x: f64) -> f32 {
    let rounded = x as f32;
    if f64::from(rounded) > x { rounded.next_down() } else { rounded }
}

fn round_up(x: f64) -> f32 {
    -round_down(-x)
}

/// A triangle as the crate `bvh` wants it: its bounds. Its place in the list is its identity.
struct Shape(Aabb<f64, 3>);

impl Bounded<f64, 3> for Shape {
    fn aabb(&self) -> Aabb<f64, 3> {
        self.0
    }
}

impl BHShape<f64, 3> for Shape {
    // Only needed to change a tree after it was built.
    fn set_bh_node_index(&mut self, _: usize) {}

    fn bh_node_index(&self) -> usize {
        0
    }
}

impl Shape {
    fn new(corners: &[DVec3; 3]) -> Self {
        let [a, b, c] = *corners;
        let point = |p: DVec3| Point3::new(p.x, p.y, p.z);
        Self(Aabb::with_bounds(point(a.min(b).min(c)), point(a.max(b).max(c))))
    }
}

/// The tree over the casters, and its depth. The first node is the root; no nodes without casters.
fn build_tree(triangles: &[[DVec3; 3]], casters: &[u32]) -> (Vec<Node>, usize) {
    let mut shapes: Vec<Shape> = casters.par_iter().map(|&i| Shape::new(&triangles[i as usize])).collect();
    if let [shape] = shapes.as_slice() {
        // The crate's tree would be a leaf alone; as both children of a node it needs no case of its own.
        let node = Node { boxes: [Bounds::new(&shape.0); 2], children: [LEAF | casters[0]; 2] };
        return (vec![node], 1);
    }
    let tree = Bvh::build_par(&mut shapes);
    drop(shapes);
    pack(&tree.nodes, casters)
}

/// Repacks the crate's nodes, where children come after their parents, leaving out the leaves.
fn pack(tree: &[BvhNode<f64, 3>], casters: &[u32]) -> (Vec<Node>, usize) {
    let mut inner = 0;
    let places: Vec<u32> = tree
        .iter()
        .map(|node| match node {
            BvhNode::Leaf { shape_index, .. } => LEAF | casters[*shape_index],
            BvhNode::Node { .. } => {
                inner += 1;
                inner - 1
            }
        })
        .collect();
    let mut levels = vec![0_u32; tree.len()];
    let mut nodes = Vec::with_capacity(inner as usize);
    for (index, node) in tree.iter().enumerate() {
        if let BvhNode::Node { child_l_index: l, child_r_index: r, child_l_aabb, child_r_aabb, .. } = node {
            levels[*l] = levels[index] + 1;
            levels[*r] = levels[index] + 1;
            nodes.push(Node {
                boxes: [Bounds::new(child_l_aabb), Bounds::new(child_r_aabb)],
                children: [places[*l], places[*r]],
            });
        }
    }
    (nodes, levels.iter().max().map_or(0, |&level| level as usize))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::test_shapes::{box_triangles, random_direction, random_vector};
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    /// Triangles of all sizes around the light; every tenth has no area.
    fn soup(random: &mut Pcg64, count: usize) -> Vec<[DVec3; 3]> {
        (0..count)
            .map(|i| {
                let size = 10.0_f64.powf(random.random_range(-2.0..1.0));
                let a = random_vector(random) * 5.0;
                let b = a + random_vector(random) * size;
                let c = match i % 20 {
                    0 => a,
                    10 => a + (b - a) * 2.0,
                    _ => a + random_vector(random) * size,
                };
                [a, b, c]
            })
            .collect()
    }

    fn nearest_by_brute_force(reference: &Reference, direction: DVec3, t_min: f64) -> Option<Hit> {
        let hits = (0..).zip(reference.triangles()).filter(|(_, corners)| casts(corners, Sides::Both));
        hits.filter_map(|(triangle, corners)| Some(Hit { t: intersect(corners, direction)?, triangle }))
            .filter(|hit| hit.t >= t_min)
            .min_by(|one, other| one.t.total_cmp(&other.t))
    }

    #[test]
    fn nearest_is_that_of_brute_force() {
        let mut random = Pcg64::seed_from_u64(1);
        for count in [0, 1, 2, 3, 30, 3000] {
            let reference = Reference::new(&soup(&mut random, count), None, DVec3::new(0.3, -0.2, 0.1));
            for _ in 0..1000 {
                let (direction, t_min) = (random_direction(&mut random), random.random_range(-2.0..2.0));
                let expected = nearest_by_brute_force(&reference, direction, t_min);
                assert_eq!(reference.nearest(direction, t_min), expected, "{count} {direction} {t_min}");
            }
        }
    }

    #[test]
    fn occluded_is_that_of_brute_force() {
        let mut random = Pcg64::seed_from_u64(2);
        let reference = Reference::new(&soup(&mut random, 300), None, DVec3::ZERO);
        let mut dark = 0;
        for _ in 0..10_000 {
            let target = random_vector(&mut random) * 5.0;
            let (direction, distance) = (target / target.length(), target.length());
            let first = nearest_by_brute_force(&reference, direction, 0.1).filter(|hit| hit.t < distance);
            assert_eq!(reference.occluded(target, None, 0.1, 0.0), first.is_some(), "{target}");
            let Some(first) = first else { continue };
            let second =
                nearest_by_brute_force(&reference, direction, first.t.next_up()).filter(|hit| hit.t < distance);
            assert_eq!(reference.occluded(target, Some(first.triangle), 0.1, 0.0), second.is_some(), "{target}");
            dark += 1;
        }
        assert!((1000..9000).contains(&dark), "{dark}");
    }

    /// Points are put into a triangle's plane by weights of its corners: those say whether the ray must hit.
    #[test]
    fn intersection_is_where_the_point_was_put() {
        let mut random = Pcg64::seed_from_u64(3);
        let mut hits = 0;
        // Those with no area but what rounding gives them are left out.
        for corners in soup(&mut random, 100_000).iter().filter(|corners| normal(corners).length() > 1e-9) {
            let weights = [random.random_range(-0.5..1.5), random.random_range(-0.5..1.5)];
            let inside = weights[0] > 0.0 && weights[1] > 0.0 && weights[0] + weights[1] < 1.0;
            let [a, b, c] = *corners;
            let point = a + (b - a) * weights[0] + (c - a) * weights[1];
            let t = intersect(corners, point.normalize());
            assert_eq!(t.is_some(), inside, "{corners:?} {weights:?}");
            if let Some(t) = t {
                let slope = (normal(corners).normalize().dot(point.normalize())).abs();
                assert!((t - point.length()).abs() < 1e-13 * (1.0 + a.length()) / slope, "{t} {}", point.length());
                hits += 1;
            }
        }
        assert!(hits > 10_000);
    }

    /// Rays through every corner, through points of every edge and straight along the axes, of closed boxes around the
    /// light: all must hit.
    #[test]
    fn no_ray_slips_through_an_edge_or_a_corner() {
        let mut random = Pcg64::seed_from_u64(4);
        for _ in 0..2000 {
            let turn = DQuat::from_scaled_axis(random_vector(&mut random) * 3.0);
            let size = DVec3::from_array(std::array::from_fn(|_| 10.0_f64.powf(random.random_range(-2.0..2.0))));
            let light = random_vector(&mut random) * size * 0.9;
            let triangles: Vec<_> = box_triangles(-size, size).iter().map(|t| t.map(|corner| turn * corner)).collect();
            let reference = Reference::new(&triangles, None, turn * light);
            for corners in reference.triangles() {
                for i in 0..3 {
                    let share = random.random_range(0.0..1.0);
                    for point in [corners[i], corners[i].lerp(corners[(i + 1) % 3], share)] {
                        let hit = reference.nearest(point.normalize(), 0.0);
                        let t = hit.expect("a closed box was left").t;
                        assert!((t - point.length()).abs() < 1e-6 * point.length(), "{t} {}", point.length());
                    }
                }
            }
            for axis in DVec3::AXES {
                assert!(reference.nearest(axis, 0.0).is_some() && reference.nearest(-axis, 0.0).is_some());
            }
        }
    }

    #[test]
    fn coordinates_far_from_the_origin_cost_nothing() {
        let offset = DVec3::new(1e5, -3e5, 2e5);
        let mut random = Pcg64::seed_from_u64(5);
        let triangles = soup(&mut random, 300);
        // Rounded, so that moving them is exact.
        let round = |p: DVec3| (p * 1024.0).round() / 1024.0;
        let near: Vec<_> = triangles.iter().map(|t| t.map(round)).collect();
        let far: Vec<_> = near.iter().map(|t| t.map(|corner| corner + offset)).collect();
        let (near, far) = (Reference::new(&near, None, DVec3::ZERO), Reference::new(&far, None, offset));
        for _ in 0..1000 {
            let direction = random_direction(&mut random);
            assert_eq!(near.nearest(direction, 0.0), far.nearest(direction, 0.0));
        }
    }

    #[test]
    fn single_sided_triangles_cast_only_with_their_front() {
        let facing = [DVec3::new(-1.0, -1.0, -2.0), DVec3::new(1.0, -1.0, -2.0), DVec3::new(0.0, 1.0, -2.0)];
        let turned_away = [facing[0], facing[2], facing[1]];
        let hits = |triangle, sides| {
            Reference::new(&[triangle], Some(&[sides]), DVec3::ZERO).nearest(DVec3::NEG_Z, 0.0).is_some()
        };
        assert!(hits(facing, Sides::Front) && hits(facing, Sides::Both) && hits(turned_away, Sides::Both));
        assert!(!hits(turned_away, Sides::Front));
    }

    #[test]
    fn backs_are_shown_of_double_sided_triangles_alone() {
        let wall = |z: f64| [DVec3::new(-1.0, -1.0, z), DVec3::new(1.0, -1.0, z), DVec3::new(0.0, 1.0, z)];
        let seen = |double_sided: [bool; 2], eye: DVec3, direction: DVec3| {
            let reference = Reference::new(&[wall(-2.0), wall(-3.0)], None, DVec3::ZERO);
            let hit = reference.with_double_sided(double_sided.to_vec()).seen_from(eye, direction);
            hit.map(|hit| (hit.triangle, hit.t))
        };
        // Both face +Z.
        assert_eq!(seen([false, false], DVec3::ZERO, DVec3::NEG_Z), Some((0, 2.0)));
        let behind = DVec3::new(0.0, 0.0, -5.0);
        assert_eq!(seen([false, false], behind, DVec3::Z), None);
        assert_eq!(seen([true, false], behind, DVec3::Z), Some((0, 3.0)));
        assert_eq!(seen([true, true], behind, DVec3::Z), Some((1, 2.0)));
        let reference = Reference::new(&[wall(-2.0)], None, DVec3::ZERO).with_double_sided(vec![true]);
        assert!(!reference.shows(0, DVec3::new(5.0, 1.0, -2.0)), "edge-on");
    }

    #[test]
    fn a_surface_that_the_target_lies_on_does_not_occlude_it() {
        let wall = |z: f64| [DVec3::new(-1.0, -1.0, z), DVec3::new(1.0, -1.0, z), DVec3::new(0.0, 1.0, z)];
        let reference = Reference::new(&[wall(-2.0), wall(-2.0 + 1e-4)], None, DVec3::ZERO);
        let target = DVec3::new(0.1, 0.1, -2.0);
        assert!(reference.occluded(target, Some(0), 0.0, 0.9e-4), "a gap wider than the slack");
        assert!(!reference.occluded(target, Some(0), 0.0, 1.1e-4), "a gap narrower than the slack");
        assert!(!reference.occluded(target, Some(1), 0.0, 1e-12), "its own triangle's twin at the same place");
    }

    /// Deep trees: triangles along a line whose sizes and places shrink by halves.
    #[test]
    fn a_lopsided_tree_is_walked_to_its_end() {
        let triangles: Vec<[DVec3; 3]> = (0..400)
            .map(|i| {
                let z = 0.9_f64.powi(i);
                [DVec3::new(-z, -z, z), DVec3::new(z, -z, z), DVec3::new(0.0, z, z)]
            })
            .collect();
        let reference = Reference::new(&triangles, None, DVec3::ZERO);
        assert_eq!(reference.nearest(DVec3::Z, 0.0).map(|hit| hit.triangle), Some(399));
        assert_eq!(reference.nearest(DVec3::Z, 0.5).map(|hit| hit.triangle), Some(6));
    }
}
