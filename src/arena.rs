//! A GPU array that grows and shrinks, with the writes that wait for the next recording.

use crate::{Error, gpu};
use std::collections::BTreeMap;

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
    pending: Pending,
}

impl Arena {
    pub(crate) fn new(device: &wgpu::Device, what: &'static str, stride: u64, usage: wgpu::BufferUsages) -> Self {
        let usage = usage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let limits = device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let buffer = create(device, what, u64::from(MINIMUM) * stride, usage);
        Self { what, stride, buffer, usage, limit, generation: 0, pending: Pending::default() }
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

    /// Notes bytes to be written from element `first` on, over whatever was noted for the same elements.
    pub(crate) fn write(&mut self, first: u32, bytes: &[u8]) {
        self.pending.write(u64::from(first) * self.stride, bytes);
    }

    /// Makes room for `length` elements, or gives room back, and does the writes that wait. What lies past the buffer's end
    /// is gone, and all zeros should it grow again.
    pub(crate) fn update(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        length: u32,
    ) -> Written {
        let replaced = self.resize(device, encoder, length);
        let pending = std::mem::take(&mut self.pending);
        let (bytes, copies) = pending.up_to(self.buffer.size());
        if bytes.is_empty() {
            return Written { replaced, pending };
        }
        // By way of the encoder, since the old contents may be copied there too. One upload however many writes: each has
        // a buffer made for it by wgpu.
        let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let staging = create(device, "staging", bytes.len() as u64, usage);
        queue.write_buffer(&staging, 0, &bytes);
        for Copy { from, to, size } in copies {
            encoder.copy_buffer_to_buffer(&staging, from, &self.buffer, to, size);
        }
        Written { replaced, pending }
    }

    /// Has successive updates done again by the next one, since they never happened.
    pub(crate) fn redo(&mut self, updates: impl Iterator<Item = Written>) {
        let later = std::mem::take(&mut self.pending);
        let mut replaced = None;
        for update in updates {
            replaced = replaced.or(update.replaced);
            self.pending.append(update.pending);
        }
        self.pending.append(later);
        if let Some(buffer) = replaced {
            self.buffer = buffer;
            self.generation += 1;
        }
    }

    /// Doubles when full, halves when three quarters are unused. Returns the buffer that was replaced.
    fn resize(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        length: u32,
    ) -> Option<wgpu::Buffer> {
        let capacity = self.buffer.size() / self.stride;
        let length = u64::from(length.max(MINIMUM));
        let wanted = if length > capacity {
            (length + length / 2).min(self.limit / self.stride)
        } else if length < capacity / 4 {
            length * 2
        } else {
            return None;
        };
        let buffer = create(device, self.what, wanted * self.stride, self.usage);
        let kept = self.buffer.size().min(buffer.size());
        encoder.copy_buffer_to_buffer(&self.buffer, 0, &buffer, 0, kept);
        self.generation += 1;
        Some(std::mem::replace(&mut self.buffer, buffer))
    }
}

fn create(device: &wgpu::Device, what: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu::buffer(device, &format!("casters::{what}"), size, usage)
}

/// What an update did: all that it takes to do it again.
#[derive(Debug)]
pub(crate) struct Written {
    replaced: Option<wgpu::Buffer>,
    pending: Pending,
}

impl Written {
    /// Bytes of the buffer that was replaced.
    pub(crate) fn replaced_size(&self) -> u64 {
        self.replaced.as_ref().map_or(0, wgpu::Buffer::size)
    }
}

/// Bytes to write, by where they go; no two runs overlap.
#[derive(Debug, Default)]
struct Pending {
    runs: BTreeMap<u64, Vec<u8>>,
}

/// Bytes of the staging buffer and where they go.
#[derive(Debug, PartialEq, Eq)]
struct Copy {
    from: u64,
    to: u64,
    size: u64,
}

impl Pending {
    fn write(&mut self, start: u64, bytes: &[u8]) {
        let end = start + bytes.len() as u64;
        while let Some((&next, _)) = self.runs.range(start..end).next() {
            let run = self.runs.remove(&next).unwrap_or_default();
            let covered = (end - next) as usize;
            if run.len() > covered {
                self.runs.insert(end, run[covered..].to_vec());
            }
        }
        match self.runs.range_mut(..start).next_back() {
            Some((before, run)) if before + run.len() as u64 >= start => {
                let at = (start - before) as usize;
                let (over, behind) = bytes.split_at(bytes.len().min(run.len() - at));
                run[at..at + over.len()].copy_from_slice(over);
                run.extend_from_slice(behind);
            }
            _ if bytes.is_empty() => {}
            _ => {
                self.runs.insert(start, bytes.to_vec());
            }
        }
    }

    fn append(&mut self, later: Self) {
        if self.runs.is_empty() {
            *self = later;
            return;
        }
        later.runs.into_iter().for_each(|(start, bytes)| self.write(start, &bytes));
    }

    /// All bytes that go below `end`, one after the other, and the copies that take them there.
    fn up_to(&self, end: u64) -> (Vec<u8>, Vec<Copy>) {
        let (mut bytes, mut copies): (Vec<u8>, Vec<Copy>) = (Vec::new(), Vec::new());
        for (&to, run) in &self.runs {
            let size = (run.len() as u64).min(end.saturating_sub(to));
            if size == 0 {
                break;
            }
            match copies.last_mut() {
                Some(last) if last.to + last.size == to => last.size += size,
                _ => copies.push(Copy { from: bytes.len() as u64, to, size }),
            }
            bytes.extend_from_slice(&run[..size as usize]);
        }
        (bytes, copies)
    }
}

#[cfg(test)]
mod tests {
    use super::Pending;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_last_write_wins(writes in prop::collection::vec((0u64..64, 0usize..16), 0..40), end in 0u64..80) {
            let (mut pending, mut expected) = (Pending::default(), [0u8; 80]);
            for ((start, length), value) in writes.into_iter().zip(1..) {
                pending.write(start, &vec![value; length]);
                expected[start as usize..][..length].fill(value);
            }
            let (bytes, copies) = pending.up_to(end);
            let mut written = [0u8; 80];
            let mut before = None;
            for copy in copies {
                prop_assert!(before.is_none_or(|end| end < copy.to), "copies that touch are one");
                before = Some(copy.to + copy.size);
                let source = &bytes[copy.from as usize..][..copy.size as usize];
                written[copy.to as usize..][..source.len()].copy_from_slice(source);
            }
            expected[end as usize..].fill(0);
            prop_assert_eq!(written, expected);
        }
    }
}
