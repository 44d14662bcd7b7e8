//! What the lookups in a cube bind (`shaders/compare/cube_lookup.wgsl`).

use super::cube_map::{CubeDepth, CubeMap, DepthMapping, half_width};
use super::lookup::{Bias, Lookup};
use crate::gpu;
use crate::light::PointLight;
use crate::view::axes;
use glam::Vec3;

const SHADER: &str = concat!(
    include_str!("../../../shaders/compare/cube_face.wgsl"),
    include_str!("../../../shaders/compare/cube_lookup.wgsl"),
);

/// The lookups' text, for the bind group number `group` and for lights with an orientation or only without.
pub(super) fn text(group: u32, turned: bool) -> String {
    SHADER.replace("CUBE_GROUP", &group.to_string()).replace("CUBE_TURNED", &turned.to_string())
}

/// A light as the lookups read it; twin of `CubeLight`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
struct CubeRecord {
    right: Vec3,
    range: f32,
    up: Vec3,
    half_width: f32,
    forward: Vec3,
    texel: f32,
    position: Vec3,
    depth_scale: f32,
    depth_offset: f32,
    depth_bias: f32,
    normal_bias: f32,
    plane_ray_bias: f32,
    plane_normal_bias: f32,
    padding: [u32; 3],
}

#[derive(Debug)]
pub(super) struct CubeLookup {
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    light: wgpu::Buffer,
    record: CubeRecord,
}

impl CubeLookup {
    /// Reads the faces, which are the layers of a texture. Of floats that aren't depth [`Lookup::CubePlane`] alone reads
    /// anything.
    pub(super) fn new(device: &wgpu::Device, faces: &wgpu::Texture) -> Self {
        let layout = layout(device);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let light = gpu::buffer(device, "compare::cube_light", size_of::<CubeRecord>() as u64, usage);
        let view = |texture: &wgpu::Texture, dimension| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                label: Some("dual_paraboloid::compare::cube_lookup"),
                dimension: Some(dimension),
                ..Default::default()
            })
        };
        let is_depth = faces.format().is_depth_stencil_format();
        let placeholder = (!is_depth).then(|| CubeMap::new(device, 1, CubeDepth::Float32));
        let cube = placeholder.as_ref().map_or(faces, CubeMap::texture);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("dual_paraboloid::compare::cube_lookup"),
            ..Default::default()
        });
        let resources = [
            wgpu::BindingResource::TextureView(&view(cube, wgpu::TextureViewDimension::Cube)),
            wgpu::BindingResource::TextureView(&view(faces, wgpu::TextureViewDimension::D2Array)),
            wgpu::BindingResource::Sampler(&comparison_sampler(device)),
            wgpu::BindingResource::Sampler(&sampler),
            light.as_entire_binding(),
        ];
        let mut record = CubeRecord {
            half_width: half_width(faces.width()),
            texel: 2.0 * half_width(faces.width()) / faces.width() as f32,
            ..bytemuck::Zeroable::zeroed()
        };
        for lookup in [Lookup::CubeHardware, Lookup::CubePlane] {
            record.set_bias(lookup, lookup.default_bias().unwrap_or_default());
        }
        Self { group: gpu::bind_group(device, "compare::cube_lookup", &layout, &resources), layout, light, record }
    }

    pub(super) fn bind_group(&self) -> (&wgpu::BindGroup, &wgpu::BindGroupLayout) {
        (&self.group, &self.layout)
    }

    /// Bytes on the GPU.
    pub(super) fn memory(&self) -> u64 {
        self.light.size()
    }

    /// Describes the light that the map was made of.
    pub(super) fn set_light(&mut self, queue: &wgpu::Queue, light: &PointLight, depth: DepthMapping) {
        let [right, up, forward] = axes(light.orientation);
        self.record = CubeRecord {
            right,
            range: light.range,
            up,
            forward,
            position: light.position,
            depth_scale: depth.scale,
            depth_offset: depth.offset,
            ..self.record
        };
        self.write(queue);
    }

    /// Sets the bias of one lookup.
    pub(super) fn set_bias(&mut self, queue: &wgpu::Queue, lookup: Lookup, bias: Bias) {
        self.record.set_bias(lookup, bias);
        self.write(queue);
    }

    fn write(&self, queue: &wgpu::Queue) {
        queue.write_buffer(&self.light, 0, bytemuck::bytes_of(&self.record));
    }
}

impl CubeRecord {
    fn set_bias(&mut self, lookup: Lookup, bias: Bias) {
        match lookup {
            Lookup::CubeHardware => (self.depth_bias, self.normal_bias) = (bias.depth, bias.normal),
            Lookup::CubePlane => (self.plane_ray_bias, self.plane_normal_bias) = (bias.ray, bias.normal),
            _ => {}
        }
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

/// Faces as layers, whether they are depth or not.
const FLOATS: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: false },
    view_dimension: wgpu::TextureViewDimension::D2Array,
    multisampled: false,
};

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let sampler = wgpu::BindingType::Sampler;
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("dual_paraboloid::compare::cube_lookup"),
        entries: &[
            lookup_entry(0, depth_texture(wgpu::TextureViewDimension::Cube)),
            lookup_entry(1, FLOATS),
            lookup_entry(2, sampler(wgpu::SamplerBindingType::Comparison)),
            lookup_entry(3, sampler(wgpu::SamplerBindingType::NonFiltering)),
            lookup_entry(4, READ_ONLY_STORAGE),
        ],
    })
}
