//! From a mesh to chunks: at most 256 triangles over at most 256 vertices of their own, neighbours in space,
//! with the closed pieces of the mesh found and turned outward.

use crate::casters::{CasterMesh, Indices, Sides};
use crate::cone::Cone;
use crate::neighbours::{Beyond, Edges, Neighbours, Triangles};
use crate::outward;
use glam::{DVec3, Vec3};
use std::borrow::Cow;

/// Most triangles and most vertices in a chunk: a corner of a triangle is then one byte.
pub(crate) const CHUNK_SIZE: usize = 256;

/// Axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) min: Vec3,
    pub(crate) max: Vec3,
}

impl Bounds {
    pub(crate) const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    pub(crate) fn extend(&mut self, point: Vec3) {
        self.min = self.min.min(point);
        self.max = self.max.max(point);
    }

    pub(crate) fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether any point of the box is within `radius` of `centre`; none of an empty one is.
    pub(crate) fn touches_sphere(&self, centre: Vec3, radius: f32) -> bool {
        // glam's `clamp` may assert that there is a box.
        centre.max(self.min).min(self.max).distance_squared(centre) <= radius * radius
    }
}

/// What the cull stage may do with the triangles of a chunk that face away from the light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Culling {
    /// They cast.
    None,
    /// They may be dropped when the light is outside the pieces' bounds: a front face is nearer.
    Closed,
    /// They never cast.
    Always,
}

/// A chunk of a mesh, in the mesh's space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Chunk {
    pub(crate) first_vertex: u32,
    pub(crate) vertex_count: u32,
    pub(crate) first_triangle: u32,
    pub(crate) triangle_count: u32,
    pub(crate) culling: Culling,
    /// Bounds of all pieces that the chunk has triangles of.
    pub(crate) pieces: Bounds,
    /// The normals of the chunk's triangles and, if their back faces may only be dropped where no front face is near,
    /// of those that share a vertex with them.
    pub(crate) normals: Cone,
}

/// A vertex as the shaders read it; twin of `CasterVertex` in `shaders/casters.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Vertex {
    pub(crate) position: Vec3,
    /// [`Cone`] of the normals of all triangles around it, if back faces may be dropped where there is no front face.
    /// Of deforming meshes its number among the mesh's positions; of masked ones what [`Masks`](crate::mask::Masks)
    /// puts there instead.
    pub(crate) data: u32,
}

/// A triangle as lookups read it, a mesh record: its corners, and what lies beyond its edges, from its first corner to its
/// second one on.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct TriangleRecord {
    pub(crate) corners: u32,
    pub(crate) beyond: [Beyond; 3],
}

/// A mesh cut into chunks.
#[derive(Debug)]
pub(crate) struct ChunkedMesh {
    /// The chunks' vertices, one run a chunk.
    pub(crate) vertices: Vec<Vertex>,
    /// Of masked meshes the vertices' texture coordinates, else none.
    pub(crate) texture_coordinates: Vec<[f32; 2]>,
    /// A triangle's corners as places in its chunk's run of vertices: bits 0-7, 8-15, 16-23.
    pub(crate) triangles: Vec<u32>,
    /// The triangles with their neighbours.
    pub(crate) records: Vec<TriangleRecord>,
    /// The triangles' numbers in the mesh.
    pub(crate) numbers: Vec<u32>,
    pub(crate) chunks: Vec<Chunk>,
    pub(crate) bounds: Bounds,
}

/// A triangle by its welded vertices, with what is known of the piece it belongs to.
#[derive(Clone, Copy)]
struct Triangle {
    corners: [u32; 3],
    centre: Vec3,
    closed: bool,
    /// Whether a front face of the piece is surely nearer to a light outside than a back face.
    culls: bool,
    /// Number of one of the piece's triangles.
    piece: u32,
    /// Its number in the mesh.
    number: u32,
    /// Whether the order of its corners has been reversed.
    turned: bool,
}

