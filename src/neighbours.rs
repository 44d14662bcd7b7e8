//! Which triangle lies beyond each edge of a mesh's triangles: what lookups walk over.
//!
//! Triangles are neighbours by the exact positions of an edge's ends, whatever else their vertices have. An edge that one
//! triangle has is the surface's end. Where more than two meet, those that go on into one another with the least turning
//! are neighbours, and a walk that comes to another one is lost. Walks go through triangles of no area, which aren't drawn.

use glam::{DVec3, Vec3};

/// What lies beyond an edge, as the shaders read it: bits 0-1 the edge's number in the neighbour, bit 2 whether the
/// neighbour is wound the other way, bits 3-10 its place in its chunk, bits 11-31 its chunk less the triangle's own, signed.
/// Twin of `beyond` in `shaders/exact.wgsl`.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Beyond(pub(crate) u32);

impl Beyond {
    /// The surface ends.
    pub(crate) const NOTHING: Self = Self(3);
    /// Something, but not known what.
    pub(crate) const UNKNOWN: Self = Self(7);

    /// `from` and `to` are chunk numbers; the neighbour is at `place` in the latter.
    fn new(from: u32, to: u32, place: u32, half_edge: HalfEdge) -> Self {
        let offset = i64::from(to) - i64::from(from);
        if !(-(1 << 20)..1 << 20).contains(&offset) {
            return Self::UNKNOWN;
        }
        Self((offset as u32) << 11 | place << 3 | half_edge.0 & 7)
    }
}

/// An edge of a triangle: bits 0-1 its number there, bit 2 whether the triangle is wound the other way than the one whose
/// neighbour it is, bits 3-31 the triangle. No device can bind as many triangles as don't fit. Edge k goes from corner k to
/// the next one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct HalfEdge(u32);

impl HalfEdge {
    const NOTHING: Self = Self(Beyond::NOTHING.0);
    const UNKNOWN: Self = Self(Beyond::UNKNOWN.0);

    fn new(triangle: usize, edge: usize) -> Self {
        Self((triangle as u32) << 3 | edge as u32)
    }

    pub(crate) fn triangle(self) -> usize {
        self.0 as usize >> 3
    }

    fn edge(self) -> usize {
        self.0 as usize & 3
    }

    fn exists(self) -> bool {
        self.edge() < 3
    }

    /// Seen from a neighbour that is wound the other way, if `turned`.
    fn turned(self, turned: bool) -> Self {
        Self(if self.exists() { self.0 ^ u32::from(turned) << 2 } else { self.0 })
    }

    fn is_turned(self) -> bool {
        self.exists() && self.0 & 4 != 0
    }
}

/// The half-edges of triangles, by the edge that they are of.
pub(crate) struct Edges<'a> {
    corners: &'a [[u32; 3]],
    /// Where the run of each corner begins: the edges of which it is the lower end.
    starts: Vec<u32>,
    /// By the edge's higher end, in the upper half, then by [`HalfEdge`].
    half_edges: Vec<u64>,
}

