//! Which triangles of a closed piece a light outside never sees first from behind, so that their backs may be left out.
//!
//! That edges match in pairs isn't enough: a bow tie, extruded, has a lobe that is inside out, and its nearest faces there are
//! backs. Where a ray from outside first meets the piece at a back, it comes from where the piece winds around a point 0 times
//! and goes on to where it winds -1 times. So what is known of a triangle is the *winding number before its front*: it is the
//! same all over the triangle, and over its neighbours, as long as nothing crosses them. From 0 on the back never shows.

use glam::{DVec3, Vec3};
use std::f64::consts::TAU;

/// How much of a product's factors rounding may be.
const ROUNDING: f64 = 1e-12;

/// Directions in which the faces of star-shaped bodies are counted; none that meshes have edges in.
const DIRECTIONS: [DVec3; 2] =
    [DVec3::new(0.367_879_44, 0.573_130_69, 0.732_290_07), DVec3::new(-0.731, 0.107, -0.674)];

/// Patches of a piece whose winding number is asked for, the largest first: each takes time in proportion to the piece.
const MOST_PATCHES: usize = 16;

/// Triangles of a leaf of the tree.
const LEAF: usize = 4;

/// For each triangle of a closed connected piece of some volume, wound outward, whether its back is surely hidden. The
/// triangles have the numbers of their corners in `positions`.
pub(crate) fn hidden_backs(corners: &[[u32; 3]], positions: &[Vec3]) -> Vec<bool> {
    let Some(origin) = corners.first().map(|corners| positions[corners[0] as usize].as_dvec3()) else {
        return Vec::new();
    };
    // Relative to a corner, so that little is lost far from the origin.
    let place = |corner: u32| positions[corner as usize].as_dvec3() - origin;
    let triangles: Vec<[DVec3; 3]> = corners.iter().map(|corners| corners.map(place)).collect();
    if is_star_shaped(&triangles, centre_of_volume(&triangles)) {
        return vec![true; corners.len()];
    }
    let crossed = Crossings::find(corners, &triangles);
    if !crossed.contains(&true) {
        // Without a crossing it is the boundary of its inside.
        return vec![true; corners.len()];
    }
    let mut hidden = vec![false; corners.len()];
    for patch in patches(corners, &crossed).iter().take(MOST_PATCHES) {
        let hides = winding_before(&triangles, patch[0] as usize).is_some_and(|winding| winding >= 0);
        patch.iter().for_each(|&triangle| hidden[triangle as usize] = hides);
    }
    hidden
}

fn centre_of_volume(triangles: &[[DVec3; 3]]) -> DVec3 {
    let (mut sum, mut volume) = (DVec3::ZERO, 0.0);
    for &[a, b, c] in triangles {
        let own = a.dot(b.cross(c));
        sum += own * (a + b + c);
        volume += own;
    }
    sum / (4.0 * volume)
}

/// Whether every direction from `middle` meets one triangle, from behind: what most solids are, and quickly told.
fn is_star_shaped(triangles: &[[DVec3; 3]], middle: DVec3) -> bool {
    // Seen from the middle the faces cover the sphere, without a fold, some times over. A direction tells how many times.
    let mut faces = [0; DIRECTIONS.len()];
    let all_seen_from_behind = triangles.iter().all(|corners| {
        let [a, b, c] = corners.map(|corner| corner - middle);
        let edges = [a.cross(b), b.cross(c), c.cross(a)];
        for (count, direction) in faces.iter_mut().zip(DIRECTIONS) {
            *count += u32::from(edges.iter().all(|edge| edge.dot(direction) > 0.0));
        }
        // NaN is not.
        edges[0].dot(c) > ROUNDING * a.length() * b.length() * c.length()
    });
    all_seen_from_behind && faces == [1; DIRECTIONS.len()]
}

/// How often the piece winds around what is just before a triangle's front; `None` where rounding, or another triangle at
/// the same place, doesn't let it be known.
fn winding_before(triangles: &[[DVec3; 3]], own: usize) -> Option<i32> {
    let [a, b, c] = triangles[own];
    let place = (a + b + c) / 3.0;
    let others = triangles.iter().enumerate().filter(|(triangle, _)| *triangle != own);
    let turns: f64 = others.map(|(_, corners)| solid_angle(corners.map(|corner| corner - place))).sum();
    // On the triangle itself its own solid angle is half a sphere's, either way.
    let winding = turns / (2.0 * TAU) - 0.5;
    ((winding - winding.round()).abs() < 0.01).then_some(winding.round() as i32)
}

/// Solid angle of a triangle seen from the origin, in steradians; negative from in front. Van Oosterom and Strackee,
/// "The solid angle of a plane triangle", 1983.
fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let [la, lb, lc] = [a, b, c].map(DVec3::length);
    2.0 * a.cross(b).dot(c).atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}

