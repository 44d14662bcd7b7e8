//! The depth stage: one render pass a light, both hemispheres side by side (`shaders/depth.wgsl`,
//! `shaders/exact.wgsl`).

use crate::batch::Job;
use crate::casters::VERTEX_SIZE;
use crate::custom::CasterPass;
use crate::gpu::{self, Binding};
use crate::light::{Coverage, PointLight};
use crate::masked::{self, Masked};
use crate::view::{Arguments, HemisphereView, MapShape, SLOT, View};
use glam::Vec3;
use std::mem::offset_of;
use std::ops::Range;

/// Views that a light takes: for each hemisphere one for world space and one for pieces.
const VIEWS: u64 = 4;

#[derive(Debug)]
pub(crate) struct Depth {
    opaque: Pipelines,
    masked: Option<Masked>,
    layout: wgpu::BindGroupLayout,
    exact_layout: wgpu::BindGroupLayout,
    views: wgpu::Buffer,
    group: wgpu::BindGroup,
}

/// One for each of what a pass draws; for what is drawn exactly one for each hemisphere.
#[derive(Debug)]
pub(crate) struct Pipelines {
    pub(crate) whole: wgpu::RenderPipeline,
    pub(crate) pieces: wgpu::RenderPipeline,
    pub(crate) exact: [wgpu::RenderPipeline; 2],
}

/// What a light's pass draws from.
#[derive(Clone, Copy)]
pub(crate) struct Sources<'a> {
    pub(crate) vertices: &'a wgpu::Buffer,
    pub(crate) lists: &'a wgpu::Buffer,
    pub(crate) pieces: &'a wgpu::Buffer,
    pub(crate) arguments: &'a wgpu::Buffer,
    pub(crate) exact: &'a wgpu::BindGroup,
    /// If there are masked casters.
    pub(crate) masked: Option<&'a masked::Groups>,
}

impl Depth {
    /// For at most `lights` lights in one recording.
    pub(crate) fn new(device: &wgpu::Device, lights: u32) -> Self {
        let layout = gpu::layout(device, "depth", wgpu::ShaderStages::VERTEX, &[Binding::Uniform]);
        let exact_layout = gpu::layout(
            device,
            "exact",
            wgpu::ShaderStages::VERTEX_FRAGMENT,
            &[Binding::Uniform, Binding::Read, Binding::Read],
        );
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let views = gpu::buffer(device, "depth::views", u64::from(lights) * VIEWS * SLOT, usage);
        let size = size_of::<HemisphereView>() as u64;
        let group = gpu::bind_group(device, "depth", &layout, &[gpu::dynamic(&views, size)]);
        let module = gpu::shader(device, "depth", crate::wgsl::depth());
        let [whole, pieces] = [wgpu::vertex_attr_array![0 => Float32x3], wgpu::vertex_attr_array![0 => Float32x4]];
        let pipeline =
            |entry_point, buffers: &[_]| depth_pipeline(device, &[&layout], &module, entry_point, buffers, None);
        let opaque = Pipelines {
            whole: pipeline("depth", &[Some(vertex_buffer(VERTEX_SIZE, &whole))]),
            pieces: pipeline("depth_of_piece", &[None, Some(vertex_buffer(16, &pieces))]),
            exact: exact_pipelines(device, &[&exact_layout], "exact_fragment"),
        };
        Self { opaque, masked: None, layout, exact_layout, views, group }
    }

    /// The part for masked casters, made when it is first needed.
    pub(crate) fn masked(&mut self, device: &wgpu::Device) -> &Masked {
        self.masked.get_or_insert_with(|| Masked::new(device, &self.layout, &self.exact_layout))
    }

    /// Layout of a hemisphere's view, with a dynamic offset.
    pub(crate) fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    pub(crate) fn memory(&self) -> u64 {
        self.views.size()
    }

    pub(crate) fn exact_group(
        &self,
        device: &wgpu::Device,
        views: &wgpu::Buffer,
        lists: &wgpu::Buffer,
        vertices: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let size = size_of::<View>() as u64;
        let resources = [gpu::dynamic(views, size), lists.as_entire_binding(), vertices.as_entire_binding()];
        gpu::bind_group(device, "exact", &self.exact_layout, &resources)
    }

    /// Writes the hemispheres' views of the lights that are about to be recorded.
    pub(crate) fn write_views(&self, queue: &wgpu::Queue, lights: &[PointLight], shape: &MapShape) {
        let mut bytes = vec![0u8; lights.len() * (VIEWS * SLOT) as usize];
        let slots = bytes.chunks_exact_mut(SLOT as usize);
        for (i, slot) in slots.enumerate() {
            let light = &lights[i / VIEWS as usize];
            let origin = if i % 2 == 0 { light.position } else { Vec3::ZERO };
            let view = HemisphereView::new(light, shape, i % 4 >= 2, origin);
            slot[..size_of_val(&view)].copy_from_slice(bytemuck::bytes_of(&view));
        }
        queue.write_buffer(&self.views, 0, &bytes);
    }

    /// Lets the caller draw over a map of the light whose views are the `number`th.
    pub(crate) fn record_custom(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        shape: &MapShape,
        light: &PointLight,
        number: u32,
        draw: &mut dyn FnMut(&mut CasterPass),
    ) {
        let size = shape.resolution as f32;
        for back in hemispheres(light.coverage) {
            // A pass for each, so that nothing that the caller sets outlives it.
            let mut pass = Self::begin(encoder, target, false);
            pass.set_viewport(size * back as f32, 0.0, size, size, 0.0, 1.0);
            let (hemisphere, offset) = (&self.group, view_offset(number, back, 0));
            draw(&mut CasterPass { pass, light: *light, back: back == 1, hemisphere, offset });
        }
    }

