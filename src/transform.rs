//! The transform stage: moved instances' vertices and bounds, on the GPU (`shaders/transform.wgsl`).

use crate::gpu;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Workgroups of one dispatch; each takes several chunks when there are more.
const MOST_GROUPS: u32 = 16_384;

#[derive(Debug)]
pub(crate) struct Transform {
    pipeline: wgpu::ComputePipeline,
}

impl Transform {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let pipeline = gpu::compute_pipeline(
            device,
            "transform",
            &gpu::shader(device, "transform", crate::wgsl::transform()),
            None,
            &[],
        );
        Self { pipeline }
    }

    /// Transforms the chunks `jobs`. The buffers are, in order: mesh vertices, vertices, chunks, chunk bounds,
    /// transforms.
    pub(crate) fn record(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        buffers: [&wgpu::Buffer; 5],
        jobs: &[u32],
    ) {
        let count = [jobs.len() as u32];
        let list = device.create_buffer_init(&BufferInitDescriptor {
            label: Some("dual_paraboloid::transform::jobs"),
            contents: bytemuck::cast_slice(&[&count, jobs].concat()),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let [a, b, c, d, e] = buffers;
        let bind_group = gpu::bind_group(
            device,
            "transform",
            &self.pipeline.get_bind_group_layout(0),
            &[a, b, c, d, e, &list].map(wgpu::Buffer::as_entire_binding),
        );
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("dual_paraboloid::transform"),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.dispatch_workgroups(count[0].min(MOST_GROUPS), 1, 1);
    }
}
