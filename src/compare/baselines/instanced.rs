//! Instanced draws of the instances that a view can see, as engines record them.

use std::ops::Range;

use super::scene_buffers::{Placed, SceneBuffers};
use crate::gpu;
use crate::view::SLOT;
use glam::{Vec3, Vec4};

/// What one view projects; twin of `InstancedView` in `shaders/compare/instanced_view.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct InstancedView {
    /// Rows of the projection from world space, relative to the origin, to clip space.
    pub(super) rows: [Vec4; 4],
    pub(super) origin: Vec3,
    pub(super) padding: u32,
}

pub(super) const INSTANCED_VIEW: &str = include_str!("../../../shaders/compare/instanced_view.wgsl");
pub(super) const TRANSFORMS: &str = include_str!("../../../shaders/compare/transforms.wgsl");
const INSTANCED: &str = include_str!("../../../shaders/compare/instanced.wgsl");
const MULTIVIEW: &str = include_str!("../../../shaders/compare/multiview.wgsl");

/// The kinds of shadow pass that draw instances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PassKind {
    /// One projection a pass, no fragment shader.
    OneView,
    /// Six projections in one pass, no fragment shader.
    SixViews,
    /// One paraboloid a pass, with a fragment shader that discards what lies behind it.
    VertexWarp,
}

impl PassKind {
    /// The complete module.
    pub(super) fn text(self) -> String {
        match self {
            Self::OneView => [INSTANCED_VIEW, TRANSFORMS, INSTANCED].concat(),
            Self::SixViews => [INSTANCED_VIEW, TRANSFORMS, MULTIVIEW].concat(),
            Self::VertexWarp => [TRANSFORMS, super::vertex_warp::SHADER].concat(),
        }
    }

    /// The layers that one pass draws to, where they are several.
    pub(super) fn multiview_mask(self) -> Option<std::num::NonZeroU32> {
        let mask = if self == Self::SixViews { 0b11_1111 } else { 0 };
        std::num::NonZeroU32::new(mask)
    }
}

/// Neighbouring instances of one list that one call draws.
#[derive(Debug)]
struct Batch {
    like: Placed,
    instances: Range<u32>,
}

/// Lists of visible instances, and the pipelines that draw them.
#[derive(Debug)]
pub(super) struct InstancedDraws {
    kind: PassKind,
    pipelines: Pipelines,
    views: wgpu::Buffer,
    slot: u64,
    group: wgpu::BindGroup,
    instance_buffer: wgpu::Buffer,
    instances: Vec<u32>,
    batches: Vec<Batch>,
    lists: Vec<Range<usize>>,
}

impl InstancedDraws {
    /// For `view_count` views of `view_size` bytes, to depth of a format.
    pub(super) fn new(
        device: &wgpu::Device,
        kind: PassKind,
        format: wgpu::TextureFormat,
        view_count: u64,
        view_size: u64,
    ) -> Self {
        let layout = gpu::layout(device, "compare::views", wgpu::ShaderStages::VERTEX, &[gpu::Binding::Uniform]);
        let slot = view_size.next_multiple_of(SLOT);
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let views = gpu::buffer(device, "compare::views", view_count * slot, usage);
        Self {
            kind,
            pipelines: Pipelines::new(device, kind, format, &layout),
            group: gpu::bind_group(device, "compare::views", &layout, &[gpu::dynamic(&views, view_size)]),
            views,
            slot,
            instance_buffer: instance_buffer(device, 256),
            instances: Vec::new(),
            batches: Vec::new(),
            lists: Vec::new(),
        }
    }

    /// Forgets the lists of the last recording.
    pub(super) fn clear(&mut self) {
        self.instances.clear();
        self.batches.clear();
        self.lists.clear();
    }

    /// Adds a list of instances, given by their places in ascending order.
    pub(super) fn add_list(&mut self, scene: &SceneBuffers, visible: impl Iterator<Item = u32>) {
        let first_batch = self.batches.len();
        for place in visible {
            let placed = scene.placed()[place as usize];
            let at = self.instances.len() as u32;
            match self.batches[first_batch..].last_mut() {
                Some(batch) if batch.like.joins(&placed) => batch.instances.end = at + 1,
                _ => self.batches.push(Batch { like: placed, instances: at..at + 1 }),
            }
            self.instances.push(place);
        }
        self.lists.push(first_batch..self.batches.len());
    }

    /// Adds a list of all instances.
    pub(super) fn add_all(&mut self, scene: &SceneBuffers) {
        self.add_list(scene, 0..scene.instance_count() as u32);
    }

