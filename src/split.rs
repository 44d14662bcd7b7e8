//! The split stage: from triangles whose edges bend too much to pieces whose edges don't (`shaders/split.wgsl`).

use crate::gpu::{self, Binding};
use crate::view::{Arguments, MapShape, SLOT, View};

/// Workgroups per hemisphere; they share the triangles out evenly, neighbours to different ones.
const GROUPS: u32 = 512;

/// Threads of a workgroup.
const THREADS: f64 = 64.0;

/// The same for devices in software, where a barrier costs a microsecond for every eight threads.
const SOFTWARE_THREADS: f64 = 8.0;

/// Workgroups for devices in software: enough that none comes near the 65,535 rounds after which llvmpipe ends the loops
/// of an invocation.
const SOFTWARE_GROUPS: u32 = 128;

/// Bytes of a piece: three corners and, with each, a depth shift.
const PIECE_SIZE: u64 = 48;

/// Bytes of a part of a big triangle: three corners and what is known of it.
const PART_SIZE: u64 = 60;

/// Parts per hemisphere; twin of the constant in the shader.
const PART_CAPACITY: u32 = 16_384;

#[derive(Debug)]
pub(crate) struct Split {
    /// Over the route's triangles, then over parts of the big ones.
    pipelines: [wgpu::ComputePipeline; 2],
    parts: wgpu::Buffer,
    groups: u32,
    layout: wgpu::BindGroupLayout,
    pieces: wgpu::Buffer,
    capacity: u32,
}

impl Split {
    pub(crate) fn new(device: &wgpu::Device, reject: bool) -> Self {
        use Binding::{Counters, Read, Uniform, Write};
        let layout =
            gpu::layout(device, "split", wgpu::ShaderStages::COMPUTE, &[Uniform, Counters, Write, Read, Write, Write]);
        let module = gpu::shader(device, "split", crate::wgsl::split());
        let software = gpu::is_software(device);
        let threads = if software { SOFTWARE_THREADS } else { THREADS };
        let pipelines = [1.0, 0.0].map(|coarse| {
            let constants = [("REJECT", f64::from(u8::from(reject))), ("COARSE", coarse), ("THREADS", threads)];
            gpu::compute_pipeline(device, "split", &module, Some(&layout), &constants)
        });
        let size = 2 * PART_SIZE * u64::from(PART_CAPACITY);
        let parts = gpu::buffer(device, "split::parts", size, wgpu::BufferUsages::STORAGE);
        let groups = if software { SOFTWARE_GROUPS } else { GROUPS };
        Self { pipelines, parts, groups, layout, pieces: pieces(device, 1), capacity: 1 }
    }

    /// Makes room for the pieces of surfaces that fill the maps a few times over, and for the `wanted` that an earlier
    /// recording counted; returns whether the buffer was replaced. Triangles whose pieces find no room all the same
    /// are drawn exactly.
    ///
    /// A surface that fills a hemisphere takes about `R / (2 tolerance)` pieces.
    pub(crate) fn fit(&mut self, device: &wgpu::Device, shape: &MapShape, wanted: u32) -> bool {
        let surfaces = (16.0 * shape.resolution as f32 / shape.tolerance) as u64;
        let limits = device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) / (2 * PIECE_SIZE);
        let counted = u64::from(wanted) + u64::from(wanted / 4);
        let wanted = surfaces.max(counted).clamp(16_384, 1 << 22).min(limit) as u32;
        if wanted <= self.capacity {
            return false;
        }
        self.capacity = wanted;
        self.pieces = pieces(device, wanted);
        true
    }

    pub(crate) fn pieces(&self) -> &wgpu::Buffer {
        &self.pieces
    }

    pub(crate) fn capacity(&self) -> u32 {
        self.capacity
    }

    pub(crate) fn memory(&self) -> u64 {
        self.pieces.size() + self.parts.size()
    }

    pub(crate) fn bind_group(
        &self,
        device: &wgpu::Device,
        views: &wgpu::Buffer,
        arguments: &wgpu::Buffer,
        lists: &wgpu::Buffer,
        vertices: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let resources = [
            gpu::dynamic(views, size_of::<View>() as u64),
            gpu::dynamic(arguments, size_of::<Arguments>() as u64),
            lists.as_entire_binding(),
            vertices.as_entire_binding(),
            self.pieces.as_entire_binding(),
            self.parts.as_entire_binding(),
        ];
        gpu::bind_group(device, "split", &self.layout, &resources)
    }

    pub(crate) fn record(&self, pass: &mut wgpu::ComputePass, group: &wgpu::BindGroup, job: u32) {
        let offset = job * SLOT as u32;
        for pipeline in &self.pipelines {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[offset, offset]);
            pass.dispatch_workgroups(self.groups, 2, 1);
        }
    }
}

fn pieces(device: &wgpu::Device, capacity: u32) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::VERTEX;
    gpu::buffer(device, "split::pieces", 2 * PIECE_SIZE * u64::from(capacity), usage)
}