/// The triangles that nothing crosses, by patches that hang together at edges, the largest first.
fn patches(corners: &[[u32; 3]], crossed: &[bool]) -> Vec<Vec<u32>> {
    let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * corners.len());
    for ([a, b, c], triangle) in corners.iter().zip(0..) {
        edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| ([*a.min(b), *a.max(b)], triangle)));
    }
    edges.sort_unstable();
    let mut beyond = vec![[u32::MAX; 3]; corners.len()];
    let mut link = |from: u32, to: u32| {
        if let Some(free) = beyond[from as usize].iter_mut().find(|triangle| **triangle == u32::MAX) {
            *free = to;
        }
    };
    for pair in edges.chunk_by(|(a, _), (b, _)| a == b) {
        if let [(_, a), (_, b)] = *pair {
            link(a, b);
            link(b, a);
        }
    }
    let mut seen = crossed.to_vec();
    let mut patches = Vec::new();
    for first in 0..corners.len() {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        let mut patch = vec![first as u32];
        let mut at = 0;
        while let Some(&triangle) = patch.get(at) {
            at += 1;
            for next in beyond[triangle as usize] {
                if next != u32::MAX && !std::mem::replace(&mut seen[next as usize], true) {
                    patch.push(next);
                }
            }
        }
        patches.push(patch);
    }
    patches.sort_by_key(|patch| std::cmp::Reverse(patch.len()));
    patches
}

/// Finds the triangles that others cross or touch elsewhere than at common corners, by a tree of boxes.
struct Crossings<'a> {
    corners: &'a [[u32; 3]],
    triangles: &'a [[DVec3; 3]],
    /// Lowest and highest corners.
    boxes: Vec<[DVec3; 2]>,
    /// Unit normals.
    normals: Vec<DVec3>,
    /// For each corner of each triangle, whether those around it are sure to have nothing else in common.
    regular: Vec<[bool; 3]>,
    /// The triangles, leaf by leaf.
    order: Vec<u32>,
    nodes: Vec<Node>,
    crossed: Vec<bool>,
}

struct Node {
    low: DVec3,
    high: DVec3,
    /// Of `order`.
    run: std::ops::Range<usize>,
    children: Option<[usize; 2]>,
}

impl Node {
    fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

impl<'a> Crossings<'a> {
    fn find(corners: &'a [[u32; 3]], triangles: &'a [[DVec3; 3]]) -> Vec<bool> {
        let order = (0..triangles.len() as u32).collect();
        let crossed = vec![false; triangles.len()];
        let normal = |[a, b, c]: &[DVec3; 3]| (b - a).cross(c - a).normalize_or_zero();
        let normals: Vec<DVec3> = triangles.iter().map(normal).collect();
        let boxes = triangles.iter().map(|[a, b, c]| [a.min(*b).min(*c), a.max(*b).max(*c)]).collect();
        let regular = regular_corners(corners, triangles, &normals);
        let mut crossings = Self { corners, triangles, boxes, normals, regular, order, nodes: Vec::new(), crossed };
        let root = crossings.build(0..triangles.len());
        crossings.within(root);
        crossings.crossed
    }

    /// Makes the node of a run, and those below it.
    fn build(&mut self, run: std::ops::Range<usize>) -> usize {
        let Self { boxes, order, .. } = self;
        let own = &mut order[run.clone()];
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for [lowest, highest] in own.iter().map(|&triangle| boxes[triangle as usize]) {
            (low, high) = (low.min(lowest), high.max(highest));
        }
        let middle = run.start + run.len() / 2;
        let is_leaf = run.len() <= LEAF;
        if !is_leaf {
            let axis = (high - low).max_position();
            let place = |triangle: u32| boxes[triangle as usize].iter().map(|corner| corner[axis]).sum::<f64>();
            own.select_nth_unstable_by(run.len() / 2, |a, b| place(*a).total_cmp(&place(*b)));
        }
        let children = (!is_leaf).then(|| [self.build(run.start..middle), self.build(middle..run.end)]);
        self.nodes.push(Node { low, high, run, children });
        self.nodes.len() - 1
    }

    /// Goes through the pairs of a node's triangles.
    fn within(&mut self, node: usize) {
        let Node { run, children, .. } = &self.nodes[node];
        match *children {
            Some([left, right]) => {
                self.within(left);
                self.within(right);
                self.between(left, right);
            }
            None => {
                for at in run.clone() {
                    for other in at + 1..self.nodes[node].run.end {
                        self.compare(self.order[at] as usize, self.order[other] as usize);
                    }
                }
            }
        }
    }

