//! A GPU array that grows and shrinks, with the writes that wait for the next recording.

use crate::Error;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Elements that an array has room for at least.
const MINIMUM: u32 = 256;

/// One growing array of fixed-size elements.
#[derive(Debug)]
pub(crate) struct Arena {
    what: &'static str,
    stride: u64,
    buffer: wgpu::Buffer,
    usage: wgpu::BufferUsages,
    limit: u64,
    generation: u64,
    /// First element and bytes of each write that waits.
    pending: Vec<(u32, Vec<u8>)>,
}

impl Arena {
    pub(crate) fn new(device: &wgpu::Device, what: &'static str, stride: u64, usage: wgpu::BufferUsages) -> Self {
        let usage = usage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let limits = device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let buffer = create(device, what, u64::from(MINIMUM) * stride, usage);
        Self { what, stride, buffer, usage, limit, generation: 0, pending: Vec::new() }
    }

    pub(crate) fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    pub(crate) fn size(&self) -> u64 {
        self.buffer.size()
    }

    /// Counts the times that the buffer was replaced.
    pub(crate) fn generation(&self) -> u64 {
        self.generation
    }

    /// Whether the device can bind `length` elements.
    pub(crate) fn check(&self, length: u64) -> Result<(), Error> {
        let needed = length * self.stride;
        if needed > self.limit {
            return Err(Error::CastersTooLarge { what: self.what, needed, limit: self.limit });
        }
        Ok(())
    }

    /// Notes bytes to be written from element `first` on.
    pub(crate) fn write(&mut self, first: u32, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        match self.pending.last_mut() {
            // Elements written one after the other make one write.
            Some((start, last))
                if u64::from(*start) * self.stride + last.len() as u64 == u64::from(first) * self.stride =>
            {
                last.extend_from_slice(bytes);
            }
            _ => self.pending.push((first, bytes.to_vec())),
        }
    }

    /// Makes room for `length` elements, or gives room back, and does the writes that wait.
    pub(crate) fn update(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        length: u32,
    ) {
        let pending = std::mem::take(&mut self.pending);
        if !self.resize(device, encoder, length) {
            for (first, bytes) in pending {
                queue.write_buffer(&self.buffer, u64::from(first) * self.stride, &bytes);
            }
            return;
        }
        // The old contents are copied in the encoder, so what is newer has to be written there too.
        for (first, bytes) in pending {
            let staging = device.create_buffer_init(&BufferInitDescriptor {
                label: Some("dual_paraboloid::casters::staging"),
                contents: &bytes,
                usage: wgpu::BufferUsages::COPY_SRC,
            });
            encoder.copy_buffer_to_buffer(
                &staging,
                0,
                &self.buffer,
                u64::from(first) * self.stride,
                bytes.len() as u64,
            );
        }
    }

    /// Doubles when full, halves when three quarters are unused; returns whether the buffer was replaced.
    fn resize(&mut self, device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, length: u32) -> bool {
        let capacity = self.buffer.size() / self.stride;
        let length = u64::from(length.max(MINIMUM));
        let wanted = if length > capacity {
            (length + length / 2).min(self.limit / self.stride)
        } else if length < capacity / 4 {
            length * 2
        } else {
            return false;
        };
        let buffer = create(device, self.what, wanted * self.stride, self.usage);
        let kept = self.buffer.size().min(buffer.size());
        encoder.copy_buffer_to_buffer(&self.buffer, 0, &buffer, 0, kept);
        self.buffer = buffer;
        self.generation += 1;
        true
    }
}

fn create(device: &wgpu::Device, what: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(&format!("dual_paraboloid::casters::{what}")),
        size,
        usage,
        mapped_at_creation: false,
    })
}
