//! The depth stage: one render pass a light, both hemispheres side by side (`shaders/depth.wgsl`,
//! `shaders/exact.wgsl`).

use crate::casters::VERTEX_SIZE;
use crate::custom::CasterPass;
use crate::gpu::{self, Binding};
use crate::light::{Coverage, PointLight};
use crate::view::{Arguments, HemisphereView, MapShape, SLOT, View};
use glam::Vec3;
use std::mem::offset_of;
use std::ops::Range;

/// Views that a light takes: for each hemisphere one for world space and one for pieces.
const VIEWS: u64 = 4;

#[derive(Debug)]
pub(crate) struct Depth {
    whole: wgpu::RenderPipeline,
    pieces: wgpu::RenderPipeline,
    exact: [wgpu::RenderPipeline; 2],
    exact_layout: wgpu::BindGroupLayout,
    layout: wgpu::BindGroupLayout,
    views: wgpu::Buffer,
    group: wgpu::BindGroup,
}

/// What a light's pass draws from.
pub(crate) struct Sources<'a> {
    pub(crate) vertices: &'a wgpu::Buffer,
    pub(crate) lists: &'a wgpu::Buffer,
    pub(crate) pieces: &'a wgpu::Buffer,
    pub(crate) arguments: &'a wgpu::Buffer,
    pub(crate) exact: &'a wgpu::BindGroup,
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
        let exact_module = gpu::shader(device, "exact", crate::wgsl::exact());
        Self {
            whole: depth_pipeline(device, &layout, &module, "depth", VERTEX_SIZE, wgpu::VertexFormat::Float32x3),
            pieces: depth_pipeline(device, &layout, &module, "depth_of_piece", 16, wgpu::VertexFormat::Float32x4),
            exact: [0, 1].map(|hemisphere| exact_pipeline(device, &exact_layout, &exact_module, hemisphere)),
            exact_layout,
            layout,
            views,
            group,
        }
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
            let mut pass = begin(encoder, target, false);
            pass.set_viewport(size * back as f32, 0.0, size, size, 0.0, 1.0);
            let (hemisphere, offset) = (&self.group, view_offset(number, back, 0));
            draw(&mut CasterPass { pass, light: *light, back: back == 1, hemisphere, offset });
        }
    }

    /// Draws what job `job` chose for the light whose views are the `light`th. The first job of a light clears.
    #[expect(clippy::too_many_arguments, reason = "one call site; each is a separate thing")]
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        sources: &Sources,
        shape: &MapShape,
        coverage: Coverage,
        light: u32,
        job: Option<u32>,
        clear: bool,
    ) {
        let mut pass = begin(encoder, target, clear);
        let Some(job) = job else { return };
        let at = u64::from(job) * SLOT;
        let size = shape.resolution as f32;
        let view = |back, relative| view_offset(light, back, relative);
        pass.set_index_buffer(sources.lists.slice(..), wgpu::IndexFormat::Uint32);
        for back in hemispheres(coverage) {
            let b = u64::from(back);
            pass.set_viewport(size * back as f32, 0.0, size, size, 0.0, 1.0);
            pass.set_pipeline(&self.whole);
            pass.set_bind_group(0, &self.group, &[view(back, 0)]);
            pass.set_vertex_buffer(0, sources.vertices.slice(..));
            pass.draw_indexed_indirect(sources.arguments, at + offset_of!(Arguments, whole) as u64 + 20 * b);
            pass.set_pipeline(&self.pieces);
            pass.set_bind_group(0, &self.group, &[view(back, 1)]);
            pass.set_vertex_buffer(0, sources.pieces.slice(..));
            pass.draw_indirect(sources.arguments, at + offset_of!(Arguments, pieces) as u64 + 16 * b);
            pass.set_pipeline(&self.exact[back as usize]);
            pass.set_bind_group(0, sources.exact, &[job * SLOT as u32]);
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

fn begin<'a>(encoder: &'a mut wgpu::CommandEncoder, target: &wgpu::TextureView, clear: bool) -> wgpu::RenderPass<'a> {
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

fn depth_pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    module: &wgpu::ShaderModule,
    entry_point: &str,
    stride: u64,
    format: wgpu::VertexFormat,
) -> wgpu::RenderPipeline {
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry_point),
        layout: Some(&gpu::pipeline_layout(device, "depth", layout)),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(entry_point),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: stride,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &[wgpu::VertexAttribute { format, offset: 0, shader_location: 0 }],
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

fn exact_pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    module: &wgpu::ShaderModule,
    hemisphere: u32,
) -> wgpu::RenderPipeline {
    let constants = [("HEMISPHERE", f64::from(hemisphere))];
    let compilation_options =
        wgpu::PipelineCompilationOptions { constants: &constants, zero_initialize_workgroup_memory: false };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("dual_paraboloid::exact"),
        layout: Some(&gpu::pipeline_layout(device, "exact", layout)),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("exact_vertex"),
            compilation_options: compilation_options.clone(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::TriangleStrip, ..Default::default() },
        depth_stencil: Some(gpu::depth_state()),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("exact_fragment"),
            compilation_options,
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    })
}
