//! One pass over the screen (`shaders/compare/lookup_pass.wgsl`).

use crate::PointLight;
use crate::compare::baselines::Bound;
use crate::compare::gpu::Gpu;
use crate::compare::shot::Shot;
use glam::Vec3;
use serde::Serialize;
use wgpu::util::{BufferInitDescriptor, DeviceExt, TextureDataOrder};

const PASS: &str = include_str!("../../../shaders/compare/lookup_pass.wgsl");

/// A share of light in four bytes, so that it can be read back like any map.
const TARGET: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// Pixels across and down of a workgroup of the compute pass.
const WORKGROUP: u32 = 8;

/// What kind of pass asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PassStage {
    /// A compute pass that writes to a storage texture, as deferred renderers light.
    Compute,
    /// A fragment pass with a color target.
    Fragment,
}

impl PassStage {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Compute, Self::Fragment];

    /// The name for reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Compute => "compute pass",
            Self::Fragment => "fragment pass",
        }
    }
}

/// What a camera sees, position and normal of each pixel, and what the passes write to.
#[derive(Debug)]
pub(super) struct Screen {
    size: (u32, u32),
    /// Of the recorded textures, and of these with the target.
    fragment: wgpu::BindGroup,
    compute: wgpu::BindGroup,
    target: wgpu::Texture,
    view: wgpu::TextureView,
}

/// A question as a pipeline, for screens of any size.
#[derive(Debug)]
pub(super) enum ShadePass {
    Compute(wgpu::ComputePipeline),
    Fragment(wgpu::RenderPipeline),
}

/// Group of the screen, behind those of a map.
const SCREEN_GROUP: usize = 3;

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
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::COPY_SRC;
        let target = device.create_texture(&descriptor(shot, TARGET, usage));
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let camera = device.create_buffer_init(&BufferInitDescriptor {
            label: Some("dual_paraboloid::compare::camera"),
            contents: bytemuck::bytes_of(&shot.eye.as_vec3().extend(shot.pixel_angle as f32)),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let mut resources: Vec<_> = recorded.iter().map(wgpu::BindingResource::TextureView).collect();
        resources.extend([camera.as_entire_binding(), wgpu::BindingResource::TextureView(&view)]);
        let group = |stage, resources: &[_]| {
            crate::gpu::bind_group(device, "compare::screen", &layout(device, stage), resources)
        };
        Self {
            size: (shot.width, shot.height),
            fragment: group(PassStage::Fragment, &resources[..3]),
            compute: group(PassStage::Compute, &resources),
            target,
            view,
        }
    }

    /// Pixels across and down.
    pub(super) fn size(&self) -> (u32, u32) {
        self.size
    }

    pub(super) fn target(&self) -> &wgpu::Texture {
        &self.target
    }

    /// Records one pass over all pixels.
    pub(super) fn record(&self, encoder: &mut wgpu::CommandEncoder, shade: &ShadePass, map: &[Bound]) {
        match shade {
            ShadePass::Compute(pipeline) => self.dispatch(encoder, pipeline, map),
            ShadePass::Fragment(pipeline) => self.draw(encoder, pipeline, map),
        }
    }

    fn dispatch(&self, encoder: &mut wgpu::CommandEncoder, pipeline: &wgpu::ComputePipeline, map: &[Bound]) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("dual_paraboloid::compare::light"),
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        for (number, (group, _)) in (0..).zip(map) {
            pass.set_bind_group(number, *group, &[]);
        }
        pass.set_bind_group(SCREEN_GROUP as u32, &self.compute, &[]);
        let (width, height) = self.size;
        pass.dispatch_workgroups(width.div_ceil(WORKGROUP), height.div_ceil(WORKGROUP), 1);
    }

    fn draw(&self, encoder: &mut wgpu::CommandEncoder, pipeline: &wgpu::RenderPipeline, map: &[Bound]) {
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
        pass.set_pipeline(pipeline);
        for (number, (group, _)) in (0..).zip(map) {
            pass.set_bind_group(number, *group, &[]);
        }
        pass.set_bind_group(SCREEN_GROUP as u32, &self.fragment, &[]);
        pass.draw(0..3, 0..1);
    }
}

impl ShadePass {
    /// A pass that evaluates the `expression` over `position` and `normal`, with the `text` of its lookup, in maps that
    /// are bound like this one.
    pub(super) fn new(gpu: &Gpu, stage: PassStage, map: &[Bound], text: &str, expression: &str) -> Self {
        let device = &gpu.device;
        let module = crate::gpu::shader(device, "compare::shade", module(text, expression));
        let screen = layout(device, stage);
        let mut layouts: Vec<_> = map.iter().map(|(_, layout)| Some(*layout)).collect();
        layouts.resize(SCREEN_GROUP, None);
        layouts.push(Some(&screen));
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("dual_paraboloid::compare::shade"),
            bind_group_layouts: &layouts,
            ..Default::default()
        });
        match stage {
            PassStage::Compute => Self::Compute(compute_pipeline(device, &layout, &module)),
            PassStage::Fragment => Self::Fragment(render_pipeline(device, &layout, &module)),
        }
    }
}

fn compute_pipeline(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
) -> wgpu::ComputePipeline {
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("dual_paraboloid::compare::light"),
        layout: Some(layout),
        module,
        entry_point: Some("light_pixels"),
        compilation_options: Default::default(),
        cache: None,
    })
}

fn render_pipeline(
    device: &wgpu::Device,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
) -> wgpu::RenderPipeline {
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("dual_paraboloid::compare::shade"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some("screen"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some("shade"),
            compilation_options: Default::default(),
            targets: &[Some(TARGET.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// The complete module of a pass of either kind.
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

fn layout(device: &wgpu::Device, stage: PassStage) -> wgpu::BindGroupLayout {
    let visibility = match stage {
        PassStage::Compute => wgpu::ShaderStages::COMPUTE,
        PassStage::Fragment => wgpu::ShaderStages::FRAGMENT,
    };
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let view_dimension = wgpu::TextureViewDimension::D2;
    let recorded = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension,
        multisampled: false,
    };
    let target = wgpu::BindingType::StorageTexture {
        access: wgpu::StorageTextureAccess::WriteOnly,
        format: TARGET,
        view_dimension,
    };
    let camera = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let mut entries = vec![entry(0, recorded), entry(1, recorded), entry(2, camera)];
    entries.extend((stage == PassStage::Compute).then(|| entry(3, target)));
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("dual_paraboloid::compare::screen"),
        entries: &entries,
    })
}
