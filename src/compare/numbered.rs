//! Which triangle a number in the maps stands for.

use super::gpu::Gpu;
use crate::Casters;
use crate::casters::ChunkSource;
use crate::chunks::Vertex;
use glam::Vec3;
use std::collections::BTreeMap;

/// The number of a texel that nothing of the library's covers.
pub const NO_NUMBER: u32 = u32::MAX;

impl Gpu {
    /// The corners, in the world, of the triangles of all instances as they were at the last recording, by their numbers:
    /// the chunk in bits 8-31, the place in it in bits 0-7.
    ///
    /// # Panics
    /// If the device is lost.
    #[must_use]
    pub fn numbered_triangles(&self, casters: &Casters) -> BTreeMap<u32, [Vec3; 3]> {
        let sources: Vec<ChunkSource> = self.read(casters.chunk_sources.buffer());
        let triangles: Vec<u32> = self.read(casters.triangles.buffer());
        let vertices: Vec<Vertex> = self.read(casters.vertices.buffer());
        let mut result = BTreeMap::new();
        for (chunk, source) in (0..casters.chunk_count()).zip(&sources) {
            for place in 0..source.counts >> 9 & 0x1ff {
                let packed = triangles[(source.triangle + place) as usize];
                let corner = |shift: u32| vertices[(source.vertex + (packed >> shift & 0xff)) as usize].position;
                result.insert(chunk << 8 | place, [0, 8, 16].map(corner));
            }
        }
        result
    }
}