    /// Begins a pass over a map, cleared or as it is.
    pub(crate) fn begin<'a>(
        encoder: &'a mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        clear: bool,
    ) -> wgpu::RenderPass<'a> {
        let load = if clear { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("dual_paraboloid::depth"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: target,
                depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }

    /// Draws what the jobs number `drawn` chose for the light whose views are the `light`th.
    pub(crate) fn draw(
        &self,
        pass: &mut wgpu::RenderPass,
        sources: &Sources,
        shape: &MapShape,
        light: u32,
        drawn: Range<u32>,
        jobs: &[Job],
    ) {
        pass.set_index_buffer(sources.lists.slice(..), wgpu::IndexFormat::Uint32);
        pass.set_vertex_buffer(0, sources.vertices.slice(..));
        pass.set_vertex_buffer(1, sources.pieces.slice(..));
        for number in drawn {
            self.draw_job(pass, sources, shape, light, number, &jobs[number as usize]);
        }
    }

    fn draw_job(
        &self,
        pass: &mut wgpu::RenderPass,
        sources: &Sources,
        shape: &MapShape,
        light: u32,
        number: u32,
        job: &Job,
    ) {
        let at = u64::from(number) * SLOT;
        let size = shape.resolution as f32;
        let view = |back, relative| view_offset(light, back, relative);
        let pipelines = match (&self.masked, sources.masked) {
            (Some(masked), Some(groups)) if job.is_masked() => {
                pass.set_bind_group(1, &groups[0], &[]);
                pass.set_bind_group(2, &groups[1], &[]);
                &masked.pipelines
            }
            _ => &self.opaque,
        };
        for back in hemispheres(job.light.coverage) {
            let b = u64::from(back);
            pass.set_viewport(size * back as f32, 0.0, size, size, 0.0, 1.0);
            pass.set_pipeline(&pipelines.whole);
            pass.set_bind_group(0, &self.group, &[view(back, 0)]);
            pass.draw_indexed_indirect(sources.arguments, at + offset_of!(Arguments, whole) as u64 + 20 * b);
            pass.set_pipeline(&pipelines.pieces);
            pass.set_bind_group(0, &self.group, &[view(back, 1)]);
            pass.draw_indirect(sources.arguments, at + offset_of!(Arguments, pieces) as u64 + 16 * b);
            pass.set_pipeline(&pipelines.exact[back as usize]);
            pass.set_bind_group(0, sources.exact, &[number * SLOT as u32]);
            pass.draw_indirect(sources.arguments, at + offset_of!(Arguments, exact) as u64 + 16 * b);
        }
    }
}

/// Offset of the view of a hemisphere of the `number`th light; `relative` is 1 for pieces.
fn view_offset(number: u32, back: u32, relative: u32) -> u32 {
    (number * VIEWS as u32 + 2 * back + relative) * SLOT as u32
}

/// The hemispheres that are drawn, 1 for the back one.
fn hemispheres(coverage: Coverage) -> Range<u32> {
    match coverage {
        Coverage::Full => 0..2,
        Coverage::Hemisphere => 0..1,
    }
}

/// A buffer of vertices that a depth pipeline draws: in slot 0 the casters', in slot 1 the pieces' corners.
pub(crate) fn vertex_buffer(stride: u64, attributes: &[wgpu::VertexAttribute]) -> wgpu::VertexBufferLayout<'_> {
    wgpu::VertexBufferLayout { array_stride: stride, step_mode: wgpu::VertexStepMode::Vertex, attributes }
}

/// Pipeline that writes the hardware's depth, wherever the fragment shader, if there is one, doesn't discard it.
pub(crate) fn depth_pipeline(
    device: &wgpu::Device,
    layouts: &[&wgpu::BindGroupLayout],
    module: &wgpu::ShaderModule,
    entry_point: &str,
    buffers: &[Option<wgpu::VertexBufferLayout>],
    fragment: Option<&str>,
) -> wgpu::RenderPipeline {
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry_point),
        layout: Some(&gpu::pipeline_layout(device, "depth", layouts)),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(entry_point),
            compilation_options: Default::default(),
            buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(gpu::depth_state()),
        multisample: wgpu::MultisampleState::default(),
        fragment: fragment.map(|entry_point| wgpu::FragmentState {
            module,
            entry_point: Some(entry_point),
            compilation_options: Default::default(),
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Pipelines of the triangles drawn exactly, one for each hemisphere.
pub(crate) fn exact_pipelines(
    device: &wgpu::Device,
    layouts: &[&wgpu::BindGroupLayout],
    fragment: &str,
) -> [wgpu::RenderPipeline; 2] {
    let module = gpu::shader(device, "exact", crate::wgsl::exact());
    [0.0, 1.0].map(|hemisphere| {
        let constants = [("HEMISPHERE", hemisphere)];
        let compilation_options =
            wgpu::PipelineCompilationOptions { constants: &constants, zero_initialize_workgroup_memory: false };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("dual_paraboloid::exact"),
            layout: Some(&gpu::pipeline_layout(device, "exact", layouts)),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("exact_vertex"),
                compilation_options: compilation_options.clone(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::TriangleStrip, ..Default::default() },
            depth_stencil: Some(gpu::depth_state()),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(fragment),
                compilation_options,
                targets: &[],
            }),
            multiview_mask: None,
            cache: None,
        })
    })
}
