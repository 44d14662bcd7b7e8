//! What the stages of a batch hand on to one another. All of it is as it was, zero, once the last stage is done.

use crate::batch::{MOST_ITEMS, Share, TILE, TILE_COUNTERS};
use crate::gpu;

/// Words of an item's counters; twins in `shaders/view.wgsl`.
const COUNTERS: u32 = 8;

/// Bytes that all counters take at most, half each: those of a recording, of two items for each of as many lights as textures
/// have layers, and those of a batch's tiles, of which 128 MiB of texels have 131,072.
pub(crate) const COUNTERS_ROOM: u64 = 2 << 20;

/// The most that an item has, for tests.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Most {
    pub(crate) records: Option<u32>,
    pub(crate) jobs: Option<u32>,
}

/// Buffers that the stages share.
#[derive(Debug)]
pub(crate) struct Workspace {
    /// Greatest depth of each texel, tile by tile, of what is drawn small.
    pub(crate) depths: wgpu::Buffer,
    /// The triangle that has it.
    pub(crate) numbers: wgpu::Buffer,
    pub(crate) records: wgpu::Buffer,
    /// Jobs of the binning, then winners, then the tiles' lists of large triangles.
    pub(crate) lists: wgpu::Buffer,
    /// Counters of all items of a recording; of a batch the tiles' counters, and then the chunks' bits.
    pub(crate) state: wgpu::Buffer,
    share: Share,
    room: u32,
    most: Most,
    /// Items of a batch.
    items: u32,
    /// Items of a recording that there are counters for.
    counted: u32,
}

impl Workspace {
    /// For batches of `items` items, of `counted` in all, and lists of `room` entries a tile.
    pub(crate) fn new(device: &wgpu::Device, share: Share, room: u32, most: Most, items: u32, counted: u32) -> Self {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let buffer = |what, words: u32, each: u32| {
            gpu::buffer(device, what, 4 * u64::from(words) * u64::from(each) * u64::from(items), usage)
        };
        let state = u64::from(COUNTERS * counted) + u64::from(share.state()) * u64::from(items);
        let lists = share.lists(room) * u64::from(items);
        Self {
            depths: buffer("workspace::depths", share.tiles, TILE * TILE),
            numbers: buffer("workspace::numbers", share.tiles, TILE * TILE),
            records: buffer("workspace::records", share.records, 16),
            lists: gpu::buffer(device, "workspace::lists", 4 * lists, usage),
            state: gpu::buffer(device, "workspace::state", 4 * state, usage),
            share,
            room,
            most,
            items,
            counted,
        }
    }

    /// Makes room, or gives it back where much is unused; returns whether buffers were replaced.
    pub(crate) fn fit(&mut self, device: &wgpu::Device, share: Share, lights: u32, counted: u32) -> bool {
        let share = share.with_at_most(self.most.records.unwrap_or(u32::MAX), self.most.jobs.unwrap_or(u32::MAX));
        let limits = device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let items = share.items(lights, self.room, limit - COUNTERS_ROOM);
        let fits = share.tiles == self.share.tiles
            && share.records <= self.share.records
            && share.jobs <= self.share.jobs
            && share.winners <= self.share.winners
            && share.bits <= self.share.bits
            && counted <= self.counted
            && items == self.items;
        let used = share.bytes(self.room) * u64::from(items);
        self.share.overflows = share.overflows;
        if fits && used >= self.memory() / 4 {
            return false;
        }
        // A quarter more, so that a scene that grows step by step isn't given new buffers with each.
        let more = |x: u32| x + x / 4;
        let most = ((limit - COUNTERS_ROOM) / 4 / u64::from(items)) as u32;
        let roomy = if fits { share } else { Share { bits: more(share.bits).min(most.max(share.bits)), ..share } };
        *self = Self::new(device, roomy, self.room, self.most, items, more(counted).max(MOST_ITEMS));
        true
    }

    pub(crate) fn share(&self) -> &Share {
        &self.share
    }

    /// Items of a batch.
    pub(crate) fn items(&self) -> u32 {
        self.items
    }

    /// Where the item number `number` of a recording has its counters, in words.
    pub(crate) fn counters(number: u32) -> u32 {
        COUNTERS * number
    }

    /// Where the counters of a batch's tiles begin, in words.
    pub(crate) fn tile_counters(&self) -> u32 {
        COUNTERS * self.counted
    }

    /// Where the item number `place` of a batch has its bits, in words.
    pub(crate) fn bits(&self, place: u32) -> u32 {
        self.tile_counters() + TILE_COUNTERS * self.share.tiles * self.items + self.share.bits * place
    }

    /// Where the item number `place` of a batch has its winners.
    pub(crate) fn winners(&self, place: u32) -> u32 {
        self.share.jobs * self.items + self.share.winners * place
    }

    /// Where the lists of a batch's tiles begin.
    pub(crate) fn tile_lists(&self) -> u32 {
        self.winners(self.items)
    }

    /// Resets the counters of a recording of `items` items. They travel as the views do, so that the stages wait for both at once.
    pub(crate) fn clear_counters(&self, device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, items: u32) {
        gpu::write(device, encoder, &self.state, &vec![0; 4 * (COUNTERS * items) as usize]);
    }

    /// Makes everything zero where the last stage isn't recorded.
    #[cfg(feature = "compare")]
    pub(crate) fn clear(&self, encoder: &mut wgpu::CommandEncoder) {
        for buffer in [&self.depths, &self.numbers, &self.state] {
            encoder.clear_buffer(buffer, 0, None);
        }
    }

    pub(crate) fn memory(&self) -> u64 {
        let buffers = [&self.depths, &self.numbers, &self.records, &self.lists, &self.state];
        buffers.into_iter().map(wgpu::Buffer::size).sum()
    }
}
