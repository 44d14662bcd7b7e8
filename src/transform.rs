//! The transform stage: moved instances' vertices and bounds, on the GPU (`shaders/transform.wgsl`).

use crate::gpu;

/// Workgroups of one dispatch; each takes several chunks when there are more.
const MOST_GROUPS: u32 = 16_384;

/// What is transformed: each chunk with its transform's place, and the transforms, three rows each.
#[derive(Debug, Default)]
pub(crate) struct Moved {
    pub(crate) chunks: Vec<[u32; 2]>,
    pub(crate) transforms: Vec<[[f32; 4]; 3]>,
}

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

    /// Transforms what has moved. The buffers are, in order: mesh vertices, vertices, chunks, chunk bounds.
    pub(crate) fn record(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        buffers: [&wgpu::Buffer; 4],
        moved: &Moved,
    ) {
        let upload = |what, bytes: &[u8]| {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
            let buffer = gpu::buffer(device, what, bytes.len() as u64, usage);
            queue.write_buffer(&buffer, 0, bytes);
            buffer
        };
        let transforms = upload("transform::transforms", bytemuck::cast_slice(&moved.transforms));
        let jobs = upload("transform::jobs", bytemuck::cast_slice(&moved.chunks));
        let [a, b, c, d] = buffers;
        let bind_group = gpu::bind_group(
            device,
            "transform",
            &self.pipeline.get_bind_group_layout(0),
            &[a, b, c, d, &transforms, &jobs].map(wgpu::Buffer::as_entire_binding),
        );
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("dual_paraboloid::transform"),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.dispatch_workgroups((moved.chunks.len() as u32).min(MOST_GROUPS), 1, 1);
    }
}
