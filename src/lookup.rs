//! What the lighting pass binds: the maps, and the lights as they were when their maps were made
//! (`shaders/lookup.wgsl`, `shaders/filter.wgsl`).

use crate::filter::FilterRecord;
use crate::gpu;
use crate::light::PointLight;
use crate::view::{MapShape, axes, hemispheres};
use glam::{Vec2, Vec3};

/// A light as the lookup reads it; twin of `DpLight`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
struct LightRecord {
    right: Vec3,
    near: f32,
    up: Vec3,
    range: f32,
    forward: Vec3,
    texels: f32,
    position: Vec3,
    hemispheres: u32,
    origin: Vec2,
    resolution: f32,
    layer: u32,
    normal_bias: f32,
    filtering: FilterRecord,
}

#[derive(Debug)]
pub(crate) struct Lookup {
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    lights: wgpu::Buffer,
    /// What the lights are to be, and whether the buffer isn't up to date.
    records: Vec<LightRecord>,
    changed: bool,
}

impl Lookup {
    /// For the layers of `maps`, depths, one a light.
    pub(crate) fn new(device: &wgpu::Device, maps: &wgpu::Texture) -> Self {
        let layout = layout(device);
        let records = vec![bytemuck::Zeroable::zeroed(); maps.depth_or_array_layers() as usize];
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let lights = gpu::buffer(device, "lookup::lights", size_of_val(&records[..]) as u64, usage);
        let view = maps.create_view(&wgpu::TextureViewDescriptor {
            label: Some("dual_paraboloid::lookup::maps"),
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("dual_paraboloid::lookup::gather"),
            ..Default::default()
        });
        let resources = [
            wgpu::BindingResource::TextureView(&view),
            wgpu::BindingResource::Sampler(&sampler),
            lights.as_entire_binding(),
        ];
        let group = gpu::bind_group(device, "lookup", &layout, &resources);
        Self { layout, group, lights, records, changed: false }
    }

    pub(crate) fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    pub(crate) fn bind_group(&self) -> &wgpu::BindGroup {
        &self.group
    }

    /// The lights' records.
    #[cfg(feature = "compare")]
    pub(crate) fn lights(&self) -> &wgpu::Buffer {
        &self.lights
    }

    /// Describes the light of a layer, or that there is none any more.
    pub(crate) fn set(&mut self, layer: u32, light: Option<&PointLight>, shape: &MapShape, normal_bias: f32) {
        let record =
            light.map_or(bytemuck::Zeroable::zeroed(), |light| LightRecord::new(light, shape, layer, normal_bias));
        let place = &mut self.records[layer as usize];
        self.changed |= *place != record;
        *place = record;
    }

    /// Changes the filter of a layer's light.
    pub(crate) fn set_filter(&mut self, layer: u32, light: &PointLight) {
        self.records[layer as usize].filtering = light.filter.record();
        self.changed = true;
    }

    /// Brings the GPU's copy up to date, in one write.
    pub(crate) fn write(&mut self, queue: &wgpu::Queue) {
        if std::mem::take(&mut self.changed) {
            queue.write_buffer(&self.lights, 0, bytemuck::cast_slice(&self.records));
        }
    }

    pub(crate) fn memory(&self) -> u64 {
        self.lights.size()
    }
}

impl LightRecord {
    fn new(light: &PointLight, shape: &MapShape, layer: u32, normal_bias: f32) -> Self {
        let [right, up, forward] = axes(light.orientation);
        Self {
            right,
            near: light.near,
            up,
            range: light.range,
            forward,
            texels: shape.texels(),
            position: light.position,
            hemispheres: hemispheres(light.coverage),
            origin: Vec2::ZERO,
            resolution: shape.resolution as f32,
            layer,
            normal_bias,
            filtering: light.filter.record(),
        }
    }
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    let maps = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2Array,
        multisampled: false,
    };
    let lights = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: true },
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering);
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("dual_paraboloid::lookup"),
        entries: &[entry(0, maps), entry(1, sampler), entry(2, lights)],
    })
}