    /// Goes through the pairs of one triangle of each node.
    fn between(&mut self, a: usize, b: usize) {
        let (one, other) = (&self.nodes[a], &self.nodes[b]);
        if !one.overlaps(other) {
            return;
        }
        match (one.children, other.children) {
            (None, None) => {
                for at in one.run.clone() {
                    for other in self.nodes[b].run.clone() {
                        self.compare(self.order[at] as usize, self.order[other] as usize);
                    }
                }
            }
            (Some(children), other_children) if other_children.is_none() || one.run.len() >= other.run.len() => {
                children.into_iter().for_each(|child| self.between(child, b));
            }
            (_, Some(children)) => children.into_iter().for_each(|child| self.between(a, child)),
            (Some(_), None) => {}
        }
    }

    /// Whether two triangles surely have nothing in common but a corner or an edge.
    fn are_apart(&self, a: usize, b: usize) -> bool {
        let (at_a, at_b) = (&self.triangles[a], &self.triangles[b]);
        let in_b = self.corners[a].map(|corner| self.corners[b].iter().position(|other| *other == corner));
        let common = in_b.iter().flatten().count();
        let first = in_b.iter().position(Option::is_some);
        match (common, first.and_then(|k| Some((k, in_b[k]?)))) {
            (0, _) => are_separate(at_a, at_b),
            (1, Some((k, l))) => self.regular[a][k] || meet_at_a_corner(at_a, k, at_b, l),
            // Wound alike, two that are folded onto one another face opposite ways.
            (2, _) => self.normals[a].dot(self.normals[b]) > -1.0 + 1e-9,
            _ => false,
        }
    }

    fn compare(&mut self, a: usize, b: usize) {
        if self.crossed[a] && self.crossed[b] {
            return;
        }
        let ([low_a, high_a], [low_b, high_b]) = (self.boxes[a], self.boxes[b]);
        if low_a.cmpgt(high_b).any() || low_b.cmpgt(high_a).any() {
            return;
        }
        if !self.are_apart(a, b) {
            self.crossed[a] = true;
            self.crossed[b] = true;
        }
    }
}

/// For each corner of each triangle whether all triangles around it lie beside one another when seen along one axis: from
/// in front, and once around.
fn regular_corners(corners: &[[u32; 3]], triangles: &[[DVec3; 3]], normals: &[DVec3]) -> Vec<[bool; 3]> {
    let mut around: Vec<(u32, u32)> = Vec::with_capacity(3 * corners.len());
    for (corners, triangle) in corners.iter().zip(0..) {
        around.extend([0, 1, 2].map(|k| (corners[k as usize], 3 * triangle + k)));
    }
    around.sort_unstable();
    let mut regular = vec![[false; 3]; corners.len()];
    for fan in around.chunk_by(|(a, _), (b, _)| a == b) {
        let places = fan.iter().map(|&(_, place)| (place as usize / 3, place as usize % 3));
        let axis = places.clone().map(|(triangle, _)| normals[triangle]).sum::<DVec3>().normalize_or_zero();
        let direction = axis.cross(DIRECTIONS[0]);
        let mut count = 0;
        let is_regular = places.clone().all(|(triangle, k)| {
            let [p, q, r] = [0, 1, 2].map(|by| triangles[triangle][(k + by) % 3]);
            let is_here = |edge: DVec3, turn: f64| turn * axis.dot(edge.cross(direction)) > 0.0;
            count += u32::from(is_here(q - p, 1.0) && is_here(r - p, -1.0));
            normals[triangle].dot(axis) > 0.1
        });
        if is_regular && count == 1 {
            places.for_each(|(triangle, k)| regular[triangle][k] = true);
        }
    }
    regular
}

/// Whether an axis separates them.
fn are_separate(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    let edges = |[p, q, r]: [DVec3; 3]| [q - p, r - q, p - r];
    // Relative to a corner near by.
    let (a, b) = (a.map(|corner| corner - a[0]), b.map(|corner| corner - a[0]));
    let size = a.iter().chain(&b).map(|corner| corner.abs().max_element()).fold(0.0, f64::max);
    let separates = |axis: DVec3| {
        let reach = |triangle: &[DVec3; 3]| {
            let along = triangle.map(|corner| axis.dot(corner));
            (along[0].min(along[1]).min(along[2]), along[0].max(along[1]).max(along[2]))
        };
        let ((low_a, high_a), (low_b, high_b)) = (reach(&a), reach(&b));
        low_a.max(low_b) - high_a.min(high_b) > ROUNDING * size * axis.abs().max_element()
    };
    let (edges_a, edges_b) = (edges(a), edges(b));
    let (normal_a, normal_b) = (edges_a[0].cross(edges_a[1]), edges_b[0].cross(edges_b[1]));
    let across = |normal: DVec3, edges: [DVec3; 3]| edges.into_iter().any(|edge| separates(normal.cross(edge)));
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, normal_a, normal_b];
    axes.into_iter().any(separates)
        || edges_a.iter().any(|one| edges_b.iter().any(|other| separates(one.cross(*other))))
        || across(normal_a, edges_a)
        || across(normal_b, edges_b)
}

