//! `shaders/walk.wgsl` on the device.

use crate::compare::gpu::{Evaluator, Gpu, evaluation};
use crate::maps::array_view;
use crate::{Casters, LightId, PointShadows, gpu, wgsl};
use glam::Vec3;

/// The maps and the casters that they show, bound for lookups that walk.
#[derive(Debug)]
pub struct WalkGroup {
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
}

impl WalkGroup {
    /// For maps and casters as they are after a recording of these casters.
    #[must_use]
    pub fn new(gpu: &Gpu, shadows: &PointShadows, casters: &Casters) -> Self {
        let device = &gpu.device;
        let texture = |sample_type| wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2Array,
            multisampled: false,
        };
        let storage = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let types = [
            texture(wgpu::TextureSampleType::Float { filterable: false }),
            wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering),
            storage,
            texture(wgpu::TextureSampleType::Uint),
            storage,
            storage,
            storage,
            storage,
        ];
        let visibility = wgpu::ShaderStages::FRAGMENT | wgpu::ShaderStages::COMPUTE;
        let layout = gpu::layout_of(device, "compare::walk", visibility, &types);
        let [depths, numbers] = [shadows.maps(), shadows.numbers()].map(array_view);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor::default());
        let mut resources = vec![
            wgpu::BindingResource::TextureView(&depths),
            wgpu::BindingResource::Sampler(&sampler),
            shadows.light_records().as_entire_binding(),
            wgpu::BindingResource::TextureView(&numbers),
        ];
        let arenas = [&casters.chunk_sources, &casters.triangles, &casters.neighbours, &casters.vertices];
        resources.extend(arenas.map(|arena| arena.buffer().as_entire_binding()));
        let group = gpu::bind_group(device, "compare::walk", &layout, &resources);
        Self { layout, group }
    }

    /// What a WGSL expression over `position` and `normal` gives at each receiver, `LIGHT` in it being the light's index.
    #[must_use]
    pub fn values(&self, gpu: &Gpu, light: LightId, expression: &str, receivers: &[(Vec3, Vec3)]) -> Vec<f32> {
        self.evaluator(gpu, light, expression, receivers).values(gpu, &[&self.group])
    }

    /// [`Self::values`] to be asked for again and again, with [`Self::bind_group`].
    #[must_use]
    pub fn evaluator(&self, gpu: &Gpu, light: LightId, expression: &str, receivers: &[(Vec3, Vec3)]) -> Evaluator {
        let expression = expression.replace("LIGHT", &format!("{}u", light.index()));
        gpu.evaluator(&[wgsl::walk(0), evaluation(&expression)].concat(), &[&self.layout], receivers)
    }

    /// What the lookup and the walk read.
    #[must_use]
    pub fn bind_group(&self) -> &wgpu::BindGroup {
        &self.group
    }

    /// What `dp_walk_shadow` says of each receiver.
    #[must_use]
    pub fn shadow_values(&self, gpu: &Gpu, light: LightId, receivers: &[(Vec3, Vec3)]) -> Vec<f32> {
        self.values(gpu, light, "dp_walk_shadow(LIGHT, position, normal)", receivers)
    }
}