/// Cuts a mesh whose values have been checked. Triangles of no area are left out: they cast nothing.
pub(crate) fn cut(mesh: &CasterMesh) -> ChunkedMesh {
    let Welded { positions, corners, drawn, places, sources } = weld(mesh);
    let mut triangles = triangles(&positions, &corners, &drawn);
    let by_place = corners_by_place(&corners, &places);
    let edges = Edges::new(&by_place, positions.len());
    // Holes show back faces, and what is turned away now may not be later.
    let plain = mesh.mask.is_none() && !mesh.deforms;
    let closes = mesh.sides == Sides::Auto && plain;
    let pieces = if closes { find_closed_pieces(&positions, &mut triangles, &edges, &drawn) } else { Vec::new() };
    find_culled_pieces(&positions, &mut triangles);

    let neighbours = Neighbours::new(&Triangles { positions: &positions, corners: &corners, drawn: &drawn }, &edges);
    drop(edges);
    let mut cutter = Cutter {
        positions: &positions,
        pieces: &pieces,
        always: mesh.sides == Sides::Front,
        local: vec![u32::MAX; positions.len()],
        welded: Vec::new(),
        turned: Vec::new(),
        out: ChunkedMesh {
            vertices: Vec::new(),
            texture_coordinates: Vec::new(),
            triangles: Vec::new(),
            records: Vec::new(),
            numbers: Vec::new(),
            chunks: Vec::new(),
            bounds: Bounds::EMPTY,
        },
    };
    let split = culled_first(&mut triangles);
    let (closed, open) = triangles.split_at_mut(split);
    cutter.cut(closed);
    cutter.cut(open);
    cutter.place_neighbours(&neighbours, corners.len());
    if plain {
        cutter.bound_normals();
    }
    let sources = cutter.welded.iter().map(|&vertex| sources[vertex as usize]);
    if let Some(mask) = &mesh.mask {
        let coordinates = sources.clone().map(|source| mask.texture_coordinates[source as usize]);
        cutter.out.texture_coordinates = coordinates.collect();
    }
    if mesh.deforms {
        cutter.out.vertices.iter_mut().zip(sources).for_each(|(vertex, source)| vertex.data = source);
    }
    for vertex in &cutter.out.vertices {
        cutter.out.bounds.extend(vertex.position);
    }
    cutter.out
}

/// The closed piece that a triangle belongs to, and which way the piece is wound.
#[cfg(feature = "compare")]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ClosedPiece {
    /// Number of one of the piece's triangles, the same for all of them.
    pub(crate) triangle: u32,
    /// Whether fronts (corners anticlockwise) are on the inside.
    pub(crate) inside_out: bool,
}

/// For each triangle of an opaque mesh whose values have been checked, the closed piece that it belongs to. `None` for
/// those of open pieces and for those of no area.
#[cfg(feature = "compare")]
pub(crate) fn closed_pieces(positions: &[[f32; 3]], indices: Indices) -> Vec<Option<ClosedPiece>> {
    let Welded { positions, corners, drawn, .. } = weld(&CasterMesh { positions, indices, ..Default::default() });
    let mut triangles = triangles(&positions, &corners, &drawn);
    find_closed_pieces(&positions, &mut triangles, &Edges::new(&corners, positions.len()), &drawn);
    let mut pieces = vec![None; corners.len()];
    for &Triangle { number, piece, turned, .. } in triangles.iter().filter(|triangle| triangle.closed) {
        // Closed pieces have been turned outward.
        pieces[number as usize] = Some(ClosedPiece { triangle: piece, inside_out: turned });
    }
    pieces
}

/// Marks the triangles of closed pieces, which have been turned outward, whose backs needn't be drawn, and puts each piece's
/// triangles together.
fn find_culled_pieces(positions: &[Vec3], triangles: &mut [Triangle]) {
    triangles.sort_by_key(|triangle| (!triangle.closed, triangle.piece));
    let split = triangles.partition_point(|triangle| triangle.closed);
    for piece in triangles[..split].chunk_by_mut(|a, b| a.piece == b.piece) {
        let corners: Vec<[u32; 3]> = piece.iter().map(|triangle| triangle.corners).collect();
        let hidden = outward::hidden_backs(&corners, positions);
        piece.iter_mut().zip(hidden).for_each(|(triangle, hidden)| triangle.culls = hidden);
    }
}

/// Puts the triangles first whose backs may be left out, and returns their number.
fn culled_first(triangles: &mut [Triangle]) -> usize {
    triangles.sort_by_key(|t| (!t.culls, t.number));
    triangles.partition_point(|t| t.culls)
}

/// A mesh's vertices without repetition.
struct Welded {
    positions: Vec<Vec3>,
    /// The triangles, by their numbers in the mesh.
    corners: Vec<[u32; 3]>,
    /// Those of some area; if the mesh deforms, all of three vertices.
    drawn: Vec<bool>,
    /// For each vertex the first one of the same position.
    places: Vec<u32>,
    /// One of the mesh's positions that each is.
    sources: Vec<u32>,
}

