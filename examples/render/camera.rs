//! The camera's pass and the picture that comes of it.

use crate::model::{Culling, Model, VERTEX_LAYOUTS};
use anyhow::ensure;
use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use clap::ValueEnum;
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::scene::Camera;
use dual_paraboloid::{Casters, LightId, PointLight, PointShadows};
use glam::{Mat4, UVec2, Vec3, camera::rh};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Samples per pixel along each axis; `develop.wgsl` has it too.
const SAMPLES: u32 = 2;
const RADIANCE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// How bright the bright parts of the picture become, before the tones are mapped.
const KEY: f32 = 0.6;

/// Twin of `Frame` in `shading.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Frame {
    clip_from_relative: Mat4,
    eye: Vec3,
    view: u32,
    pixel_angle: f32,
    padding: [f32; 3],
}

/// Twin of `Light` in `shading.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct LightRecord {
    position: Vec3,
    range: f32,
    intensity: Vec3,
    index: u32,
}

/// Twin of `Development` in `develop.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Development {
    exposure: f32,
    tone_mapping: f32,
}

/// What the picture shows. The numbers are those of `VIEW_...` in `shading.wgsl`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum View {
    /// The scene, lit
    Lit = 0,
    /// Only the share of light that arrives, over all lights
    Shadow = 1,
    /// Lit, with the first light's front hemisphere in orange and its back one in blue
    Hemisphere = 2,
    /// Lit, with the texels of the first light's maps as a checkerboard
    Texels = 3,
    /// What is in the first light's penumbras, neither lit nor dark
    Penumbra = 4,
    /// The depth bias for the first light, from black for none to white for a texel
    Bias = 5,
    /// The first light's shadows against ray casting: too light in red, too dark in blue
    Error = 6,
    /// The first light's shadows by this library, by a cube of as many bytes and by ray casting, side by side
    Versus = 7,
}

impl View {
    /// Whether it shows a figure and not light: then it isn't exposed.
    pub fn is_figure(self) -> bool {
        matches!(self, Self::Shadow | Self::Penumbra | Self::Bias)
    }
}

/// A light to render with.
pub struct Light {
    pub shadow: PointLight,
    /// Linear RGB of the radiant intensity, in a unit that suits the scene's size.
    pub intensity: Vec3,
}

/// What to take a picture of.
pub struct Shot<'a> {
    pub model: &'a Model,
    pub shadows: &'a PointShadows,
    /// The casters that they show.
    pub casters: &'a Casters,
    pub lights: &'a [(LightId, Light)],
    pub camera: Camera,
    /// Nearest distance that is seen.
    pub near: f32,
    pub view: View,
    pub size: UVec2,
}

/// Renders the shot, exposes it by what is in it, and returns sRGB pixels.
pub fn take(gpu: &Gpu, shot: &Shot) -> anyhow::Result<image::RgbImage> {
    let most = gpu.device.limits().max_texture_dimension_2d / SAMPLES;
    ensure!(
        shot.size.max_element() <= most,
        "a picture of {}x{} is more than this device takes: {most} pixels each way",
        shot.size.x,
        shot.size.y
    );
    let samples = shot.size * SAMPLES;
    let radiance = [0, 1].map(|_| target(&gpu.device, samples, RADIANCE));
    let depth = target(&gpu.device, samples, DEPTH);
    draw(gpu, shot, &radiance, &depth);

    let plain = Development { exposure: 1.0, tone_mapping: 0.0 };
    let luminance = develop(gpu, &radiance, shot.size, "meter", wgpu::TextureFormat::R32Float, plain);
    let development = Development {
        exposure: exposure(gpu.read_texture(&luminance, 0)),
        tone_mapping: if shot.view.is_figure() { 0.0 } else { 1.0 },
    };
    let format = wgpu::TextureFormat::Rgba8UnormSrgb;
    let picture = develop(gpu, &radiance, shot.size, "develop", format, development);
    let pixels = gpu.read_texture::<[u8; 4]>(&picture, 0);
    let pixels: Vec<u8> = pixels.into_iter().flat_map(|[red, green, blue, _]| [red, green, blue]).collect();
    let image = image::RgbImage::from_raw(shot.size.x, shot.size.y, pixels);
    image.ok_or_else(|| anyhow::anyhow!("the device gave back a picture of another size"))
}

/// What makes the bright parts of the picture bright: the 95th percentile, or where most of it is in shadow, what is
/// a good deal darker than its brightest.
fn exposure(luminance: Vec<f32>) -> f32 {
    let mut surfaces: Vec<f32> = luminance.into_iter().filter(|value| *value >= 0.0).collect();
    surfaces.sort_unstable_by(f32::total_cmp);
    let percentile = |share: f32| {
        let place = share * surfaces.len().saturating_sub(1) as f32;
        surfaces.get(place as usize).copied().unwrap_or(0.0)
    };
    let bright = percentile(0.95).max(0.1 * percentile(0.995));
    if bright > 0.0 { KEY / bright } else { 1.0 }
}

/// The camera's pass: every batch once, with the shadows looked up for each sample and light.
fn draw(gpu: &Gpu, shot: &Shot, radiance: &[wgpu::Texture; 2], depth: &wgpu::Texture) {
    let (frame_layout, frame_group) = frame(&gpu.device, shot);
    let (shadows, casters) = (shot.shadows.bind_group_layout(), shot.casters.bind_group_layout());
    let layouts = [&frame_layout, shadows, &shot.model.material_layout, casters];
    let cullings = [Culling::None, Culling::Clockwise, Culling::CounterClockwise];
    let pipelines = shading_pipelines(&gpu.device, &layouts, cullings);
    let views = radiance.each_ref().map(view);
    let attachments = views.each_ref().map(|view| Some(clear(view)));
    gpu.submit(|encoder| {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("render::shading"),
            color_attachments: &attachments,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view(depth),
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        for batch in &shot.model.batches {
            let place = cullings.iter().position(|culling| *culling == batch.culling).unwrap_or(0);
            pass.set_pipeline(&pipelines[place]);
            pass.set_bind_group(0, &frame_group, &[]);
            pass.set_bind_group(1, shot.shadows.bind_group(), &[]);
            pass.set_bind_group(3, shot.casters.bind_group(), &[]);
            shot.model.draw(&mut pass, batch);
        }
    });
}