impl<'a> Edges<'a> {
    /// Of triangles by their corners' numbers, all below `ends`. Those that have a corner twice are left out.
    pub(crate) fn new(corners: &'a [[u32; 3]], ends: usize) -> Self {
        let mut starts = vec![0; ends + 1];
        for [a, b, c] in corners.iter().filter(|corners| is_whole(corners)) {
            for low in [a.min(b), b.min(c), c.min(a)] {
                starts[*low as usize] += 1;
            }
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let mut half_edges = vec![0; sum as usize];
        for (triangle, whole) in corners.iter().enumerate().filter(|(_, corners)| is_whole(corners)) {
            let [a, b, c] = *whole;
            for (edge, (from, to)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
                let start = &mut starts[from.min(to) as usize];
                *start -= 1;
                half_edges[*start as usize] =
                    u64::from(from.max(to)) << 32 | u64::from(HalfEdge::new(triangle, edge).0);
            }
        }
        for run in starts.windows(2) {
            half_edges[run[0] as usize..run[1] as usize].sort_unstable();
        }
        Self { corners, starts, half_edges }
    }

    /// Calls `visit` with the half-edges of each edge, in the order of their triangles.
    pub(crate) fn for_each(&self, mut visit: impl FnMut(&[HalfEdge])) {
        let mut group = Vec::new();
        for run in self.starts.windows(2) {
            let run = &self.half_edges[run[0] as usize..run[1] as usize];
            for same in run.chunk_by(|a, b| a >> 32 == b >> 32) {
                group.clear();
                group.extend(same.iter().map(|&half_edge| HalfEdge(half_edge as u32)));
                visit(&group);
            }
        }
    }

    /// Whether two half-edges of one edge run in opposite directions: their triangles are wound alike.
    pub(crate) fn are_opposite(&self, a: HalfEdge, b: HalfEdge) -> bool {
        let start = |half_edge: HalfEdge| self.corners[half_edge.triangle()][half_edge.edge()];
        start(a) != start(b)
    }
}

fn is_whole([a, b, c]: &[u32; 3]) -> bool {
    a != b && b != c && c != a
}

/// The triangles of a mesh, drawn or not.
pub(crate) struct Triangles<'a> {
    pub(crate) positions: &'a [Vec3],
    /// Places in `positions`.
    pub(crate) corners: &'a [[u32; 3]],
    /// Those that are drawn; the others have no area.
    pub(crate) drawn: &'a [bool],
}

/// More triangles at an edge than this are no surface.
const MOST_AT_AN_EDGE: usize = 64;

/// Triangles of no area that a walk goes through in a row.
const MOST_IN_A_ROW: usize = 64;

/// What lies beyond each edge of each triangle of a mesh.
pub(crate) struct Neighbours(Vec<[HalfEdge; 3]>);

impl Neighbours {
    /// `edges` are those of the same triangles, with corners numbered by position.
    pub(crate) fn new(triangles: &Triangles, edges: &Edges) -> Self {
        let mut neighbours = Self(vec![[HalfEdge::NOTHING; 3]; triangles.corners.len()]);
        edges.for_each(|group| match *group {
            [_] => {}
            [a, b] => neighbours.join(a, b, !edges.are_opposite(a, b)),
            _ => {
                for &half_edge in group {
                    neighbours.set(half_edge, HalfEdge::UNKNOWN);
                }
                for (a, b) in triangles.pairs(group, edges) {
                    neighbours.join(a, b, false);
                }
            }
        });
        for (triangle, corners) in edges.corners.iter().enumerate() {
            if triangles.drawn[triangle] && !is_whole(corners) {
                // Ones that deform may open.
                neighbours.0[triangle] = [HalfEdge::UNKNOWN; 3];
            }
        }
        if triangles.drawn.contains(&false) {
            neighbours.pass_through(triangles);
        }
        neighbours
    }

    fn set(&mut self, at: HalfEdge, beyond: HalfEdge) {
        self.0[at.triangle()][at.edge()] = beyond;
    }

    fn get(&self, at: HalfEdge) -> HalfEdge {
        self.0[at.triangle()][at.edge()]
    }

    fn join(&mut self, a: HalfEdge, b: HalfEdge, turned: bool) {
        self.set(a, b.turned(turned));
        self.set(b, a.turned(turned));
    }

    /// Joins what triangles that aren't drawn lie between.
    fn pass_through(&mut self, triangles: &Triangles) {
        for triangle in (0..self.0.len()).filter(|triangle| triangles.drawn[*triangle]) {
            for edge in 0..3 {
                let mut beyond = self.0[triangle][edge];
                for _ in 0..MOST_IN_A_ROW {
                    if !beyond.exists() || triangles.drawn[beyond.triangle()] {
                        break;
                    }
                    beyond = self.exit(triangles, beyond);
                }
                let is_drawn = !beyond.exists() || triangles.drawn[beyond.triangle()];
                self.0[triangle][edge] = if is_drawn { beyond } else { HalfEdge::UNKNOWN };
            }
        }
    }

