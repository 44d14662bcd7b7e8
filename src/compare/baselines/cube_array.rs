//! Hardware cubes of several lights in one texture (`shaders/compare/cube_array.wgsl`).

use super::cube_lookup::{READ_ONLY_STORAGE, comparison_sampler, depth_texture, lookup_entry};
use super::cube_map::half_width;
use super::lookup::Lookup;
use super::{Baseline, BaselineError, Bound, DeviceScene, Method};
use crate::compare::gpu::Gpu;
use crate::gpu;
use crate::light::PointLight;
use glam::{Quat, Vec3};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// A light as the lookup reads it; twin of `CubeArrayLight`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
struct ArrayRecord {
    position: Vec3,
    range: f32,
    half_width: f32,
    texel: f32,
    depth_scale: f32,
    depth_bias: f32,
    normal_bias: f32,
    padding: [u32; 3],
}

/// [`Method::Cube`] of several lights, for [`Lookup::CubeHardware`] with its default bias.
#[derive(Debug)]
pub(in crate::compare) struct CubeArray {
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
}

/// The text of `cube_array_shadow(light, position, normal)`, for the bind group number `group`.
pub(in crate::compare) fn text(group: u32) -> String {
    include_str!("../../../shaders/compare/cube_array.wgsl").replace("CUBE_GROUP", &group.to_string())
}

impl CubeArray {
    /// Records the maps of all lights, of `side` texels across a face, along the world's axes.
    pub(in crate::compare) fn new(
        gpu: &Gpu,
        scene: &mut DeviceScene,
        lights: &[PointLight],
        side: u32,
    ) -> Result<Self, BaselineError> {
        let device = &gpu.device;
        let mut one = Baseline::new(device, Method::Cube, side)?;
        let all = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("dual_paraboloid::compare::cube_array"),
            size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 6 * lights.len() as u32 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: one.map().format(),
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for (light, number) in lights.iter().zip(0..) {
            let light = PointLight { orientation: Quat::IDENTITY, ..*light };
            gpu.submit(|encoder| {
                one.record(device, &gpu.queue, encoder, scene, &light)?;
                let copy = |texture, z| wgpu::TexelCopyTextureInfo {
                    texture,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x: 0, y: 0, z },
                    aspect: wgpu::TextureAspect::All,
                };
                encoder.copy_texture_to_texture(copy(one.map(), 0), copy(&all, 6 * number), one.map().size());
                Ok::<(), BaselineError>(())
            })?;
        }
        let bias = Lookup::CubeHardware.default_bias().unwrap_or_default();
        let record = |light: &PointLight| ArrayRecord {
            position: light.position,
            range: light.range,
            half_width: half_width(side),
            texel: 2.0 * half_width(side) / side as f32,
            depth_scale: light.near,
            depth_bias: bias.depth,
            normal_bias: bias.normal,
            padding: [0; 3],
        };
        let records: Vec<ArrayRecord> = lights.iter().map(record).collect();
        let records = device.create_buffer_init(&BufferInitDescriptor {
            label: Some("dual_paraboloid::compare::cube_array"),
            contents: bytemuck::cast_slice(&records),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let view = all.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::CubeArray),
            ..Default::default()
        });
        let resources = [
            wgpu::BindingResource::TextureView(&view),
            wgpu::BindingResource::Sampler(&comparison_sampler(device)),
            records.as_entire_binding(),
        ];
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("dual_paraboloid::compare::cube_array"),
            entries: &[
                lookup_entry(0, depth_texture(wgpu::TextureViewDimension::CubeArray)),
                lookup_entry(1, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)),
                lookup_entry(2, READ_ONLY_STORAGE),
            ],
        });
        Ok(Self { group: gpu::bind_group(device, "compare::cube_array", &layout, &resources), layout })
    }

    pub(in crate::compare) fn bind_group(&self) -> Bound<'_> {
        (Some(&self.group), &self.layout)
    }
}