    /// Writes the lists and the views for the recording.
    pub(super) fn upload<V: bytemuck::Pod>(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, views: &[V]) {
        let needed = self.instances.len() as u64;
        if 4 * needed > self.instance_buffer.size() {
            self.instance_buffer = instance_buffer(device, needed.next_power_of_two());
        }
        queue.write_buffer(&self.instance_buffer, 0, bytemuck::cast_slice(&self.instances));
        let mut bytes = vec![0u8; views.len() * self.slot as usize];
        for (view, slot) in views.iter().zip(bytes.chunks_exact_mut(self.slot as usize)) {
            slot[..size_of::<V>()].copy_from_slice(bytemuck::bytes_of(view));
        }
        queue.write_buffer(&self.views, 0, &bytes);
    }

    /// Draws a list as a view sees it.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass, scene: &SceneBuffers, view: usize, list: usize) {
        pass.set_bind_group(0, &self.group, &[view as u32 * self.slot as u32]);
        scene.bind(pass);
        pass.set_vertex_buffer(1, self.instance_buffer.slice(..));
        let mut bound = None;
        for batch in &self.batches[self.lists[list].clone()] {
            let facing = Facing::new(scene.back_faces_culled(), batch.like.mirrored);
            if bound.replace(facing) != Some(facing) {
                pass.set_pipeline(self.pipelines.get(facing));
            }
            scene.draw(pass, &batch.like, batch.instances.clone());
        }
    }

    /// Begins a pass that clears a depth target.
    pub(super) fn begin<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
    ) -> wgpu::RenderPass<'a> {
        depth_pass(encoder, target, wgpu::LoadOp::Clear(0.0), self.kind.multiview_mask())
    }

    /// Bytes of the lists and views on the GPU.
    pub(super) fn memory(&self) -> u64 {
        self.views.size() + self.instance_buffer.size()
    }
}

/// Begins a depth-only pass.
pub(super) fn depth_pass<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    target: &wgpu::TextureView,
    load: wgpu::LoadOp<f32>,
    multiview_mask: Option<std::num::NonZeroU32>,
) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("dual_paraboloid::compare::depth"),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: target,
            depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        multiview_mask,
        ..Default::default()
    })
}

fn instance_buffer(device: &wgpu::Device, instances: u64) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST;
    gpu::buffer(device, "compare::instances", 4 * instances, usage)
}

/// Which faces a pipeline draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Facing {
    Both,
    Front,
    /// The front of an instance that mirrors its mesh.
    MirroredFront,
}

impl Facing {
    fn new(back_faces_culled: bool, mirrored: bool) -> Self {
        match (back_faces_culled, mirrored) {
            (false, _) => Self::Both,
            (true, false) => Self::Front,
            (true, true) => Self::MirroredFront,
        }
    }

    /// A front face is clockwise in the maps: all views have x to the right and y up with z away from the light,
    /// which mirrors what is seen.
    fn primitive(self) -> wgpu::PrimitiveState {
        let (front_face, cull_mode) = match self {
            Self::Both => (wgpu::FrontFace::Ccw, None),
            Self::Front => (wgpu::FrontFace::Cw, Some(wgpu::Face::Back)),
            Self::MirroredFront => (wgpu::FrontFace::Ccw, Some(wgpu::Face::Back)),
        };
        wgpu::PrimitiveState { front_face, cull_mode, ..Default::default() }
    }
}

#[derive(Debug)]
struct Pipelines([wgpu::RenderPipeline; 3]);

impl Pipelines {
    fn new(device: &wgpu::Device, kind: PassKind, format: wgpu::TextureFormat, views: &wgpu::BindGroupLayout) -> Self {
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("dual_paraboloid::compare::instanced"),
            bind_group_layouts: &[Some(views), Some(&SceneBuffers::layout(device))],
            ..Default::default()
        });
        let module = gpu::shader(device, "compare::instanced", kind.text());
        let facings = [Facing::Both, Facing::Front, Facing::MirroredFront];
        Self(facings.map(|facing| pipeline(device, kind, format, &layout, &module, facing)))
    }

    fn get(&self, facing: Facing) -> &wgpu::RenderPipeline {
        &self.0[facing as usize]
    }
}

fn pipeline(
    device: &wgpu::Device,
    kind: PassKind,
    format: wgpu::TextureFormat,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
    facing: Facing,
) -> wgpu::RenderPipeline {
    let vertices = wgpu::VertexBufferLayout {
        array_stride: 12,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3],
    };
    let instances = wgpu::VertexBufferLayout {
        array_stride: 4,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![1 => Uint32],
    };
    let fragment = wgpu::FragmentState {
        module,
        entry_point: Some("fragment"),
        compilation_options: Default::default(),
        targets: &[],
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("dual_paraboloid::compare::instanced"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[Some(vertices), Some(instances)],
        },
        primitive: facing.primitive(),
        depth_stencil: Some(wgpu::DepthStencilState { format, ..gpu::depth_state() }),
        multisample: wgpu::MultisampleState::default(),
        fragment: (kind == PassKind::VertexWarp).then_some(fragment),
        multiview_mask: kind.multiview_mask(),
        cache: None,
    })
}