    /// What lies beyond a triangle of no area that is entered by an edge: its longest edge lies along the other two.
    fn exit(&self, triangles: &Triangles, entered: HalfEdge) -> HalfEdge {
        let lengths = [0, 1, 2].map(|edge| triangles.edge_length(entered.triangle(), edge));
        let mut edges = [0, 1, 2];
        edges.sort_by(|&a, &b| lengths[b].total_cmp(&lengths[a]));
        let beyond = |edge| self.get(HalfEdge::new(entered.triangle(), edge)).turned(entered.is_turned());
        if entered.edge() != edges[0] {
            return beyond(edges[0]);
        }
        let (long, short) = (beyond(edges[1]), beyond(edges[2]));
        if long.exists() { long } else { short }
    }

    /// What lies beyond the edges of a drawn triangle, which is at `own.1` in chunk `own.0`; `place` says where the others
    /// are. `turned`: the order of its corners, and of those that it is connected to, has been reversed since.
    pub(crate) fn beyond(
        &self,
        triangle: u32,
        turned: bool,
        own: u32,
        place: impl Fn(usize) -> (u32, u32),
    ) -> [Beyond; 3] {
        // Corners a, c, b in place of a, b, c.
        let edge = |edge: usize| if turned { 2 - edge } else { edge };
        [0, 1, 2].map(|at| {
            let half_edge = self.0[triangle as usize][edge(at)];
            if !half_edge.exists() {
                return Beyond(half_edge.0);
            }
            let (chunk, place) = place(half_edge.triangle());
            let there = HalfEdge::new(0, edge(half_edge.edge())).turned(half_edge.is_turned());
            Beyond::new(own, chunk, place, there)
        })
    }
}

impl Triangles<'_> {
    fn corner(&self, triangle: usize, corner: usize) -> DVec3 {
        self.positions[self.corners[triangle][corner % 3] as usize].as_dvec3()
    }

    /// Squared.
    fn edge_length(&self, triangle: usize, edge: usize) -> f64 {
        self.corner(triangle, edge).distance_squared(self.corner(triangle, edge + 1))
    }

    /// Which of more than two triangles at an edge go on into one another: opposite half-edges, by least turning.
    fn pairs(&self, group: &[HalfEdge], edges: &Edges) -> Vec<(HalfEdge, HalfEdge)> {
        if group.len() > MOST_AT_AN_EDGE {
            return Vec::new();
        }
        let away: Vec<DVec3> = group.iter().map(|&half_edge| self.away(half_edge)).collect();
        let mut candidates = Vec::new();
        for (j, i) in (0..group.len()).flat_map(|j| (0..j).map(move |i| (j, i))) {
            if edges.are_opposite(group[i], group[j]) && group[i].triangle() != group[j].triangle() {
                // From 0, straight on, to 2, folded back. Those of no area have no direction.
                let flat = away[i] == DVec3::ZERO || away[j] == DVec3::ZERO;
                candidates.push((if flat { 3.0 } else { 1.0 + away[i].dot(away[j]) }, i, j));
            }
        }
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let (mut pairs, mut taken) = (Vec::new(), [false; MOST_AT_AN_EDGE]);
        for (_, i, j) in candidates {
            if !taken[i] && !taken[j] {
                (taken[i], taken[j]) = (true, true);
                pairs.push((group[i], group[j]));
            }
        }
        pairs
    }

    /// Unit vector in a triangle's plane, square to one of its edges and away from it.
    fn away(&self, half_edge: HalfEdge) -> DVec3 {
        let corner = |k| self.corner(half_edge.triangle(), half_edge.edge() + k);
        let (along, side) = (corner(1) - corner(0), corner(2) - corner(0));
        side.reject_from(along).normalize_or_zero()
    }
}

#[cfg(all(test, feature = "compare"))]
mod tests {
    use super::*;
    use crate::chunks::{ChunkedMesh, cut};
    use crate::compare::procedural::shapes::{cuboid, tetrahedron, torus};
    use crate::compare::scene::SceneMesh;
    use crate::{CasterMesh, Indices};
    use proptest::prelude::*;
    use std::collections::HashMap;

