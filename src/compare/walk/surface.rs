//! The casters' triangles and their neighbours as lookups read them.

use crate::chunks::{self, TriangleRecord, Vertex};
use crate::compare::gpu::Gpu;
use crate::compare::ideal::NO_TRIANGLE;
use crate::compare::scene::{Scene, SceneInstance, SceneMesh, world_positions};
use crate::{CasterMesh, Casters, Indices};
use glam::Vec3;

/// All casters' triangles in world space, by the numbers that maps have: chunk in bits 8-31, place in it in bits 0-7.
#[derive(Debug, Default)]
pub struct Surface {
    chunks: Vec<Chunk>,
    vertices: Vec<Vec3>,
    triangles: Vec<TriangleRecord>,
}

/// Where a chunk of an instance has its data.
#[derive(Debug, Clone, Copy)]
struct Chunk {
    vertex: u32,
    triangle: u32,
    /// Number of the casters' update that brought or moved it, 0 if it is gone.
    changed: u32,
}

/// Words of the shaders' `DpChunk`, and the first of its `place`.
const CHUNK_WORDS: usize = 24;
const PLACE: usize = 20;

impl Surface {
    /// Number of the first update of a store.
    pub const FIRST: u32 = 1;

    /// A scene's, as [`fill`](super::super::fill) makes them in a store of their own, masked meshes as if they had no
    /// holes, all as of the update [`Self::FIRST`]. With it, for each of the scene's [world triangles](Scene::world_triangles), its number; [`NO_TRIANGLE`] for those
    /// of no area.
    #[must_use]
    pub fn new(scene: &Scene) -> (Self, Vec<u32>) {
        let mut surface = Self::default();
        let mut numbers = Vec::with_capacity(scene.triangle_count());
        let meshes: Vec<_> = scene.meshes.iter().map(|mesh| surface.add_mesh(mesh)).collect();
        for instance in &scene.instances {
            let (first_triangle, mesh) = &meshes[instance.mesh];
            let first = numbers.len();
            numbers.resize(first + scene.meshes[instance.mesh].triangle_count(), NO_TRIANGLE);
            surface.add_instance(*first_triangle, mesh, instance, &mut numbers[first..]);
        }
        (surface, numbers)
    }

    fn add_mesh(&mut self, mesh: &SceneMesh) -> (u32, chunks::ChunkedMesh) {
        let indices = Indices::U32(&mesh.indices);
        let cut = chunks::cut(&CasterMesh { positions: &mesh.positions, indices, ..Default::default() });
        let first = self.triangles.len() as u32;
        self.triangles.extend(&cut.records);
        (first, cut)
    }

    fn add_instance(
        &mut self,
        first_triangle: u32,
        mesh: &chunks::ChunkedMesh,
        instance: &SceneInstance,
        numbers: &mut [u32],
    ) {
        let first_vertex = self.vertices.len() as u32;
        for chunk in &mesh.chunks {
            let number = (self.chunks.len() as u32) << 8;
            let own = chunk.first_triangle as usize..(chunk.first_triangle + chunk.triangle_count) as usize;
            for (&triangle, place) in mesh.numbers[own].iter().zip(0..) {
                numbers[triangle as usize] = number | place;
            }
            let (vertex, triangle) = (first_vertex + chunk.first_vertex, first_triangle + chunk.first_triangle);
            self.chunks.push(Chunk { vertex, triangle, changed: Self::FIRST });
        }
        let positions: Vec<[f32; 3]> = mesh.vertices.iter().map(|vertex| vertex.position.to_array()).collect();
        self.vertices
            .extend(world_positions(&positions, instance.transform).into_iter().map(|position| position.as_vec3()));
    }

    /// What a store has on the GPU after a recording.
    #[must_use]
    pub fn read(gpu: &Gpu, casters: &Casters) -> Self {
        let chunks: Vec<[u32; CHUNK_WORDS]> = gpu.read(casters.chunk_bounds.buffer());
        let chunk = |words: &[u32; CHUNK_WORDS]| Chunk {
            vertex: words[PLACE],
            triangle: words[PLACE + 1],
            changed: words[PLACE + 2],
        };
        let vertices: Vec<Vertex> = gpu.read(casters.vertices.buffer());
        Self {
            chunks: chunks.iter().map(chunk).collect(),
            vertices: vertices.iter().map(|vertex| vertex.position).collect(),
            triangles: gpu.read(casters.records.arena().buffer()),
        }
    }

    /// Whether the chunk of a triangle, by the triangle's number, is there and hasn't changed since an update.
    #[must_use]
    pub fn is_as_of(&self, number: u32, update: u32) -> bool {
        self.chunks.get((number >> 8) as usize).is_some_and(|chunk| (1..=update).contains(&chunk.changed))
    }

    /// A triangle, by its number.
    #[must_use]
    pub fn triangle(&self, number: u32) -> SurfaceTriangle {
        let Chunk { vertex, triangle, .. } = self.chunks[(number >> 8) as usize];
        let TriangleRecord { corners, beyond } = self.triangles[(triangle + (number & 0xff)) as usize];
        let corners = [0, 8, 16].map(|shift| vertex + (corners >> shift & 0xff));
        SurfaceTriangle { corners, beyond: beyond.map(|beyond| beyond.0) }
    }

    /// A vertex in world space.
    #[must_use]
    pub fn vertex(&self, vertex: u32) -> Vec3 {
        self.vertices[vertex as usize]
    }
}

/// A triangle of a [`Surface`].
#[derive(Debug, Clone, Copy)]
pub struct SurfaceTriangle {
    /// Numbers of its vertices.
    pub corners: [u32; 3],
    /// What lies beyond the edge from each corner to the next one, as the shaders read it.
    pub beyond: [u32; 3],
}
