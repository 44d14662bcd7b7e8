//! The bin stage: which tiles each large triangle touches (`shaders/bin.wgsl`).

use crate::gpu::{self, Binding, Workgroups};
use crate::view::{Projection, SLOT};
use crate::workspace::Workspace;

#[derive(Debug)]
pub(crate) struct Bin {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    workgroups: Workgroups,
}

impl Bin {
    /// With lists of `room` entries a tile.
    pub(crate) fn new(device: &wgpu::Device, projection: Projection, workgroups: Workgroups, room: u32) -> Self {
        use Binding::{Read, Uniform, Write};
        let layout =
            gpu::layout(device, "bin", wgpu::ShaderStages::COMPUTE, &[Uniform, Read, Read, Read, Write, Write]);
        let module = gpu::shader(device, "bin", crate::wgsl::bin(projection));
        let pipeline = gpu::compute_pipeline(device, "bin", &module, &[&layout], &[("ROOM", f64::from(room))]);
        Self { pipeline, layout, workgroups }
    }

    pub(crate) fn bind_group(
        &self,
        device: &wgpu::Device,
        views: &wgpu::Buffer,
        workspace: &Workspace,
    ) -> wgpu::BindGroup {
        let Workspace { records, lists, state, tiles, tile_lists, .. } = workspace;
        gpu::bind_after_views(device, "bin", &self.layout, views, &[records, lists, state, tiles, tile_lists])
    }

    /// Records a batch of `items` items, of which `first` is the first of the recording.
    pub(crate) fn record(
        &self,
        pass: &mut wgpu::ComputePass,
        group: &wgpu::BindGroup,
        first: u32,
        items: u32,
        jobs: u32,
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[first * SLOT as u32]);
        pass.dispatch_workgroups(jobs.clamp(1, self.workgroups.list_groups()), 1, items);
    }
}
