//! How many pieces the split wanted room for, read back without waiting.

use crate::gpu;
use crate::view::{Arguments, SLOT};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// Nothing under way.
const IDLE: u32 = 0;
/// The counters are copied when the encoder is submitted.
const PENDING: u32 = 1;
/// The copy can be read.
const READY: u32 = 2;

/// Readback of the counters of one recording at a time.
#[derive(Debug)]
pub(crate) struct Demand {
    copy: wgpu::Buffer,
    state: Arc<AtomicU32>,
}

impl Demand {
    /// For recordings of at most `jobs` jobs.
    pub(crate) fn new(device: &wgpu::Device, jobs: u32) -> Self {
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let copy = gpu::buffer(device, "demand", u64::from(jobs) * SLOT, usage);
        Self { copy, state: Arc::new(AtomicU32::new(IDLE)) }
    }

    /// Bytes of the copy.
    pub(crate) fn size(&self) -> u64 {
        self.copy.size()
    }

    /// Copies the counters of a recording, unless those of an earlier one are still on their way.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder, arguments: &wgpu::Buffer, jobs: usize) {
        if self.state.compare_exchange(IDLE, PENDING, Ordering::AcqRel, Ordering::Acquire).is_err() {
            return;
        }
        // What an earlier, longer recording left behind the jobs must not be taken for theirs.
        encoder.clear_buffer(&self.copy, 0, None);
        encoder.copy_buffer_to_buffer(arguments, 0, &self.copy, 0, jobs as u64 * SLOT);
        let state = Arc::clone(&self.state);
        encoder.map_buffer_on_submit(&self.copy, wgpu::MapMode::Read, .., move |result| {
            state.store(if result.is_ok() { READY } else { IDLE }, Ordering::Release);
        });
    }

    /// The most pieces that a hemisphere of the last recording read back wanted, once.
    pub(crate) fn take(&self) -> Option<u32> {
        if self.state.load(Ordering::Acquire) != READY {
            return None;
        }
        let most = self.copy.get_mapped_range(..).ok().map(|bytes| {
            let slots = bytes.chunks_exact(SLOT as usize);
            let wanted = slots.map(|slot| {
                let arguments: Arguments = bytemuck::pod_read_unaligned(&slot[..size_of::<Arguments>()]);
                arguments.pieces_wanted[0].max(arguments.pieces_wanted[1])
            });
            wanted.max().unwrap_or(0)
        });
        self.copy.unmap();
        self.state.store(IDLE, Ordering::Release);
        most
    }
}
