//! A cube map from triangles that this library's kind of routing chose: how much of its gain is routing, and how much
//! the paraboloids (`shaders/compare/cube_route.wgsl`).

use std::ops::Range;

use super::cube_lookup::CubeLookup;
use super::cube_map::{CubeDepth, CubeMap, DepthMapping, FACES};
use super::instanced::{INSTANCED_VIEW, InstancedView, depth_pass};
use crate::casters::{Casters, VERTEX_SIZE};
use crate::gpu::{self, Binding};
use crate::light::PointLight;
use crate::view::{SLOT, axes};
use glam::Vec3;

const CASTERS: &str = include_str!("../../../shaders/casters.wgsl");
const ROUTE: &str = include_str!("../../../shaders/compare/cube_route.wgsl");
const DEPTH: &str = include_str!("../../../shaders/compare/cube_routed.wgsl");

/// The complete modules: of the route and of the faces.
pub(super) fn modules() -> [String; 2] {
    [[CASTERS, ROUTE].concat(), [INSTANCED_VIEW, DEPTH].concat()]
}

/// Triangles that a face's list has room for at most; more casters take several rounds.
const MOST_TRIANGLES: u64 = 1 << 22;

/// Workgroups of one dispatch; each takes several chunks when there are more.
const MOST_GROUPS: u32 = 8192;

/// Bytes of a triangle in all six lists.
const ENTRY_SIZE: u64 = 12 * FACES.len() as u64;

/// One light and one stretch of the chunks; twin of `CubeView`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
struct RouteView {
    right: Vec3,
    near: f32,
    up: Vec3,
    range: f32,
    forward: Vec3,
    half_width: f32,
    position: Vec3,
    resolution: f32,
    first_chunk: u32,
    end_chunk: u32,
    list_capacity: u32,
    padding: u32,
}

/// Arguments of an indirect indexed draw.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
struct DrawIndexed {
    index_count: u32,
    instance_count: u32,
    first_index: u32,
    base_vertex: u32,
    first_instance: u32,
}

/// The faces' draws, whose counts the route fills in.
type Arguments = [DrawIndexed; FACES.len()];

/// One compute pass that appends each triangle to the lists of the faces it may change, then six indirect draws. Always
/// all directions, whatever the light's coverage.
#[derive(Debug)]
pub struct CubeRouted {
    map: CubeMap,
    lookup: CubeLookup,
    route: wgpu::ComputePipeline,
    route_layout: wgpu::BindGroupLayout,
    depth: wgpu::RenderPipeline,
    face_views: wgpu::Buffer,
    face_group: wgpu::BindGroup,
    jobs: JobBuffers,
    /// The route's bind group, and over which casters' buffers.
    group: Option<(GroupKey, wgpu::BindGroup)>,
}

/// Owner and generation of the casters.
type GroupKey = (u32, u64);

impl CubeRouted {
    /// Creates a cube map of `resolution` texels across a face.
    #[must_use]
    pub fn new(device: &wgpu::Device, resolution: u32) -> Self {
        use Binding::{Counters, Read, Uniform, Write};
        let bindings = [Uniform, Counters, Read, Read, Read, Read, Write];
        let route_layout = gpu::layout(device, "cube_route", wgpu::ShaderStages::COMPUTE, &bindings);
        let [route, faces] = modules();
        let module = gpu::shader(device, "compare::cube_route", route);
        let face_layout = gpu::layout(device, "cube_routed", wgpu::ShaderStages::VERTEX, &[Uniform]);
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let face_views = gpu::buffer(device, "compare::faces", FACES.len() as u64 * SLOT, usage);
        let face_view = gpu::dynamic(&face_views, size_of::<InstancedView>() as u64);
        let map = CubeMap::new(device, resolution, CubeDepth::Float32);
        Self {
            lookup: CubeLookup::new(device, map.texture()),
            map,
            route: gpu::compute_pipeline(device, "cube_route", &module, &[&route_layout], &[]),
            route_layout,
            depth: depth_pipeline(device, &face_layout, faces),
            face_group: gpu::bind_group(device, "compare::faces", &face_layout, &[face_view]),
            face_views,
            jobs: JobBuffers::new(device, 1024, 1),
            group: None,
        }
    }

