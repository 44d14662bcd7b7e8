//! What the lookups in a cube bind (`shaders/compare/cube_lookup.wgsl`).

use super::cube_map::CubeMap;
use super::lookup::ConstantBias;
use crate::gpu;
use crate::light::PointLight;
use glam::Vec3;
use std::f32::consts::SQRT_2;

const SHADER: &str = include_str!("../../../shaders/compare/cube_lookup.wgsl");

/// The lookups' text, for the bind group number `group`.
pub(super) fn text(group: u32) -> String {
    SHADER.replace("CUBE_GROUP", &group.to_string())
}

/// A light as the lookups read it; twin of `CubeLight`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
struct CubeRecord {
    position: Vec3,
    near: f32,
    range: f32,
    depth_bias: f32,
    normal_bias: f32,
    texel: f32,
}

#[derive(Debug)]
pub(super) struct CubeLookup {
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    light: wgpu::Buffer,
    resolution: u32,
}

impl CubeLookup {
    pub(super) fn new(device: &wgpu::Device, map: &CubeMap) -> Self {
        let layout = layout(device);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let light = gpu::buffer(device, "compare::cube_light", size_of::<CubeRecord>() as u64, usage);
        let view = |dimension| {
            map.texture().create_view(&wgpu::TextureViewDescriptor {
                label: Some("dual_paraboloid::compare::cube_lookup"),
                dimension: Some(dimension),
                ..Default::default()
            })
        };
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("dual_paraboloid::compare::cube_lookup"),
            ..Default::default()
        });
        let resources = [
            wgpu::BindingResource::TextureView(&view(wgpu::TextureViewDimension::Cube)),
            wgpu::BindingResource::TextureView(&view(wgpu::TextureViewDimension::D2Array)),
            wgpu::BindingResource::Sampler(&comparison_sampler(device)),
            wgpu::BindingResource::Sampler(&sampler),
            light.as_entire_binding(),
        ];
        Self {
            group: gpu::bind_group(device, "compare::cube_lookup", &layout, &resources),
            layout,
            light,
            resolution: map.resolution(),
        }
    }

    pub(super) fn bind_group(&self) -> (&wgpu::BindGroup, &wgpu::BindGroupLayout) {
        (&self.group, &self.layout)
    }

    pub(super) fn write(&self, queue: &wgpu::Queue, light: &PointLight, bias: ConstantBias) {
        let texel = 2.0 / self.resolution as f32;
        let record = CubeRecord {
            position: light.position,
            near: light.near,
            range: light.range,
            depth_bias: bias.depth,
            normal_bias: bias.normal * texel * SQRT_2,
            texel,
        };
        queue.write_buffer(&self.light, 0, bytemuck::bytes_of(&record));
    }
}

/// Weighs four comparisons: 1 where the reference is as near to the light as what is stored, or nearer.
pub(super) fn comparison_sampler(device: &wgpu::Device) -> wgpu::Sampler {
    device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("dual_paraboloid::compare::comparison"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        compare: Some(wgpu::CompareFunction::GreaterEqual),
        ..Default::default()
    })
}

/// A binding for passes that look shadows up.
pub(super) fn lookup_entry(binding: u32, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    }
}

pub(super) fn depth_texture(view_dimension: wgpu::TextureViewDimension) -> wgpu::BindingType {
    wgpu::BindingType::Texture { sample_type: wgpu::TextureSampleType::Depth, view_dimension, multisampled: false }
}

pub(super) const READ_ONLY_STORAGE: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Storage { read_only: true },
    has_dynamic_offset: false,
    min_binding_size: None,
};

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let sampler = wgpu::BindingType::Sampler;
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("dual_paraboloid::compare::cube_lookup"),
        entries: &[
            lookup_entry(0, depth_texture(wgpu::TextureViewDimension::Cube)),
            lookup_entry(1, depth_texture(wgpu::TextureViewDimension::D2Array)),
            lookup_entry(2, sampler(wgpu::SamplerBindingType::Comparison)),
            lookup_entry(3, sampler(wgpu::SamplerBindingType::NonFiltering)),
            lookup_entry(4, READ_ONLY_STORAGE),
        ],
    })
}
