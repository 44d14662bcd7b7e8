//! The transform stage: moved instances' vertices and bounds, on the GPU (`shaders/transform.wgsl`).

use crate::deform::Positions;
use crate::gpu;
use std::ops::Range;

/// Workgroups of one dispatch; each takes several chunks when there are more.
const MOST_GROUPS: u32 = 16_384;

/// What is transformed: each chunk with its transform's place, and the transforms, three rows each.
#[derive(Debug)]
pub(crate) struct Moved {
    /// The update's number in the first element, then the chunks.
    jobs: Vec<[u32; 2]>,
    transforms: Vec<[[f32; 4]; 3]>,
}

impl Moved {
    /// For the update of this number.
    pub(crate) fn new(update: u32) -> Self {
        Self { jobs: vec![[update, 0]], transforms: Vec::new() }
    }

    /// Number of chunks.
    pub(crate) fn count(&self) -> u32 {
        self.jobs.len() as u32 - 1
    }

    /// Adds an instance's chunks.
    pub(crate) fn push(&mut self, chunks: Range<u32>, transform: [[f32; 4]; 3]) {
        let place = self.transforms.len() as u32;
        self.jobs.extend(chunks.map(|chunk| [chunk, place]));
        self.transforms.push(transform);
    }

    /// The transforms and the chunks on the GPU.
    fn upload(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> [wgpu::Buffer; 2] {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        [
            upload(device, queue, "transform::transforms", usage, bytemuck::cast_slice(&self.transforms)),
            upload(device, queue, "transform::jobs", usage, bytemuck::cast_slice(&self.jobs)),
        ]
    }
}

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

    /// Transforms what has moved. The buffers are, in order: mesh vertices, vertices, chunks, chunk bounds.
    pub(crate) fn record(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        buffers: [&wgpu::Buffer; 4],
        moved: &Moved,
    ) {
        let group = self.rest.get_bind_group_layout(0);
        let uploads = moved.upload(device, queue);
        let resources = bindings(buffers, &uploads);
        let group = gpu::bind_group(device, "transform", &group, &resources);
        dispatch(encoder, &self.rest, &[&group], moved);
    }

    /// [`Self::record`] for a deformed instance.
    #[expect(clippy::too_many_arguments, reason = "one call site; each is a separate thing")]
    pub(crate) fn record_deformed(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        buffers: [&wgpu::Buffer; 4],
        moved: &Moved,
        positions: &Positions,
        mesh_records: &wgpu::Buffer,
    ) {
        let pipeline = self.deformed.get_or_insert_with(|| pipeline(device, crate::wgsl::transform_deformed()));
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let spacing = upload(device, queue, "transform::spacing", usage, bytemuck::bytes_of(&positions.spacing()));
        let uploads = moved.upload(device, queue);
        let mut resources = bindings(buffers, &uploads).to_vec();
        resources.extend([positions.binding(), spacing.as_entire_binding()]);
        let group = gpu::bind_group(device, "transform", &pipeline.get_bind_group_layout(0), &resources);
        let masks = [mesh_records.as_entire_binding()];
        let masks = gpu::bind_group(device, "transform::masks", &pipeline.get_bind_group_layout(1), &masks);
        dispatch(encoder, pipeline, &[&group, &masks], moved);
    }
}

fn pipeline(device: &wgpu::Device, text: String) -> wgpu::ComputePipeline {
    gpu::compute_pipeline(device, "transform", &gpu::shader(device, "transform", text), &[], &[])
}

fn upload(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    what: &str,
    usage: wgpu::BufferUsages,
    bytes: &[u8],
) -> wgpu::Buffer {
    let buffer = gpu::buffer(device, what, bytes.len() as u64, usage);
    queue.write_buffer(&buffer, 0, bytes);
    buffer
}

fn bindings<'a>(buffers: [&'a wgpu::Buffer; 4], uploads: &'a [wgpu::Buffer; 2]) -> [wgpu::BindingResource<'a>; 6] {
    let [a, b, c, d] = buffers;
    let [transforms, chunks] = uploads;
    [a, b, c, d, transforms, chunks].map(wgpu::Buffer::as_entire_binding)
}

fn dispatch(
    encoder: &mut wgpu::CommandEncoder,
    pipeline: &wgpu::ComputePipeline,
    groups: &[&wgpu::BindGroup],
    moved: &Moved,
) {
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
        label: Some("dual_paraboloid::transform"),
        timestamp_writes: None,
    });
    pass.set_pipeline(pipeline);
    for (number, group) in (0..).zip(groups) {
        pass.set_bind_group(number, *group, &[]);
    }
    pass.dispatch_workgroups(moved.count().min(MOST_GROUPS), 1, 1);
}