    /// Records the whole map anew, after what brings the casters up to date.
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        casters: &mut Casters,
        light: &PointLight,
    ) {
        casters.update(device, queue, encoder);
        let chunks = self.fit(device, casters);
        self.bind(device, casters);
        self.jobs.write(queue, light, &self.map, &chunks);
        self.write_faces(queue, light);
        for (job, stretch) in chunks.iter().enumerate() {
            let job = (job as u64 * SLOT) as u32;
            self.record_route(encoder, job, stretch.len() as u32);
            let load = if job == 0 { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load };
            self.record_faces(encoder, casters, job, load);
        }
        self.lookup.set_light(queue, light, DepthMapping::infinite(light.near));
    }

    /// Makes room, and cuts the chunks into stretches that the lists surely have room for.
    fn fit(&mut self, device: &wgpu::Device, casters: &Casters) -> Vec<Range<u32>> {
        let limits = device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) / ENTRY_SIZE;
        let needed = casters.triangle_count().max(1024);
        let capacity = needed.min(MOST_TRIANGLES).min(limit) as u32;
        let count = casters.chunk_count();
        let step = if needed <= u64::from(capacity) {
            count.max(1)
        } else {
            (capacity / crate::chunks::CHUNK_SIZE as u32).max(1)
        };
        // Without any casters the faces are still cleared.
        let stretches: Vec<Range<u32>> =
            (0..count.max(1)).step_by(step as usize).map(|first| first..(first + step).min(count)).collect();
        if self.jobs.capacity < capacity || self.jobs.count < stretches.len() as u64 {
            self.jobs = JobBuffers::new(device, capacity, stretches.len() as u64);
            self.group = None;
        }
        stretches
    }

    fn bind(&mut self, device: &wgpu::Device, casters: &Casters) {
        let key = (casters.owner(), casters.generation());
        if self.group.as_ref().is_some_and(|(bound, _)| *bound == key) {
            return;
        }
        let resources = [
            gpu::dynamic(&self.jobs.views, size_of::<RouteView>() as u64),
            gpu::dynamic(&self.jobs.arguments, size_of::<Arguments>() as u64),
            casters.chunk_sources.buffer().as_entire_binding(),
            casters.chunk_bounds.buffer().as_entire_binding(),
            casters.triangles.buffer().as_entire_binding(),
            casters.vertices.buffer().as_entire_binding(),
            self.jobs.lists.as_entire_binding(),
        ];
        let group = gpu::bind_group(device, "compare::cube_route", &self.route_layout, &resources);
        self.group = Some((key, group));
    }

    fn write_faces(&self, queue: &wgpu::Queue, light: &PointLight) {
        let mut bytes = vec![0u8; FACES.len() * SLOT as usize];
        for (face, slot) in FACES.iter().zip(bytes.chunks_exact_mut(SLOT as usize)) {
            let view = face.view(light, self.map.half_width(), DepthMapping::infinite(light.near));
            slot[..size_of_val(&view)].copy_from_slice(bytemuck::bytes_of(&view));
        }
        queue.write_buffer(&self.face_views, 0, &bytes);
    }

    fn record_route(&self, encoder: &mut wgpu::CommandEncoder, job: u32, chunks: u32) {
        let Some((_, group)) = &self.group else { return };
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("dual_paraboloid::compare::cube_route"),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.route);
        pass.set_bind_group(0, group, &[job, job]);
        pass.dispatch_workgroups(chunks.min(MOST_GROUPS), 1, 1);
    }

    fn record_faces(&self, encoder: &mut wgpu::CommandEncoder, casters: &Casters, job: u32, load: wgpu::LoadOp<f32>) {
        for (face, target) in (0..).zip(self.map.faces()) {
            let mut pass = depth_pass(encoder, target, load, None);
            pass.set_pipeline(&self.depth);
            pass.set_bind_group(0, &self.face_group, &[face * SLOT as u32]);
            pass.set_vertex_buffer(0, casters.vertices.buffer().slice(..));
            pass.set_index_buffer(self.jobs.lists.slice(..), wgpu::IndexFormat::Uint32);
            let at = u64::from(job) + u64::from(face) * size_of::<DrawIndexed>() as u64;
            pass.draw_indexed_indirect(&self.jobs.arguments, at);
        }
    }

    /// The cube texture.
    #[must_use]
    pub fn map(&self) -> &wgpu::Texture {
        self.map.texture()
    }

    pub(super) fn lookup(&self) -> &CubeLookup {
        &self.lookup
    }

    pub(super) fn lookup_mut(&mut self) -> &mut CubeLookup {
        &mut self.lookup
    }

    /// Bytes on the GPU beside the map.
    pub(super) fn working_memory(&self) -> u64 {
        let jobs = &self.jobs;
        let lists = jobs.views.size() + jobs.arguments.size() + jobs.lists.size();
        self.face_views.size() + lists + self.lookup.memory()
    }
}