    #[test]
    fn a_neighbour_s_chunk_is_within_21_bits() {
        let half_edge = HalfEdge::new(0, 2).turned(true);
        let decode = |beyond: Beyond| ((beyond.0 as i32) >> 11, beyond.0 >> 3 & 0xff, beyond.0 & 7);
        let most = (1 << 21) - 2;
        for offset in [-(1 << 20), 1 - (1 << 20), -1, 0, 1, (1 << 20) - 1] {
            let from = if offset < 0 { most } else { 0 };
            let to = (i64::from(from) + offset) as u32;
            assert_eq!(decode(Beyond::new(from, to, 255, half_edge)), (offset as i32, 255, 6), "{offset}");
        }
        for (from, to) in [(0, 1 << 20), ((1 << 20) + 1, 0), (0, most)] {
            assert_eq!(Beyond::new(from, to, 0, half_edge), Beyond::UNKNOWN, "{from} to {to}");
        }
    }

    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    enum Across {
        Nothing,
        Unknown,
        /// A triangle, by its number in the mesh, and whether it is wound the other way.
        Triangle(u32, bool),
    }
    use Across::{Nothing, Unknown};

    type Point = [i32; 3];

    /// By a triangle's number and an edge's two ends in its order.
    type Found = HashMap<(u32, Point, Point), Across>;

    fn mesh(positions: &[Point], triangles: &[[u32; 3]]) -> SceneMesh {
        SceneMesh {
            positions: positions.iter().map(|p| p.map(|x| x as f32)).collect(),
            indices: triangles.concat(),
            ..SceneMesh::default()
        }
    }

    fn find(mesh: &SceneMesh, deforms: bool) -> Found {
        let indices = Indices::U32(&mesh.indices);
        let cut = cut(&CasterMesh { positions: &mesh.positions, indices, deforms, ..Default::default() });
        let corners = |triangle: usize| [0, 1, 2].map(|k| corner(&cut, triangle, k));
        let mut found = Found::new();
        for (chunk, own) in cut.chunks.iter().zip(0..) {
            for triangle in chunk.first_triangle as usize..(chunk.first_triangle + chunk.triangle_count) as usize {
                for edge in 0..3 {
                    let (from, to) = (corners(triangle)[edge], corners(triangle)[(edge + 1) % 3]);
                    let across = match cut.records[triangle].beyond[edge] {
                        Beyond::NOTHING => Nothing,
                        Beyond::UNKNOWN => Unknown,
                        Beyond(bits) => {
                            let chunk = &cut.chunks[(own + (bits as i32 >> 11)) as usize];
                            let place = bits >> 3 & 0xff;
                            assert!(place < chunk.triangle_count);
                            let other = (chunk.first_triangle + place) as usize;
                            let turned = bits & 4 != 0;
                            let edge = (bits & 3) as usize;
                            let there = (corners(other)[edge], corners(other)[(edge + 1) % 3]);
                            let expected = if turned { (from, to) } else { (to, from) };
                            // Through one of no area an edge lies along part of another.
                            assert!(there == expected || are_in_line([from, to, there.0, there.1]), "{there:?}");
                            Across::Triangle(cut.numbers[other], turned)
                        }
                    };
                    found.insert((cut.numbers[triangle], from, to), across);
                }
            }
        }
        found
    }

    fn are_in_line(points: [Point; 4]) -> bool {
        let [a, b, c, d] = points.map(|p| DVec3::from(p.map(f64::from)));
        (b - a).cross(c - a) == DVec3::ZERO && (b - a).cross(d - a) == DVec3::ZERO
    }

    fn corner(cut: &ChunkedMesh, triangle: usize, k: usize) -> Point {
        let chunk = cut.chunks.iter().rfind(|chunk| chunk.first_triangle as usize <= triangle).unwrap();
        let vertex = chunk.first_vertex + (cut.triangles[triangle] >> (8 * k) & 0xff);
        cut.vertices[vertex as usize].position.to_array().map(|x| (1024.0 * x) as i32)
    }

