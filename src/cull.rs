//! The cull stage: leaves out what can't show, draws what is small, records what is large (`shaders/cull.wgsl`).

use crate::batch::MOST_ITEMS;
use crate::casters::Casters;
use crate::gpu::{self, Binding, Workgroups};
use crate::view::{Projection, SLOT};
use crate::workspace::Workspace;

/// Texels along a side of the largest box of a triangle that is drawn at once.
const SMALL: u32 = 8;
/// The same in software, where tiles are slower.
const SOFTWARE_SMALL: u32 = 64;

#[derive(Debug)]
pub(crate) struct Cull {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    workgroups: Workgroups,
}

impl Cull {
    /// `reject` off keeps triangles that face away in closed pieces. `small` is in texels, for tests of where triangles of
    /// both kinds meet.
    pub(crate) fn new(
        device: &wgpu::Device,
        projection: Projection,
        workgroups: Workgroups,
        reject: bool,
        small: Option<u32>,
    ) -> Self {
        use Binding::{Read, Uniform, Write};
        let bindings = [Uniform, Read, Read, Read, Read, Write, Write, Write, Write];
        let layout = gpu::layout(device, "cull", wgpu::ShaderStages::COMPUTE, &bindings);
        let module = gpu::shader(device, "cull", crate::wgsl::cull(projection));
        let small = small.unwrap_or(if workgroups == Workgroups::Software { SOFTWARE_SMALL } else { SMALL });
        let constants = [
            ("THREADS", f64::from(workgroups.chunk_threads())),
            ("REJECT", f64::from(u8::from(reject))),
            ("SMALL", f64::from(small)),
            ("ROWS_OF_BAND", f64::from(workgroups.rows_of_band())),
        ];
        let pipeline = gpu::compute_pipeline(device, "cull", &module, &[&layout], &constants);
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
            casters.chunk_bounds.buffer(),
            casters.triangles.buffer(),
            casters.vertices.buffer(),
            &workspace.depths,
            &workspace.records,
            &workspace.lists,
            &workspace.state,
        ];
        gpu::bind_after_views(device, "cull", &self.layout, views, &buffers)
    }

    /// Records a batch of `items` items, of which `first` is the first of the recording. `may_split` where nothing is put off:
    /// then several workgroups take a part if there are few, each some of its triangles.
    pub(crate) fn record(
        &self,
        pass: &mut wgpu::ComputePass,
        group: &wgpu::BindGroup,
        first: u32,
        items: u32,
        parts: u32,
        may_split: bool,
    ) {
        debug_assert!(items <= MOST_ITEMS);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[first * SLOT as u32]);
        let groups = parts.clamp(1, self.workgroups.part_groups());
        let idle = self.workgroups.part_groups() / (groups * items);
        let split = if may_split { 1 << idle.clamp(1, self.workgroups.most_split()).ilog2() } else { 1 };
        pass.dispatch_workgroups(groups, split, items);
    }
}
