//! What one run of the stages goes through: several lights at a time, so that a small light costs what is near it and not a
//! round of dispatches that wait for one another.

use crate::casters::Casters;
use crate::light::PointLight;
use crate::view::{MapShape, Projection};

/// Work items of one batch at most; twin of the constant in `shaders/view.wgsl`.
pub(crate) const MOST_ITEMS: u32 = 8;

/// Bits of [`Item::kinds`]: bit 0 of a chunk's kind says that its instance is marked as moving.
pub(crate) const STATIC: u32 = 0b0101;
/// The others.
pub(crate) const MOVING: u32 = 0b1010;
/// Bit 1 says that a chunk's mesh has holes.
pub(crate) const MASKED: u32 = 0b1100;

/// An item's map starts from that of the static casters. Twin of `FLAG_STATIC`.
pub(crate) const FROM_STATIC: u32 = 1;
/// It starts from what the caller has drawn. Twin of `FLAG_CUSTOM`.
pub(crate) const FROM_CUSTOM: u32 = 2;
/// There may be more of something than there is room for. Twin of `FLAG_OVERFLOWS`.
pub(crate) const OVERFLOWS: u32 = 4;

/// A light whose map is made, and of which kinds of chunks.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Item {
    pub(crate) light: PointLight,
    pub(crate) layer: u32,
    /// Bit k stands for chunks of kind k.
    pub(crate) kinds: u32,
    /// [`FROM_STATIC`] and [`FROM_CUSTOM`].
    pub(crate) start: u32,
}

/// Texels across a tile; twin of `TILE`.
pub(crate) const TILE: u32 = 16;
/// Tiles across a block; twin of `BLOCK`.
const BLOCK: u32 = 8;
/// Large triangles of an item that there is room for at most, counted in each map; with more they are drawn another
/// way.
const MOST_RECORDS: u64 = 1 << 18;
/// Small triangles of an item that there is room for at most. With the jobs of all records they have at most half of a
/// binding's 128 MiB, the tiles' lists the other half.
const MOST_WINNERS: u64 = 1 << 22;
/// Counters of a tile: large triangles that touch it, and its least depth.
pub(crate) const TILE_COUNTERS: u32 = 2;
/// Words of a part's bits, and of its entries in the lists; twins of `PART_BITS` and others.
const BITS: u32 = 2 * 8 + 3;
/// Bytes of the workspace of a batch of several items.
const BATCH_BYTES: u64 = 128 << 20;

/// What an item needs of the workspace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Share {
    /// Tiles of all maps.
    pub(crate) tiles: u32,
    pub(crate) records: u32,
    pub(crate) jobs: u32,
    /// Triangles that won a texel when they were drawn small.
    pub(crate) winners: u32,
    /// Words.
    pub(crate) bits: u32,
    /// Whether there may be more records or winners than room, or for tests jobs.
    pub(crate) overflows: bool,
}

impl Share {
    pub(crate) fn new(shape: &MapShape, casters: &Casters) -> Self {
        let across = shape.tiles();
        let squares = shape.projection.squares;
        let most = u64::from(squares) * casters.triangle_count();
        let records = most.clamp(64, MOST_RECORDS);
        let jobs = records * u64::from(across.div_ceil(BLOCK));
        // At most one for each texel, nearly always.
        let texels = u64::from(squares) * u64::from(shape.resolution) * u64::from(shape.resolution);
        let winners = most.min(texels.min(MOST_WINNERS)).max(64);
        Self {
            tiles: shape.all_tiles(),
            records: records as u32,
            jobs: jobs as u32,
            winners: winners as u32,
            bits: squares * BITS * casters.chunk_count().max(1),
            overflows: most > records.min(winners),
        }
    }

    /// The same with room for so many records and jobs at most.
    pub(crate) fn with_at_most(self, records: u32, jobs: u32) -> Self {
        let overflows = self.overflows || records < self.records || jobs < self.jobs;
        Self { records: records.min(self.records), jobs: jobs.min(self.jobs), overflows, ..self }
    }

    /// Words of an item's counters of tiles and bits of parts.
    pub(crate) fn state(&self) -> u32 {
        TILE_COUNTERS * self.tiles + self.bits
    }

    /// Words of an item's lists, with `room` entries a tile.
    pub(crate) fn lists(&self, room: u32) -> u64 {
        u64::from(self.jobs) + u64::from(self.winners) + u64::from(self.tiles) * u64::from(room)
    }

    /// Bytes of an item's bits, of so many chunks. Cubes have more maps, and less room.
    pub(crate) fn bits_bytes(chunks: u64) -> u64 {
        4 * u64::from(Projection::PARABOLOIDS.squares * BITS) * chunks
    }

    /// Bytes of an item's share, with lists of `room` entries.
    pub(crate) fn bytes(&self, room: u32) -> u64 {
        let texels = 8 * u64::from(TILE * TILE) * u64::from(self.tiles);
        texels + 64 * u64::from(self.records) + 4 * (self.lists(room) + u64::from(self.state()))
    }

    /// Items of a batch, of so many as there are. `limit` is the most that a buffer may have.
    pub(crate) fn items(&self, lights: u32, room: u32, limit: u64) -> u32 {
        let texels = 4 * u64::from(TILE * TILE) * u64::from(self.tiles);
        let widest = [texels, 4 * self.lists(room), 64 * u64::from(self.records), 4 * u64::from(self.state())]
            .into_iter()
            .fold(1, u64::max);
        let fit = (BATCH_BYTES / self.bytes(room)).min(limit / widest);
        fit.clamp(1, u64::from(MOST_ITEMS.min(lights.max(1)))) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_are_as_large_as_there_is_room() {
        let share = Share { tiles: 8192, records: 64, jobs: 1024, winners: 64, bits: 36, overflows: false };
        // 8192 tiles of 2048 + 8 + 512 bytes, and 8320 bytes.
        assert_eq!(share.bytes(128), 8192 * 2568 + 4096 + 4096 + 256 + 144);
        assert_eq!(share.items(64, 128, 128 << 20), 6);
        assert_eq!(share.items(3, 128, 128 << 20), 3);
        assert_eq!(share.items(64, 128, 8 << 20), 1);
        assert_eq!(Share { tiles: 128, ..share }.items(64, 128, 128 << 20), 8);
        assert_eq!(Share { tiles: 1 << 20, ..share }.items(64, 128, 128 << 20), 1);
    }
}