/// Those of the triangles that are drawn, of no known piece yet.
fn triangles(positions: &[Vec3], corners: &[[u32; 3]], drawn: &[bool]) -> Vec<Triangle> {
    let triangle = |(&corners, number): (&[u32; 3], u32)| {
        let [a, b, c] = corners.map(|vertex| positions[vertex as usize]);
        Triangle { corners, centre: (a + b + c) / 3.0, closed: false, culls: false, piece: 0, number, turned: false }
    };
    corners.iter().zip(0..).filter(|(_, number)| drawn[*number as usize]).map(triangle).collect()
}

/// The triangles with vertices of the same position taken for one.
fn corners_by_place<'a>(corners: &'a [[u32; 3]], places: &[u32]) -> Cow<'a, [[u32; 3]]> {
    if places.iter().zip(0..).all(|(place, vertex)| *place == vertex) {
        return corners.into();
    }
    corners.iter().map(|corners| corners.map(|vertex| places[vertex as usize])).collect()
}

/// Joins vertices of the same position and, if the mesh is masked, of the same texture coordinates. Those of a mesh
/// that deforms may part, so they stay as they are.
fn weld(mesh: &CasterMesh) -> Welded {
    // Adding 0 makes -0 and 0 the same bits.
    let key = |v: u32| {
        let position = (Vec3::from(mesh.positions[v as usize]) + 0.0).to_array().map(f32::to_bits);
        let coordinates = mesh.mask.map(|mask| mask.texture_coordinates[v as usize].map(f32::to_bits));
        (position, coordinates, mesh.deforms.then_some(v))
    };
    let mut order: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    order.sort_unstable_by_key(|&v| (key(v), v));
    let mut welded = vec![0u32; order.len()];
    let (mut positions, mut places, mut sources) = (Vec::new(), Vec::new(), Vec::new());
    let mut last = None;
    for &v in &order {
        let bits = key(v);
        if last != Some(bits) {
            let is_same_place = last.is_some_and(|(position, ..)| position == bits.0);
            places.push(if is_same_place { places[places.len() - 1] } else { places.len() as u32 });
            positions.push(Vec3::from_array(bits.0.map(f32::from_bits)));
            sources.push(v);
            last = Some(bits);
        }
        welded[v as usize] = positions.len() as u32 - 1;
    }
    let casts = |c: &[u32; 3]| {
        if mesh.deforms {
            return c[0] != c[1] && c[1] != c[2] && c[2] != c[0];
        }
        let [a, b, c] = c.map(|v| positions[v as usize].as_dvec3());
        (b - a).cross(c - a) != DVec3::ZERO
    };
    let triangle = |corners: [u32; 3]| corners.map(|v| welded[v as usize]);
    let corners: Vec<[u32; 3]> = match mesh.indices {
        Indices::U16(list) => list.as_chunks().0.iter().map(|i: &[u16; 3]| triangle(i.map(u32::from))).collect(),
        Indices::U32(list) => list.as_chunks().0.iter().map(|&i: &[u32; 3]| triangle(i)).collect(),
    };
    let drawn = corners.iter().map(casts).collect();
    Welded { positions, corners, drawn, places, sources }
}

/// Finds the pieces that triangles connected by edges make, marks those of closed ones (every edge shared by
/// two opposite half-edges) and turns them outward. Returns the bounds of every piece.
fn find_closed_pieces(positions: &[Vec3], triangles: &mut [Triangle], edges: &Edges, drawn: &[bool]) -> Vec<Bounds> {
    let mut union = UnionFind::new(drawn.len());
    let mut open = Vec::new();
    edges.for_each(|group| {
        let mut sharing = group.iter().filter(|half_edge| drawn[half_edge.triangle()]);
        let Some(first) = sharing.next() else { return };
        let (mut count, mut opposite) = (1, false);
        for other in sharing {
            union.join(first.triangle() as u32, other.triangle() as u32);
            count += 1;
            opposite = edges.are_opposite(*first, *other);
        }
        if !(count == 2 && opposite) {
            open.push(first.triangle() as u32);
        }
    });
    let mut closed = vec![true; drawn.len()];
    for triangle in open {
        closed[union.find(triangle) as usize] = false;
    }
    let mut volumes = vec![0.0f64; drawn.len()];
    let mut bounds = vec![Bounds::EMPTY; drawn.len()];
    // Relative to a corner of the piece, so that a piece far from the origin keeps its sign.
    let mut origins = vec![None; drawn.len()];
    for triangle in &mut *triangles {
        let piece = union.find(triangle.number);
        triangle.piece = piece;
        let corners = triangle.corners.map(|v| positions[v as usize]);
        for corner in corners {
            bounds[piece as usize].extend(corner);
        }
        let origin = *origins[piece as usize].get_or_insert(corners[0].as_dvec3());
        let [a, b, c] = corners.map(|p| p.as_dvec3() - origin);
        volumes[piece as usize] += a.dot(b.cross(c));
    }
    for triangle in triangles {
        let volume = volumes[triangle.piece as usize];
        triangle.closed = closed[triangle.piece as usize] && volume != 0.0;
        if triangle.closed && volume < 0.0 {
            triangle.corners.swap(1, 2);
            triangle.turned = true;
        }
    }
    bounds
}

