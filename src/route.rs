//! The route stage: from all triangles to the lists of those that each hemisphere draws or splits
//! (`shaders/route.wgsl`).

use crate::batch::{Job, MOST_JOBS};
use crate::casters::Casters;
use crate::gpu::{self, Binding, Workgroups};
use crate::view::SLOT;
use std::ops::Range;

/// Triangles that a batch's lists have room for at most, per hemisphere; more casters take several jobs a light.
/// A place in the list has to fit the 22 bits that the split keeps for it, and the buffer the portable limit.
const MOST_TRIANGLES: u32 = 1 << 22;

/// Triangles of a chunk at most.
const CHUNK: u32 = crate::chunks::CHUNK_SIZE as u32;

/// Workgroups of one dispatch; each takes several chunks when there are more.
const MOST_GROUPS: u32 = 8192;

/// Threads of a workgroup: one for each triangle of a chunk.
const THREADS: f64 = 256.0;

/// The same in software.
const SOFTWARE_THREADS: f64 = 8.0;

/// Workgroups in software. So many that none takes more than some dozen chunks: llvmpipe ends the loops of an invocation
/// after 65,535 rounds in all.
const SOFTWARE_GROUPS: u32 = 1024;

#[derive(Debug)]
pub(crate) struct Route {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    most_groups: u32,
    lists: wgpu::Buffer,
    capacity: u32,
}

impl Route {
    /// `reject` off keeps every triangle that a hemisphere isn't wholly in front of.
    pub(crate) fn new(device: &wgpu::Device, workgroups: Workgroups, reject: bool) -> Self {
        use Binding::{Counters, Read, Uniform, Write};
        let bindings = [Uniform, Counters, Read, Read, Read, Read, Write];
        let layout = gpu::layout(device, "route", wgpu::ShaderStages::COMPUTE, &bindings);
        let module = gpu::shader(device, "route", crate::wgsl::route());
        let (threads, most_groups) = match workgroups {
            Workgroups::Gpu => (THREADS, MOST_GROUPS),
            Workgroups::Software => (SOFTWARE_THREADS, SOFTWARE_GROUPS),
        };
        let constants = [("REJECT", f64::from(u8::from(reject))), ("THREADS", threads)];
        let pipeline = gpu::compute_pipeline(device, "route", &module, Some(&layout), &constants);
        let capacity = 1024;
        Self { pipeline, layout, most_groups, lists: lists(device, capacity), capacity }
    }

    pub(crate) fn lists(&self) -> &wgpu::Buffer {
        &self.lists
    }

    pub(crate) fn capacity(&self) -> u32 {
        self.capacity
    }

    pub(crate) fn memory(&self) -> u64 {
        self.lists.size()
    }

    /// Makes room for the triangles of `casters`, as far as one job takes them, and for those of a batch of `lights`
    /// lights, as far as one buffer does; returns whether the lists were replaced.
    pub(crate) fn fit(&mut self, device: &wgpu::Device, casters: &Casters, lights: u32) -> bool {
        let triangles = casters.triangle_count() * u64::from(lights.clamp(1, MOST_JOBS));
        let needed = triangles.clamp(1024, u64::from(MOST_TRIANGLES)) as u32;
        if needed <= self.capacity && needed >= self.capacity / 4 {
            return false;
        }
        self.capacity = (needed + needed / 4).min(MOST_TRIANGLES);
        self.lists = lists(device, self.capacity);
        true
    }

    /// The stretches of chunks of which the lists surely have room for the triangles of some kinds, and for how many of them
    /// each needs room.
    pub(crate) fn stretches(casters: &Casters, kinds: u32) -> impl Iterator<Item = (Range<u32>, u32)> {
        let triangles = casters.triangles_of(kinds);
        let chunks = if triangles == 0 { 0 } else { casters.chunk_count() };
        let step = if triangles <= u64::from(MOST_TRIANGLES) { chunks } else { MOST_TRIANGLES / CHUNK };
        let room = triangles.min(u64::from(MOST_TRIANGLES)) as u32;
        (0..chunks).step_by(step.max(1) as usize).map(move |first| (first..(first + step).min(chunks), room))
    }

    pub(crate) fn bind_group(
        &self,
        device: &wgpu::Device,
        views: &wgpu::Buffer,
        arguments: &wgpu::Buffer,
        casters: &Casters,
    ) -> wgpu::BindGroup {
        let resources = [
            gpu::dynamic(views, u64::from(MOST_JOBS) * SLOT),
            gpu::dynamic(arguments, u64::from(MOST_JOBS) * SLOT),
            casters.chunk_sources.buffer().as_entire_binding(),
            casters.chunk_bounds.buffer().as_entire_binding(),
            casters.triangles.buffer().as_entire_binding(),
            casters.vertices.buffer().as_entire_binding(),
            self.lists.as_entire_binding(),
        ];
        gpu::bind_group(device, "route", &self.layout, &resources)
    }

    /// Records a batch: the jobs from number `first` on.
    pub(crate) fn record(&self, pass: &mut wgpu::ComputePass, group: &wgpu::BindGroup, first: u32, jobs: &[Job]) {
        let offset = first * SLOT as u32;
        let chunks = jobs.iter().map(|job| job.chunks.len() as u32).max().unwrap_or(0);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[offset, offset]);
        pass.dispatch_workgroups(chunks.min(self.most_groups), 1, jobs.len() as u32);
    }
}

fn lists(device: &wgpu::Device, capacity: u32) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::INDEX;
    gpu::buffer(device, "route::lists", 2 * 12 * u64::from(capacity), usage)
}