/// What the route reads and writes beside the casters.
#[derive(Debug)]
struct JobBuffers {
    views: wgpu::Buffer,
    arguments: wgpu::Buffer,
    lists: wgpu::Buffer,
    /// Triangles that a face's list has room for.
    capacity: u32,
    /// Jobs of a recording that there is room for.
    count: u64,
}

impl JobBuffers {
    fn new(device: &wgpu::Device, capacity: u32, count: u64) -> Self {
        use wgpu::BufferUsages as Usage;
        let slots = |what, usage| gpu::buffer(device, what, count * SLOT, usage | Usage::COPY_DST);
        let lists_size = ENTRY_SIZE * u64::from(capacity);
        Self {
            views: slots("compare::route_views", Usage::UNIFORM),
            arguments: slots("compare::route_arguments", Usage::STORAGE | Usage::INDIRECT),
            lists: gpu::buffer(device, "compare::route_lists", lists_size, Usage::STORAGE | Usage::INDEX),
            capacity,
            count,
        }
    }

    /// Writes each job's view, and its draws without any triangle.
    fn write(&self, queue: &wgpu::Queue, light: &PointLight, map: &CubeMap, chunks: &[Range<u32>]) {
        let mut views = vec![0u8; chunks.len() * SLOT as usize];
        let mut arguments = views.clone();
        let start = self.empty_draws();
        let [right, up, forward] = axes(light.orientation);
        let slots = views.chunks_exact_mut(SLOT as usize).zip(arguments.chunks_exact_mut(SLOT as usize));
        for (stretch, (view_slot, argument_slot)) in chunks.iter().zip(slots) {
            let view = RouteView {
                right,
                near: light.near,
                up,
                range: light.range,
                forward,
                half_width: map.half_width(),
                position: light.position,
                resolution: map.resolution() as f32,
                first_chunk: stretch.start,
                end_chunk: stretch.end,
                list_capacity: self.capacity,
                padding: 0,
            };
            view_slot[..size_of_val(&view)].copy_from_slice(bytemuck::bytes_of(&view));
            argument_slot[..size_of_val(&start)].copy_from_slice(bytemuck::bytes_of(&start));
        }
        queue.write_buffer(&self.views, 0, &views);
        queue.write_buffer(&self.arguments, 0, &arguments);
    }

    fn empty_draws(&self) -> Arguments {
        std::array::from_fn(|face| DrawIndexed {
            instance_count: 1,
            first_index: 3 * self.capacity * face as u32,
            ..Default::default()
        })
    }
}

fn depth_pipeline(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, text: String) -> wgpu::RenderPipeline {
    let module = gpu::shader(device, "compare::cube_routed", text);
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("dual_paraboloid::compare::cube_routed"),
        layout: Some(&gpu::pipeline_layout(device, "compare::cube_routed", &[layout])),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: VERTEX_SIZE,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3],
            })],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(gpu::depth_state()),
        multisample: wgpu::MultisampleState::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    })
}