/// Whether two triangles with one corner in common, `k` and `l`, have nothing else.
fn meet_at_a_corner(a: &[DVec3; 3], k: usize, b: &[DVec3; 3], l: usize) -> bool {
    let edge = |triangle: &[DVec3; 3], k: usize, by: usize| (triangle[(k + by) % 3] - triangle[k]).normalize_or_zero();
    let (a, b) = ([edge(a, k, 1), edge(a, k, 2)], [edge(b, l, 1), edge(b, l, 2)]);
    // A plane through two of the edges that has the others on different sides.
    let side = |normal: DVec3, edge: DVec3| {
        let along = normal.dot(edge);
        if along.abs() <= ROUNDING { 0.0 } else { along.signum() }
    };
    let beyond = |normal: DVec3, edges: [DVec3; 2]| side(normal, edges[0]) * side(normal, edges[1]) > 0.0;
    let parts = |i: usize, j: usize| {
        let normal = a[i].cross(b[j]);
        side(normal, a[1 - i]) * side(normal, b[1 - j]) < 0.0
    };
    beyond(a[0].cross(a[1]), b)
        || beyond(b[0].cross(b[1]), a)
        || [(0, 0), (0, 1), (1, 0), (1, 1)].into_iter().any(|(i, j)| parts(i, j))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::procedural::shapes::{cuboid, icosphere, torus};
    use crate::compare::scene::SceneMesh;

    fn hidden(mesh: &SceneMesh) -> Vec<bool> {
        let positions: Vec<Vec3> = mesh.positions.iter().map(|&position| Vec3::from(position)).collect();
        hidden_backs(mesh.indices.as_chunks().0, &positions)
    }

    /// A polygon in a plane, extruded by one, each side cut in so many rows.
    fn prism(polygon: &[[f32; 2]], rows: u32) -> SceneMesh {
        let sides = polygon.len() as u32;
        let ring = |row: u32| polygon.iter().map(move |&[x, y]| [x, y, row as f32 / rows as f32]);
        let mut positions: Vec<[f32; 3]> = (0..=rows).flat_map(ring).collect();
        let mut indices = Vec::new();
        for row in 0..rows {
            for side in 0..sides {
                let next = (side + 1) % sides;
                let [a, b] = [side, next].map(|k| row * sides + k);
                let [c, d] = [next, side].map(|k| (row + 1) * sides + k);
                indices.extend([a, b, c, a, c, d]);
            }
        }
        for (ring, turned) in [(0, true), (rows, false)] {
            let middle = positions.len() as u32;
            positions.push([0.0, 0.1, ring as f32 / rows as f32]);
            for side in 0..sides {
                let [a, b] = [side, (side + 1) % sides].map(|k| ring * sides + k);
                indices.extend(if turned { [middle, b, a] } else { [middle, a, b] });
            }
        }
        SceneMesh { positions, indices, ..SceneMesh::default() }
    }

    #[test]
    fn bodies_that_cross_nothing_hide_all_their_backs() {
        let torus = torus(2.0, 0.5, 24, 12);
        // Not star-shaped: an L, and a torus.
        let l = prism(&[[-1.0, -1.0], [2.0, -1.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0], [-1.0, 2.0]], 3);
        for (name, mesh) in
            [("box", cuboid(Vec3::ZERO, Vec3::ONE)), ("sphere", icosphere(1.0, 2)), ("torus", torus), ("l", l)]
        {
            assert!(hidden(&mesh).iter().all(|hidden| *hidden), "{name}");
        }
    }

    #[test]
    fn an_inverted_lobe_shows_its_backs() {
        // A bow tie that crosses itself at x = 0; its smaller lobe is inside out.
        let mesh = prism(&[[-1.0, 0.5], [2.0, -1.0], [2.0, 1.0], [-1.0, -0.5]], 8);
        let hidden = hidden(&mesh);
        let x = |triangle: usize| mesh.indices[3 * triangle..][..3].iter().map(|&v| mesh.positions[v as usize][0]);
        let of_side = |at: f32| (0..hidden.len()).filter(move |&triangle| x(triangle).all(|x| x == at));
        assert_eq!((of_side(-1.0).count(), of_side(2.0).count()), (16, 16));
        assert!(of_side(-1.0).all(|triangle| !hidden[triangle]), "{hidden:?}");
        assert!(of_side(2.0).all(|triangle| hidden[triangle]), "{hidden:?}");
    }
}
