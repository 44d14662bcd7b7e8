//! The number stage: which triangle each texel's depth is of (`shaders/number.wgsl`).

use crate::casters::Casters;
use crate::gpu::{self, Binding, Workgroups};
use crate::view::{Projection, SLOT};
use crate::workspace::Workspace;

/// Threads of a workgroup; twin of the constant in the shader.
const THREADS: u32 = 64;

#[derive(Debug)]
pub(crate) struct Number {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    workgroups: Workgroups,
}

impl Number {
    pub(crate) fn new(device: &wgpu::Device, projection: Projection, workgroups: Workgroups) -> Self {
        use Binding::{Read, Uniform, Write};
        let bindings = [Uniform, Read, Read, Read, Read, Write, Read, Read];
        let layout = gpu::layout(device, "number", wgpu::ShaderStages::COMPUTE, &bindings);
        let module = gpu::shader(device, "number", crate::wgsl::number(projection));
        let pipeline = gpu::compute_pipeline(device, "number", &module, &[&layout], &[]);
        Self { pipeline, layout, workgroups }
    }

    pub(crate) fn bind_group(
        &self,
        device: &wgpu::Device,
        views: &wgpu::Buffer,
        casters: &Casters,
        workspace: &Workspace,
    ) -> wgpu::BindGroup {
        let buffers = [
            casters.chunk_sources.buffer(),
            casters.triangles.buffer(),
            casters.vertices.buffer(),
            &workspace.depths,
            &workspace.numbers,
            &workspace.lists,
            &workspace.state,
        ];
        gpu::bind_after_views(device, "number", &self.layout, views, &buffers)
    }

    /// Records a batch of `items` items, of which `first` is the first of the recording, with at most `winners` each.
    pub(crate) fn record(
        &self,
        pass: &mut wgpu::ComputePass,
        group: &wgpu::BindGroup,
        first: u32,
        items: u32,
        winners: u32,
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[first * SLOT as u32]);
        pass.dispatch_workgroups(winners.div_ceil(THREADS).clamp(1, self.workgroups.list_groups()), 1, items);
    }
}
