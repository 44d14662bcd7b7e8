//! What lookups read of meshes: triangles with their neighbours, and masks. All of it lies in one buffer, in records of 16
//! bytes, since a renderer's fragment stage has few bindings to spare.

use crate::Error;
use crate::arena::{Arena, Written};
use crate::ranges::Ranges;

/// Words of a record.
pub(crate) const RECORD_WORDS: u32 = 4;

#[derive(Debug)]
pub(crate) struct MeshRecords {
    arena: Arena,
    ranges: Ranges,
}

impl MeshRecords {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let arena = Arena::new(device, "mesh records", 4 * u64::from(RECORD_WORDS), wgpu::BufferUsages::STORAGE);
        Self { arena, ranges: Ranges::default() }
    }

    pub(crate) fn arena(&self) -> &Arena {
        &self.arena
    }

    pub(crate) fn arena_mut(&mut self) -> &mut Arena {
        &mut self.arena
    }

    /// Whether the device can bind so many records more.
    pub(crate) fn check(&self, count: u64) -> Result<(), Error> {
        // More than fit behind all others count as if they were put there.
        let end = u32::try_from(count).map_or(u64::MAX / 64, |count| self.ranges.end_after(count));
        self.arena.check(end)
    }

    /// Takes `count` records, whose contents are those of others before, and returns the first.
    pub(crate) fn allocate(&mut self, count: u32) -> u32 {
        self.ranges.allocate(count)
    }

    /// Writes records that were taken.
    pub(crate) fn write<T: bytemuck::NoUninit>(&mut self, first: u32, records: &[T]) {
        self.arena.write(first, bytemuck::cast_slice(records));
    }

    /// Takes records for these contents, and returns the first.
    pub(crate) fn add<T: bytemuck::NoUninit>(&mut self, records: &[T]) -> u32 {
        let first = self.allocate((size_of_val(records) / (4 * RECORD_WORDS as usize)) as u32);
        self.write(first, records);
        first
    }

    pub(crate) fn release(&mut self, first: u32, count: u32) {
        self.ranges.release(first, count);
    }

    /// Brings the GPU's copy up to date.
    pub(crate) fn update(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Written {
        self.arena.update(device, queue, encoder, self.ranges.end())
    }
}
