//! The split stage: from triangles whose edges bend too much to pieces whose edges don't (`shaders/split.wgsl`).

use crate::batch::MOST_JOBS;
use crate::gpu::{self, Binding, Workgroups};
use crate::view::{MapShape, SLOT};

/// Workgroups per hemisphere of a job alone in its batch; they share the triangles out evenly, neighbours to different ones.
const GROUPS: u32 = 512;

/// The same of a full batch. Fewer have more to do at a time, and as many fill the device.
const LEAST_GROUPS: u32 = 128;

/// Threads of a workgroup.
const THREADS: f64 = 64.0;

/// The same in software.
const SOFTWARE_THREADS: f64 = 8.0;

/// Workgroups for devices in software: enough that none comes near the 65,535 rounds after which llvmpipe ends the loops
/// of an invocation.
const SOFTWARE_GROUPS: u32 = LEAST_GROUPS;

/// Bytes of a piece: three corners and, with each, a depth shift.
const PIECE_SIZE: u64 = 48;

/// Bytes of a part of a big triangle: three corners and what is known of it.
const PART_SIZE: u64 = 64;

/// Parts per job and hemisphere; twin of the constant in the shader.
const PART_CAPACITY: u32 = 16_384;

/// Bytes of the pieces of a batch, unless a single job has more.
const BATCH_BYTES: u64 = 64 << 20;

#[derive(Debug)]
pub(crate) struct Split {
    /// Over the route's triangles, then over parts of the big ones.
    pipelines: [wgpu::ComputePipeline; 2],
    groups: u32,
    layout: wgpu::BindGroupLayout,
    parts: wgpu::Buffer,
    pieces: wgpu::Buffer,
    /// Pieces that each hemisphere of a job has room for.
    capacity: u32,
    /// Jobs that there is room for.
    jobs: u32,
}

impl Split {
    pub(crate) fn new(device: &wgpu::Device, workgroups: Workgroups, reject: bool) -> Self {
        use Binding::{Counters, Read, Uniform, Write};
        let layout =
            gpu::layout(device, "split", wgpu::ShaderStages::COMPUTE, &[Uniform, Counters, Write, Read, Write, Write]);
        let module = gpu::shader(device, "split", crate::wgsl::split());
        let (threads, groups) = match workgroups {
            Workgroups::Gpu => (THREADS, GROUPS),
            Workgroups::Software => (SOFTWARE_THREADS, SOFTWARE_GROUPS),
        };
        let pipelines = [1.0, 0.0].map(|coarse| {
            let constants = [("REJECT", f64::from(u8::from(reject))), ("COARSE", coarse), ("THREADS", threads)];
            gpu::compute_pipeline(device, "split", &module, Some(&layout), &constants)
        });
        Self { pipelines, groups, layout, parts: parts(device, 1), pieces: pieces(device, 1), capacity: 1, jobs: 1 }
    }

    /// Makes room for batches of so many `jobs`, as far as memory allows, each with room for the pieces of surfaces that
    /// fill the maps several times over, and for the `wanted` that an earlier recording counted; returns whether the buffers
    /// were replaced. Triangles whose pieces find no room all the same are drawn exactly.
    ///
    /// A surface that fills a hemisphere takes about `R / (2 tolerance)` pieces.
    pub(crate) fn fit(&mut self, device: &wgpu::Device, shape: &MapShape, wanted: u32, jobs: u32) -> bool {
        let surfaces = (8.0 * shape.resolution as f32 / shape.tolerance) as u64;
        let limits = device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) / (2 * PIECE_SIZE);
        let counted = u64::from(wanted) + u64::from(wanted / 4);
        let wanted = surfaces.max(counted).clamp(16_384, 1 << 22).min(limit) as u32;
        let capacity = wanted.max(self.capacity);
        let most = BATCH_BYTES.min(limit * 2 * PIECE_SIZE) / (2 * PIECE_SIZE * u64::from(capacity));
        let jobs = jobs.next_power_of_two().min(MOST_JOBS).max(self.jobs).min(most.max(1) as u32);
        if capacity == self.capacity && jobs == self.jobs {
            return false;
        }
        (self.capacity, self.jobs) = (capacity, jobs);
        self.pieces = pieces(device, capacity * jobs);
        self.parts = parts(device, jobs);
        true
    }

    /// Jobs that there is room for in one batch.
    pub(crate) fn jobs(&self) -> u32 {
        self.jobs
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
            gpu::dynamic(views, u64::from(MOST_JOBS) * SLOT),
            gpu::dynamic(arguments, u64::from(MOST_JOBS) * SLOT),
            lists.as_entire_binding(),
            vertices.as_entire_binding(),
            self.pieces.as_entire_binding(),
            self.parts.as_entire_binding(),
        ];
        gpu::bind_group(device, "split", &self.layout, &resources)
    }

    /// Records a batch: `jobs` jobs from number `first` on.
    pub(crate) fn record(&self, pass: &mut wgpu::ComputePass, group: &wgpu::BindGroup, first: u32, jobs: u32) {
        let offset = first * SLOT as u32;
        for pipeline in &self.pipelines {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, group, &[offset, offset]);
            pass.dispatch_workgroups((self.groups / jobs.div_ceil(2)).max(LEAST_GROUPS), 2, jobs);
        }
    }
}

fn parts(device: &wgpu::Device, jobs: u32) -> wgpu::Buffer {
    let size = 2 * PART_SIZE * u64::from(PART_CAPACITY * jobs);
    gpu::buffer(device, "split::parts", size, wgpu::BufferUsages::STORAGE)
}

fn pieces(device: &wgpu::Device, capacity: u32) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::VERTEX;
    gpu::buffer(device, "split::pieces", 2 * PIECE_SIZE * u64::from(capacity), usage)
}
