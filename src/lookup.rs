//! What the lighting pass binds: the maps, the lights as they were when their maps were made, and the casters' triangles
//! (`shaders/lookup.wgsl`, `shaders/exact.wgsl`, `shaders/filter.wgsl`).

use crate::arena::Arena;
use crate::filter::FilterRecord;
use crate::gpu;
use crate::light::PointLight;
use crate::maps::{Maps, Target};
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
    receiver_offset: f32,
    /// Number of the casters' update that the map shows; 0 for none.
    made: u32,
    filtering: FilterRecord,
    padding: [u32; 2],
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
    /// For all layers of `maps`, depths and numbers, one of each a light.
    pub(crate) fn new(device: &wgpu::Device, maps: &Maps) -> Self {
        let layout = layout(device);
        let records = vec![bytemuck::Zeroable::zeroed(); maps.depths().depth_or_array_layers() as usize];
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let lights = gpu::buffer(device, "lookup::lights", size_of_val(&records[..]) as u64, usage);
        let [depths, numbers] = maps.views(Target::Live);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("dual_paraboloid::lookup::gather"),
            ..Default::default()
        });
        let resources = [
            wgpu::BindingResource::TextureView(depths),
            wgpu::BindingResource::Sampler(&sampler),
            lights.as_entire_binding(),
            wgpu::BindingResource::TextureView(numbers),
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

    /// Describes the light of a layer, whose map shows the casters' update number `made`.
    pub(crate) fn set(&mut self, layer: u32, light: &PointLight, shape: &MapShape, normal_bias: f32, made: u32) {
        self.records[layer as usize] = LightRecord::new(light, shape, layer, normal_bias, made);
        self.changed = true;
    }

    /// There is no light in a layer any more.
    pub(crate) fn remove(&mut self, layer: u32) {
        self.records[layer as usize].hemispheres = 0;
        self.changed = true;
    }

    /// No map shows these casters: their triangles aren't to be asked.
    pub(crate) fn forget_casters(&mut self) {
        self.records.iter_mut().for_each(|record| record.made = 0);
        self.changed = true;
    }

    /// Changes what lookups alone need of a layer's light.
    pub(crate) fn set_reading(&mut self, layer: u32, light: &PointLight) {
        let record = &mut self.records[layer as usize];
        record.filtering = light.filter.record();
        record.receiver_offset = light.receiver_offset;
        self.changed = true;
    }

    /// The GPU's copy may lack what was written to it.
    pub(crate) fn write_again(&mut self) {
        self.changed = true;
    }

    /// Brings the GPU's copy up to date, in one write.
    pub(crate) fn write(&mut self, device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder) {
        if std::mem::take(&mut self.changed) {
            gpu::write(device, encoder, &self.lights, bytemuck::cast_slice(&self.records));
        }
    }

    pub(crate) fn memory(&self) -> u64 {
        self.lights.size()
    }
}

impl LightRecord {
    fn new(light: &PointLight, shape: &MapShape, layer: u32, normal_bias: f32, made: u32) -> Self {
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
            receiver_offset: light.receiver_offset,
            made,
            filtering: light.filter.record(),
            padding: [0; 2],
        }
    }
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let texture = |sample_type| wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2Array,
        multisampled: false,
    };
    let types = [
        texture(wgpu::TextureSampleType::Float { filterable: false }),
        wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering),
        STORAGE,
        texture(wgpu::TextureSampleType::Uint),
    ];
    gpu::layout_of(device, "lookup", READERS, &types)
}

/// Stages that may look shadows up.
const READERS: wgpu::ShaderStages = wgpu::ShaderStages::VERTEX_FRAGMENT.union(wgpu::ShaderStages::COMPUTE);

const STORAGE: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Storage { read_only: true },
    has_dynamic_offset: false,
    min_binding_size: None,
};

/// The casters' triangles as lookups read them: chunks, mesh records and vertices.
#[derive(Debug)]
pub(crate) struct SurfaceGroup {
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    /// The arenas' generations together: which of their buffers the group has.
    generation: u64,
}

impl SurfaceGroup {
    pub(crate) fn new(device: &wgpu::Device, arenas: [&Arena; 3]) -> Self {
        let layout = surface_layout(device);
        Self { group: surface_group(device, &layout, arenas), layout, generation: 0 }
    }

    /// Binds the arenas' buffers if they were replaced.
    pub(crate) fn update(&mut self, device: &wgpu::Device, arenas: [&Arena; 3]) {
        let generation = arenas.map(Arena::generation).into_iter().sum();
        if self.generation != generation {
            self.generation = generation;
            self.group = surface_group(device, &self.layout, arenas);
        }
    }

    pub(crate) fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    pub(crate) fn bind_group(&self) -> &wgpu::BindGroup {
        &self.group
    }
}

/// The layout of a [`SurfaceGroup`].
pub(crate) fn surface_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    gpu::layout_of(device, "lookup::surface", READERS, &[STORAGE; 3])
}

fn surface_group(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, arenas: [&Arena; 3]) -> wgpu::BindGroup {
    let resources = arenas.map(|arena| arena.buffer().as_entire_binding());
    gpu::bind_group(device, "lookup::surface", layout, &resources)
}
