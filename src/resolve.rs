//! The resolve stage: draws what the cull stage put off, and numbers its texels (`shaders/resolve.wgsl`). Of scenes without
//! masks, and with room for all, it isn't recorded.

use crate::casters::Casters;
use crate::gpu::{self, Binding, Workgroups};
use crate::mask;
use crate::view::{Projection, SLOT};
use crate::workspace::Workspace;

#[derive(Debug)]
pub(crate) struct Resolve {
    /// Draws what was put off.
    deferred: wgpu::ComputePipeline,
    /// Numbers texels.
    numbers: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    mask_layout: wgpu::BindGroupLayout,
    workgroups: Workgroups,
}

impl Resolve {
    pub(crate) fn new(device: &wgpu::Device, projection: Projection, workgroups: Workgroups) -> Self {
        use Binding::{Read, Uniform, Write};
        let bindings = [Uniform, Read, Read, Read, Write, Write, Write];
        let layout = gpu::layout(device, "resolve", wgpu::ShaderStages::COMPUTE, &bindings);
        let mask_layout = mask::layout(device);
        let module = gpu::shader(device, "resolve", crate::wgsl::resolve(projection));
        let pipeline = |numbers: bool| {
            let constants = [
                ("THREADS", f64::from(workgroups.chunk_threads())),
                ("NUMBERS", f64::from(u8::from(numbers))),
                ("LANES", f64::from(workgroups.row_lanes())),
            ];
            gpu::compute_pipeline(device, "resolve", &module, &[&layout, &mask_layout], &constants)
        };
        Self { deferred: pipeline(false), numbers: pipeline(true), layout, mask_layout, workgroups }
    }

    pub(crate) fn bind_groups(
        &self,
        device: &wgpu::Device,
        views: &wgpu::Buffer,
        casters: &Casters,
        workspace: &Workspace,
    ) -> [wgpu::BindGroup; 2] {
        let buffers = [
            casters.chunk_sources.buffer(),
            casters.triangles.buffer(),
            casters.vertices.buffer(),
            &workspace.depths,
            &workspace.numbers,
            &workspace.state,
        ];
        let masks = [casters.records.arena().buffer().as_entire_binding()];
        [
            gpu::bind_after_views(device, "resolve", &self.layout, views, &buffers),
            gpu::bind_group(device, "masks", &self.mask_layout, &masks),
        ]
    }

    /// Records the drawing, or the numbering, of a batch of `items` items, of which `first` is the first of the recording.
    pub(crate) fn record(
        &self,
        pass: &mut wgpu::ComputePass,
        groups: &[wgpu::BindGroup; 2],
        first: u32,
        items: u32,
        parts: u32,
        numbers: bool,
    ) {
        pass.set_pipeline(if numbers { &self.numbers } else { &self.deferred });
        pass.set_bind_group(0, &groups[0], &[first * SLOT as u32]);
        pass.set_bind_group(1, &groups[1], &[]);
        // Parts have several bands.
        let groups = parts.saturating_mul(8).clamp(1, self.workgroups.late_groups());
        pass.dispatch_workgroups(groups, 1, items);
    }
}
