//! The transform stage: moved instances' vertices and bounds, on the GPU (`shaders/transform.wgsl`).

use crate::deform::Positions;
use crate::gpu;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Workgroups of one dispatch; each takes several chunks when there are more.
const MOST_GROUPS: u32 = 16_384;

#[derive(Debug)]
pub(crate) struct Transform {
    rest: wgpu::ComputePipeline,
    /// Made when it is first needed.
    deformed: Option<wgpu::ComputePipeline>,
}

impl Transform {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        Self { rest: pipeline(device, crate::wgsl::transform()), deformed: None }
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
        let list = job_list(device, jobs);
        let [a, b, c, d, e] = buffers.map(wgpu::Buffer::as_entire_binding);
        let resources = [a, b, c, d, e, list.as_entire_binding()];
        let group = gpu::bind_group(device, "transform", &self.rest.get_bind_group_layout(0), &resources);
        dispatch(encoder, &self.rest, &[&group], jobs);
    }

    /// [`Self::record`] for chunks of a deformed instance.
    pub(crate) fn record_deformed(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        buffers: [&wgpu::Buffer; 5],
        jobs: &[u32],
        positions: &Positions,
        mask_vertices: &wgpu::Buffer,
    ) {
        let pipeline = self.deformed.get_or_insert_with(|| pipeline(device, crate::wgsl::transform_deformed()));
        let list = job_list(device, jobs);
        let spacing = device.create_buffer_init(&BufferInitDescriptor {
            label: Some("dual_paraboloid::transform::spacing"),
            contents: bytemuck::bytes_of(&positions.spacing()),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let [a, b, c, d, e] = buffers.map(wgpu::Buffer::as_entire_binding);
        let (list, spacing) = (list.as_entire_binding(), spacing.as_entire_binding());
        let resources = [a, b, c, d, e, list, positions.binding(), spacing];
        let group = gpu::bind_group(device, "transform", &pipeline.get_bind_group_layout(0), &resources);
        let masks = [mask_vertices.as_entire_binding()];
        let masks = gpu::bind_group(device, "transform::masks", &pipeline.get_bind_group_layout(1), &masks);
        dispatch(encoder, pipeline, &[&group, &masks], jobs);
    }
}

fn pipeline(device: &wgpu::Device, text: String) -> wgpu::ComputePipeline {
    gpu::compute_pipeline(device, "transform", &gpu::shader(device, "transform", text), None, &[])
}

/// The number of chunks, then the chunks.
fn job_list(device: &wgpu::Device, jobs: &[u32]) -> wgpu::Buffer {
    device.create_buffer_init(&BufferInitDescriptor {
        label: Some("dual_paraboloid::transform::jobs"),
        contents: bytemuck::cast_slice(&[&[jobs.len() as u32], jobs].concat()),
        usage: wgpu::BufferUsages::STORAGE,
    })
}

fn dispatch(
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::ComputePipeline,
    groups: &[&wgpu::BindGroup],
    jobs: &[u32],
) {
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
        label: Some("dual_paraboloid::transform"),
        timestamp_writes: None,
    });
    pass.set_pipeline(pipeline);
    for (number, group) in (0..).zip(groups) {
        pass.set_bind_group(number, *group, &[]);
    }
    pass.dispatch_workgroups((jobs.len() as u32).min(MOST_GROUPS), 1, 1);
}
