//! The assign stage: which triangle each texel's depth is of (`shaders/number.wgsl`), and which tiles each large triangle
//! touches (`shaders/bin.wgsl`), in one dispatch (`shaders/assign.wgsl`).

use crate::batch::Share;
use crate::casters::Casters;
use crate::gpu::{self, Binding, Workgroups};
use crate::view::{Projection, SLOT};
use crate::workspace::Workspace;

/// Threads of a workgroup; twin of the constant in the shader.
const THREADS: u32 = 64;
/// Threads that share a winner, or a record.
const LANES: u32 = 8;

#[derive(Debug)]
pub(crate) struct Assign {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    workgroups: Workgroups,
}

impl Assign {
    /// With lists of `room` entries a tile.
    pub(crate) fn new(device: &wgpu::Device, projection: Projection, workgroups: Workgroups, room: u32) -> Self {
        use Binding::{Read, Uniform, Write};
        let bindings = [Uniform, Read, Read, Read, Read, Write, Read, Write, Write];
        let layout = gpu::layout(device, "assign", wgpu::ShaderStages::COMPUTE, &bindings);
        let module = gpu::shader(device, "assign", crate::wgsl::assign(projection));
        let constants = [("ROOM", f64::from(room)), ("FEW", f64::from(workgroups.few_winners()))];
        let pipeline = gpu::compute_pipeline(device, "assign", &module, &[&layout], &constants);
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
            &workspace.records,
            &workspace.lists,
            &workspace.state,
        ];
        gpu::bind_after_views(device, "assign", &self.layout, views, &buffers)
    }

    /// Records a batch of `items` items, of which `first` is the first of the recording. Without `bins` it only numbers.
    pub(crate) fn record(
        &self,
        pass: &mut wgpu::ComputePass,
        group: &wgpu::BindGroup,
        first: u32,
        items: u32,
        share: &Share,
        bins: bool,
    ) {
        let wanted = (LANES * share.winners.max(share.records)).div_ceil(THREADS).max(share.jobs);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[first * SLOT as u32]);
        pass.dispatch_workgroups(wanted.clamp(1, self.workgroups.list_groups()), 1 + u32::from(bins), items);
    }
}
