//! Positions that the caller writes on the GPU: skinning, cloth, morphs.

use crate::Error;
use crate::chunks::Bounds;
use glam::Vec3;

/// Where an instance's vertices are now, for a mesh that [`deforms`](crate::CasterMesh::deforms).
#[derive(Debug, Clone, Copy)]
pub struct Deformed<'a> {
    /// Three `f32` for each of the mesh's positions, in the same order and in the mesh's space; finite. With the usage
    /// `STORAGE`. It is kept, and read by the [`PointShadows::record`](crate::PointShadows::record) after each
    /// [`Casters::deform`](crate::Casters::deform) and each move of the instance.
    pub positions: &'a wgpu::Buffer,
    /// Bytes before the first position; a multiple of 4.
    pub offset: u64,
    /// Bytes from one position to the next; a multiple of 4, at least 12. A shader's `array<vec3<f32>>` has 16.
    pub stride: u64,
    /// Lowest corner of a box around the positions, in the mesh's space. Which lights' maps are made anew follows from
    /// the box: what is outside of it may be missing in others.
    pub min: Vec3,
    /// Highest corner of that box.
    pub max: Vec3,
}

impl Deformed<'_> {
    /// What is wrong with it for a mesh of so many positions.
    pub(crate) fn validate(&self, count: u64, limits: &wgpu::Limits) -> Result<(), Error> {
        let check = |ok: bool, what, value: String, remedy: String| {
            if ok { Ok(()) } else { Err(Error::InvalidDeformed { what, value, remedy }) }
        };
        let Self { positions, offset, stride, min, max } = *self;
        let ordered = min.is_finite() && max.is_finite() && min.cmple(max).all();
        let remedy = "min must be finite and not above max on any axis".to_owned();
        check(ordered, "bounds", format!("{min} to {max}"), remedy)?;
        let remedy = "it must be a multiple of 4 from 12 on".to_owned();
        check(stride >= 12 && stride % 4 == 0, "stride", format!("{stride} bytes"), remedy)?;
        check(offset % 4 == 0, "offset", format!("{offset} bytes"), "it must be a multiple of 4".to_owned())?;
        let usage = positions.usage();
        let remedy = "create the buffer with STORAGE too".to_owned();
        check(usage.contains(wgpu::BufferUsages::STORAGE), "usage", format!("{usage:?}"), remedy)?;
        let end = (count - 1).checked_mul(stride).and_then(|last| offset.checked_add(last)?.checked_add(12));
        let held = end.is_some_and(|end| end <= positions.size());
        let needed = end.map_or("more than 2^64".to_owned(), |end| end.to_string());
        let remedy =
            format!("{count} positions end at byte {needed}: give a larger buffer or the offset they begin at");
        check(held, "buffer", format!("{} bytes long", positions.size()), remedy)?;
        let (needed, limit) = (12 + (count - 1) * stride + SLACK, limits.max_storage_buffer_binding_size);
        if needed > limit {
            return Err(Error::CastersTooLarge { what: "deformed positions", needed, limit });
        }
        Ok(())
    }

    pub(crate) fn bounds(&self) -> Bounds {
        Bounds { min: self.min, max: self.max }
    }
}

/// Bytes before the first position that may have to be bound too, since bindings begin at multiples of this on every
/// device.
const SLACK: u64 = 256;

/// What is kept of [`Deformed`].
#[derive(Debug, Clone)]
pub(crate) struct Positions {
    buffer: wgpu::Buffer,
    offset: u64,
    stride: u64,
    count: u64,
}

impl Positions {
    pub(crate) fn new(deformed: &Deformed, count: u64) -> Self {
        let Deformed { positions, offset, stride, .. } = *deformed;
        Self { buffer: positions.clone(), offset, stride, count }
    }

    /// The part of the buffer that holds them.
    pub(crate) fn binding(&self) -> wgpu::BindingResource<'_> {
        let offset = self.offset - self.offset % SLACK;
        let size = self.offset + (self.count - 1) * self.stride + 12 - offset;
        let buffer = &self.buffer;
        wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset, size: wgpu::BufferSize::new(size) })
    }

    /// Words of that part before the first position, and from one to the next.
    pub(crate) fn spacing(&self) -> [u32; 2] {
        [(self.offset % SLACK / 4) as u32, (self.stride / 4) as u32]
    }
}