    /// What lies beyond an edge, whichever way round the triangle was turned.
    fn across(found: &Found, triangle: u32, a: Point, b: Point) -> Across {
        let [a, b] = [a, b].map(|p| p.map(|x| 1024 * x));
        *found.get(&(triangle, a, b)).or_else(|| found.get(&(triangle, b, a))).expect("an edge of the triangle")
    }

    const SQUARE: [Point; 4] = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]];

    #[test]
    fn triangles_of_a_square_meet_at_the_diagonal() {
        for deforms in [false, true] {
            let found = find(&mesh(&SQUARE, &[[0, 1, 2], [0, 2, 3]]), deforms);
            let [a, b, c, d] = SQUARE;
            assert_eq!(across(&found, 0, a, c), Across::Triangle(1, false));
            assert_eq!(across(&found, 1, a, c), Across::Triangle(0, false));
            for (triangle, from, to) in [(0, a, b), (0, b, c), (1, c, d), (1, d, a)] {
                assert_eq!(across(&found, triangle, from, to), Nothing);
            }
        }
    }

    /// One position, as many vertices as there are triangles around it.
    #[test]
    fn vertices_of_one_position_are_one_whatever_they_are_welded_by() {
        let [a, b, c, d] = SQUARE;
        let apart = mesh(&[a, b, c, a, c, d], &[[0, 1, 2], [3, 4, 5]]);
        for deforms in [false, true] {
            let found = find(&apart, deforms);
            assert_eq!(across(&found, 0, a, c), Across::Triangle(1, false), "deforms: {deforms}");
        }
    }

    #[test]
    fn a_neighbour_wound_the_other_way_says_so() {
        let found = find(&mesh(&SQUARE, &[[0, 1, 2], [0, 3, 2]]), false);
        let [a, _, c, _] = SQUARE;
        assert_eq!(across(&found, 0, a, c), Across::Triangle(1, true));
        assert_eq!(across(&found, 1, a, c), Across::Triangle(0, true));
    }

    /// A wall on the diagonal of a floor: the floor goes on under it.
    #[test]
    fn of_three_triangles_two_go_on_straight_and_the_third_is_lost() {
        let positions = [SQUARE.as_slice(), &[[1, 1, 2]]].concat();
        for wall in [[0, 2, 4], [2, 0, 4]] {
            let found = find(&mesh(&positions, &[wall, [0, 1, 2], [0, 2, 3]]), false);
            let [a, _, c, _] = SQUARE;
            assert_eq!(across(&found, 1, a, c), Across::Triangle(2, false));
            assert_eq!(across(&found, 2, a, c), Across::Triangle(1, false));
            assert_eq!(across(&found, 0, a, c), Unknown);
        }
    }

    /// A front and a back of the same square: each goes on into its own half.
    #[test]
    fn of_two_sheets_on_one_another_each_goes_on() {
        let found = find(&mesh(&SQUARE, &[[0, 1, 2], [2, 1, 0], [0, 2, 3], [3, 2, 0]]), false);
        let [a, b, c, _] = SQUARE;
        assert_eq!(across(&found, 0, a, c), Across::Triangle(2, false));
        assert_eq!(across(&found, 1, a, c), Across::Triangle(3, false));
        assert_eq!(across(&found, 0, a, b), Across::Triangle(1, false), "round the rim");
    }

    #[test]
    fn too_many_triangles_at_an_edge_are_lost() {
        let rim = (0..200).map(|k| [0, k, 1]);
        let positions: Vec<Point> = [[0, 0, 0], [2, 0, 0]].into_iter().chain(rim).collect();
        let triangles: Vec<[u32; 3]> = (2..202).map(|k| if k % 2 == 0 { [0, 1, k] } else { [1, 0, k] }).collect();
        let found = find(&mesh(&positions, &triangles), false);
        assert!((0..200).all(|k| across(&found, k, positions[0], positions[1]) == Unknown));
    }

    /// Two triangles against the long side of a third, with one of no area in between.
    #[test]
    fn triangles_of_no_area_are_passed_through() {
        let positions = [[0, 0, 0], [3, 0, 0], [4, 0, 0], [2, 2, 0], [2, -2, 0]];
        let found = find(&mesh(&positions, &[[0, 2, 3], [0, 1, 2], [1, 0, 4], [2, 1, 4]]), false);
        let [a, b, c, ..] = positions;
        assert_eq!(across(&found, 2, a, b), Across::Triangle(0, false));
        assert_eq!(across(&found, 3, b, c), Across::Triangle(0, false));
        // The longer of the two.
        assert_eq!(across(&found, 0, a, c), Across::Triangle(2, false));
    }

    #[test]
    fn triangles_of_no_area_one_beside_the_other_are_passed_through() {
        let positions = [[0, 0, 0], [3, 0, 0], [5, 0, 0], [6, 0, 0], [2, 2, 0], [2, -2, 0], [5, -2, 0]];
        let triangles = [[0, 3, 4], [0, 1, 3], [1, 2, 3], [1, 0, 5], [2, 1, 5], [3, 2, 6]];
        let found = find(&mesh(&positions, &triangles), false);
        assert_eq!(across(&found, 3, positions[0], positions[1]), Across::Triangle(0, false));
        assert_eq!(across(&found, 4, positions[1], positions[2]), Across::Triangle(0, false));
        assert_eq!(across(&found, 5, positions[2], positions[3]), Across::Triangle(0, false));
    }

    /// Pieces that are inside out are turned when they are cut, and their edges with them.
    #[test]
    fn closed_meshes_have_a_neighbour_beyond_every_edge() {
        for shape in [tetrahedron(1.0), cuboid(Vec3::ZERO, Vec3::ONE), torus(3.0, 1.0, 64, 48)] {
            let mut inside_out = shape.clone();
            inside_out.indices.as_chunks_mut::<3>().0.iter_mut().for_each(|corners| corners.swap(0, 1));
            for mesh in [shape, inside_out] {
                let found = find(&mesh, false);
                assert_eq!(found.len(), mesh.indices.len());
                assert!(found.values().all(|across| matches!(across, Across::Triangle(_, false))));
            }
        }
    }

    proptest! {
        /// Triangles between few points, against a search through all.
        #[test]
        fn neighbours_share_the_edge(
            triangles in prop::collection::vec(prop::array::uniform3(0u32..12), 1..40), deforms: bool,
        ) {
            let points: Vec<Point> = (0..12).map(|k| [k % 3, k / 3 % 2, k * k % 7]).collect();
            let mesh = mesh(&points, &triangles);
            let found = find(&mesh, deforms);
            let corners = |triangle: u32| triangles[triangle as usize].map(|k| points[k as usize].map(|x| 1024 * x));
            let whole = |triangle: u32| {
                let [a, b, c] = corners(triangle);
                a != b && b != c && c != a
            };
            let drawn = |triangle: u32| found.keys().any(|key| key.0 == triangle);
            for (&(triangle, from, to), &across) in &found {
                if !whole(triangle) {
                    prop_assert!(deforms && across == Unknown);
                    continue;
                }
                let sharing = |other: &u32| {
                    let has = |point| corners(*other).contains(&point);
                    *other != triangle && whole(*other) && has(from) && has(to)
                };
                let others: Vec<u32> = (0..triangles.len() as u32).filter(sharing).collect();
                if others.iter().any(|other| !drawn(*other)) {
                    continue;
                }
                match (others.as_slice(), across) {
                    ([], _) => prop_assert_eq!(across, Nothing),
                    ([other], _) => {
                        prop_assert!(matches!(across, Across::Triangle(found, _) if found == *other), "{:?}", across);
                    }
                    (_, Across::Triangle(other, turned)) => {
                        prop_assert!(others.contains(&other) && !turned);
                        let back = found.get(&(other, to, from)).copied();
                        prop_assert_eq!(back, Some(Across::Triangle(triangle, false)));
                    }
                    (_, across) => prop_assert_eq!(across, Unknown),
                }
            }
        }
    }
}