struct UnionFind(Vec<u32>);

impl UnionFind {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn find(&mut self, mut x: u32) -> u32 {
        while self.0[x as usize] != x {
            let parent = self.0[x as usize];
            self.0[x as usize] = self.0[parent as usize];
            x = parent;
        }
        x
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

struct Cutter<'a> {
    positions: &'a [Vec3],
    pieces: &'a [Bounds],
    always: bool,
    /// Welded vertex to its place in the chunk being made, or `u32::MAX`.
    local: Vec<u32>,
    /// The welded vertices of `out.vertices`.
    welded: Vec<u32>,
    /// Whether the corners of `out.triangles` have been reversed.
    turned: Vec<bool>,
    out: ChunkedMesh,
}

/// The triangles around each vertex.
struct Around {
    /// Where each vertex's run begins.
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Around {
    fn new(corners: &[[u32; 3]], vertices: usize) -> Self {
        let mut starts = vec![0; vertices + 1];
        for &vertex in corners.iter().flatten() {
            starts[vertex as usize] += 1;
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let mut triangles = vec![0; 3 * corners.len()];
        for (t, &vertex) in corners.iter().enumerate().flat_map(|(t, c)| c.iter().map(move |v| (t, v))) {
            starts[vertex as usize] -= 1;
            triangles[starts[vertex as usize] as usize] = t as u32;
        }
        Self { starts, triangles }
    }

    fn triangles(&self, vertex: u32) -> &[u32] {
        let run = &self.starts[vertex as usize..][..2];
        &self.triangles[run[0] as usize..run[1] as usize]
    }
}

impl Cutter<'_> {
    /// Halves by the longest axis until what is left makes a chunk.
    fn cut(&mut self, triangles: &mut [Triangle]) {
        if triangles.is_empty() {
            return;
        }
        if triangles.len() <= CHUNK_SIZE && self.emit(triangles) {
            return;
        }
        let mut bounds = Bounds::EMPTY;
        for triangle in &*triangles {
            bounds.extend(triangle.centre);
        }
        let axis = (bounds.max - bounds.min).max_position();
        // Whole chunks on the left keep the chunks full.
        let middle = match triangles.len() {
            n if n > CHUNK_SIZE => (n / 2).div_ceil(CHUNK_SIZE).clamp(1, (n - 1) / CHUNK_SIZE) * CHUNK_SIZE,
            n => n / 2,
        };
        triangles.select_nth_unstable_by(middle, |a, b| a.centre[axis].total_cmp(&b.centre[axis]));
        let (left, right) = triangles.split_at_mut(middle);
        self.cut(left);
        self.cut(right);
    }

    /// Makes a chunk, unless the triangles have too many vertices for one.
    fn emit(&mut self, triangles: &mut [Triangle]) -> bool {
        let first_vertex = self.out.vertices.len();
        let first_triangle = self.out.triangles.len();
        let mut pieces = Bounds::EMPTY;
        // In the mesh's own order neighbours mostly follow one another, and the hardware keeps their vertices.
        triangles.sort_unstable_by_key(|triangle| triangle.number);
        for triangle in &*triangles {
            let mut packed = 0;
            for (place, &vertex) in triangle.corners.iter().enumerate() {
                let local = &mut self.local[vertex as usize];
                if *local == u32::MAX {
                    *local = (self.out.vertices.len() - first_vertex) as u32;
                    self.out.vertices.push(Vertex { position: self.positions[vertex as usize], data: Cone::NONE.0 });
                    self.welded.push(vertex);
                }
                packed |= (*local & 0xff) << (8 * place);
            }
            self.out.triangles.push(packed);
            self.out.numbers.push(triangle.number);
            self.turned.push(triangle.turned);
            if let Some(bounds) = self.pieces.get(triangle.piece as usize) {
                pieces = pieces.union(*bounds);
            }
        }
        for triangle in &*triangles {
            for vertex in triangle.corners {
                self.local[vertex as usize] = u32::MAX;
            }
        }
        let vertex_count = self.out.vertices.len() - first_vertex;
        if vertex_count > CHUNK_SIZE {
            self.out.vertices.truncate(first_vertex);
            self.welded.truncate(first_vertex);
            self.out.triangles.truncate(first_triangle);
            self.out.numbers.truncate(first_triangle);
            self.turned.truncate(first_triangle);
            return false;
        }
        let culling = match (self.always, triangles[0].culls) {
            (true, _) => Culling::Always,
            (false, true) => Culling::Closed,
            (false, false) => Culling::None,
        };
        self.out.chunks.push(Chunk {
            first_vertex: first_vertex as u32,
            vertex_count: vertex_count as u32,
            first_triangle: first_triangle as u32,
            triangle_count: triangles.len() as u32,
            culling,
            pieces,
            normals: Cone::NONE,
        });
        true
    }

    /// Where the neighbours of the mesh's triangles, `count` in all, have come to lie.
    fn place_neighbours(&mut self, neighbours: &Neighbours, count: usize) {
        let out = &mut self.out;
        let own = |chunk: &Chunk| chunk.first_triangle as usize..(chunk.first_triangle + chunk.triangle_count) as usize;
        let mut places = vec![(0, 0); count];
        for (chunk, number) in out.chunks.iter().zip(0..) {
            for (&triangle, place) in out.numbers[own(chunk)].iter().zip(0..) {
                places[triangle as usize] = (number, place);
            }
        }
        out.records.reserve_exact(out.triangles.len());
        for (chunk, number) in out.chunks.iter().zip(0..) {
            for at in own(chunk) {
                let (triangle, turned) = (out.numbers[at], self.turned[at]);
                let beyond = neighbours.beyond(triangle, turned, number, |triangle| places[triangle]);
                out.records.push(TriangleRecord { corners: out.triangles[at], beyond });
            }
        }
    }

    /// Finds the cones of normals of the chunks whose back faces may be dropped, and around their vertices.
    fn bound_normals(&mut self) {
        let culled = |chunk: &&Chunk| chunk.culling != Culling::None;
        let corners: Vec<[u32; 3]> =
            self.out.chunks.iter().filter(culled).flat_map(|c| self.welded_corners(c)).collect();
        let around = Around::new(&corners, self.positions.len());
        let normal = |t: usize| {
            let [a, b, c] = corners[t].map(|v| self.positions[v as usize].as_dvec3());
            (b - a).cross(c - a).normalize_or_zero().as_vec3()
        };
        let normals: Vec<Vec3> = (0..corners.len()).map(normal).collect();
        let mut first = 0;
        for chunk in self.out.chunks.iter_mut().filter(|chunk| chunk.culling != Culling::None) {
            let own = first..first + chunk.triangle_count as usize;
            first = own.end;
            let run = chunk.first_vertex as usize..(chunk.first_vertex + chunk.vertex_count) as usize;
            for (vertex, &welded) in self.out.vertices[run.clone()].iter_mut().zip(&self.welded[run]) {
                vertex.data = Cone::new(around.triangles(welded).iter().map(|&t| normals[t as usize])).0;
            }
            let seen = corners[own].iter().flatten().flat_map(|&v| around.triangles(v));
            chunk.normals = Cone::new(seen.map(|&t| normals[t as usize]));
        }
    }

    /// The triangles of a chunk by their welded vertices.
    fn welded_corners(&self, chunk: &Chunk) -> impl Iterator<Item = [u32; 3]> + use<'_> {
        let (first, vertex) = (chunk.first_triangle as usize, chunk.first_vertex);
        self.out.triangles[first..first + chunk.triangle_count as usize]
            .iter()
            .map(move |packed| [0, 8, 16].map(|shift| self.welded[(vertex + (packed >> shift & 0xff)) as usize]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_touch_what_is_within_their_radius() {
        let bounds = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
        let beside = Vec3::new(3.0, 0.5, 0.5);
        assert!(bounds.touches_sphere(beside, 2.0) && !bounds.touches_sphere(beside, 1.9));
        assert!(bounds.touches_sphere(Vec3::splat(0.5), 0.0));
        // Before an instance came and after it went; the development build has glam's assertions.
        assert!(!Bounds::EMPTY.touches_sphere(Vec3::ZERO, 1e18));
    }
}