fn frame(device: &wgpu::Device, shot: &Shot) -> (wgpu::BindGroupLayout, wgpu::BindGroup) {
    let Camera { eye, target, fov_y } = shot.camera;
    let ahead = (target - eye).normalize();
    // Straight up or down, any other direction may be at the top of the picture.
    let up = if ahead.y.abs() > 0.999 { Vec3::NEG_Z } else { Vec3::Y };
    let aspect = shot.size.x as f32 / shot.size.y as f32;
    let projection = rh::proj::directx::perspective_infinite_reverse(fov_y, aspect, shot.near);
    let frame = Frame {
        clip_from_relative: projection * rh::view::look_to_mat4(Vec3::ZERO, ahead, up),
        eye,
        view: shot.view as u32,
        pixel_angle: 2.0 * (0.5 * fov_y).tan() / shot.size.y as f32,
        padding: [0.0; 3],
    };
    let lights: Vec<LightRecord> = shot
        .lights
        .iter()
        .map(|(id, light)| LightRecord {
            position: light.shadow.position,
            range: light.shadow.range,
            intensity: light.intensity,
            index: id.index(),
        })
        .collect();
    let buffer = |what, contents: &[u8], usage| {
        device.create_buffer_init(&BufferInitDescriptor { label: Some(what), contents, usage })
    };
    let frame = buffer("render::frame", bytes_of(&frame), wgpu::BufferUsages::UNIFORM);
    let lights = buffer("render::lights", cast_slice(&lights), wgpu::BufferUsages::STORAGE);
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("render::frame"),
        entries: &[
            entry(0, wgpu::BufferBindingType::Uniform),
            entry(1, wgpu::BufferBindingType::Storage { read_only: true }),
        ],
    });
    let resources = [frame.as_entire_binding(), lights.as_entire_binding()];
    let group = bind_group(device, "frame", &layout, &resources);
    (layout, group)
}

/// The pipeline for each way of culling. The shadows are group 1, their casters group 3.
fn shading_pipelines<const N: usize>(
    device: &wgpu::Device,
    layouts: &[&wgpu::BindGroupLayout; 4],
    cullings: [Culling; N],
) -> [wgpu::RenderPipeline; N] {
    let text = [include_str!("shading.wgsl"), &dual_paraboloid::wgsl::lookup(1, 3)].concat();
    let module = shader(device, "shading", text);
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("render::shading"),
        bind_group_layouts: &layouts.map(Some),
        ..Default::default()
    });
    cullings.map(|culling| {
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("render::shading"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &VERTEX_LAYOUTS,
            },
            primitive: wgpu::PrimitiveState {
                front_face: match culling {
                    Culling::CounterClockwise => wgpu::FrontFace::Cw,
                    Culling::None | Culling::Clockwise => wgpu::FrontFace::Ccw,
                },
                cull_mode: (culling != Culling::None).then_some(wgpu::Face::Back),
                ..Default::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("shade"),
                compilation_options: Default::default(),
                targets: &[Some(RADIANCE.into()), Some(RADIANCE.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    })
}

/// Runs a fragment entry point of `develop.wgsl` over the whole picture.
fn develop(
    gpu: &Gpu,
    radiance: &[wgpu::Texture; 2],
    size: UVec2,
    entry_point: &str,
    format: wgpu::TextureFormat,
    development: Development,
) -> wgpu::Texture {
    let device = &gpu.device;
    let module = shader(device, "develop", include_str!("develop.wgsl").to_owned());
    let layout = development_layout(device);
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("render::develop"),
        layout: Some(&device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("render::develop"),
            bind_group_layouts: &[Some(&layout)],
            ..Default::default()
        })),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("whole_picture"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(entry_point),
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let record = device.create_buffer_init(&BufferInitDescriptor {
        label: Some("render::development"),
        contents: bytes_of(&development),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let [lamps, fixed_level] = radiance.each_ref().map(view);
    let resources = [
        wgpu::BindingResource::TextureView(&lamps),
        wgpu::BindingResource::TextureView(&fixed_level),
        record.as_entire_binding(),
    ];
    let group = bind_group(device, "develop", &layout, &resources);
    let result = target(device, size, format);
    gpu.submit(|encoder| {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("render::develop"),
            color_attachments: &[Some(clear(&view(&result)))],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    });
    result
}

fn development_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry =
        |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::FRAGMENT, ty, count: None };
    let texture = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let record = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("render::develop"),
        entries: &[entry(0, texture), entry(1, texture), entry(2, record)],
    })
}

/// Bindings 0, 1, ... of a group.
pub fn bind_group(
    device: &wgpu::Device,
    what: &str,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource],
) -> wgpu::BindGroup {
    let entries: Vec<wgpu::BindGroupEntry> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(&format!("render::{what}")),
        layout,
        entries: &entries,
    })
}

fn shader(device: &wgpu::Device, what: &str, text: String) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(&format!("render::{what}")),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    })
}

fn target(device: &wgpu::Device, size: UVec2, format: wgpu::TextureFormat) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("render::target"),
        size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn clear(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store },
    }
}
