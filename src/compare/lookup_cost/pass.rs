//! One pass over the screen (`shaders/compare/lookup_pass.wgsl`).

use crate::PointLight;
use crate::compare::gpu::Gpu;
use crate::compare::shot::Shot;
use glam::Vec3;
use wgpu::util::{DeviceExt, TextureDataOrder};

const PASS: &str = include_str!("../../../shaders/compare/lookup_pass.wgsl");

/// A share of light in four bytes, so that it can be read back like any map.
const TARGET: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// Recorded positions and normals, and what the passes draw to.
#[derive(Debug)]
pub(super) struct Screen {
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    target: wgpu::Texture,
    view: wgpu::TextureView,
}

/// A question as a pipeline, and the number of the map that it is put to.
#[derive(Debug)]
pub(super) struct ShadePass {
    pipeline: wgpu::RenderPipeline,
    pub(super) map: usize,
}

/// A map's bind group with its layout, where it has one.
type Bound<'a> = Option<(&'a wgpu::BindGroup, &'a wgpu::BindGroupLayout)>;

impl Screen {
    pub(super) fn new(gpu: &Gpu, shot: &Shot, light: &PointLight) -> Self {
        let device = &gpu.device;
        // Pixels of the sky are out of the light's range, where every lookup ends early.
        let sky = light.position + 2.0 * light.range * Vec3::Y;
        let mut pixels = vec![(sky, Vec3::Y); shot.width as usize * shot.height as usize];
        for (pixel, receiver) in &shot.seen {
            pixels[*pixel] = (receiver.position, receiver.normal);
        }
        let (positions, normals): (Vec<Vec3>, Vec<Vec3>) = pixels.into_iter().unzip();
        let recorded = [&positions, &normals].map(|values| recorded(gpu, shot, values));
        let layout = layout(device);
        let resources = recorded.each_ref().map(wgpu::BindingResource::TextureView);
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let target = device.create_texture(&descriptor(shot, TARGET, usage));
        Self {
            group: crate::gpu::bind_group(device, "compare::screen", &layout, &resources),
            layout,
            view: target.create_view(&wgpu::TextureViewDescriptor::default()),
            target,
        }
    }

    pub(super) fn target(&self) -> &wgpu::Texture {
        &self.target
    }

    pub(super) fn draw(&self, encoder: &mut wgpu::CommandEncoder, shade: &ShadePass, bound: Bound) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("dual_paraboloid::compare::shade"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&shade.pipeline);
        pass.set_bind_group(0, bound.map(|(group, _)| group), &[]);
        pass.set_bind_group(1, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }
}

impl ShadePass {
    /// A pass that evaluates the `expression` over `position` and `normal`, with the `text` of its lookup.
    pub(super) fn new(gpu: &Gpu, screen: &Screen, map: usize, bound: Bound, text: &str, expression: &str) -> Self {
        let device = &gpu.device;
        let module = crate::gpu::shader(device, "compare::shade", module(text, expression));
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("dual_paraboloid::compare::shade"),
            bind_group_layouts: &[bound.map(|(_, layout)| layout), Some(&screen.layout)],
            ..Default::default()
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("dual_paraboloid::compare::shade"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("screen"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("shade"),
                compilation_options: Default::default(),
                targets: &[Some(TARGET.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { pipeline, map }
    }
}

/// The complete module of a pass.
pub(super) fn module(text: &str, expression: &str) -> String {
    [text, &PASS.replace("EXPRESSION", expression)].concat()
}

/// A texture as large as the screen that holds a vector for each pixel.
fn recorded(gpu: &Gpu, shot: &Shot, values: &[Vec3]) -> wgpu::TextureView {
    let texels: Vec<[f32; 4]> = values.iter().map(|value| value.extend(0.0).to_array()).collect();
    let descriptor = descriptor(shot, wgpu::TextureFormat::Rgba32Float, wgpu::TextureUsages::TEXTURE_BINDING);
    let bytes = bytemuck::cast_slice(&texels);
    let texture = gpu.device.create_texture_with_data(&gpu.queue, &descriptor, TextureDataOrder::LayerMajor, bytes);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn descriptor(
    shot: &Shot,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureDescriptor<'static> {
    wgpu::TextureDescriptor {
        label: Some("dual_paraboloid::compare::screen"),
        size: wgpu::Extent3d { width: shot.width, height: shot.height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    }
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let recorded = |binding| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("dual_paraboloid::compare::screen"),
        entries: &[recorded(0), recorded(1)],
    })
}
