//! The rasterise stage: each texel's greatest depth and the triangle that has it (`shaders/rasterise.wgsl`).

use crate::batch::MOST_ITEMS;
use crate::gpu::{self, Workgroups};
use crate::maps::{self, Maps, Target};
use crate::view::{MapShape, SLOT, View};
use crate::workspace::Workspace;

/// So few tiles leave much of a GPU idle.
const FEW_TILES: u32 = 4096;

#[derive(Debug)]
pub(crate) struct Rasterise {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    /// Textures of one texel, for what a batch doesn't start from.
    nothing: Nothing,
}

#[derive(Debug)]
struct Nothing {
    depths: wgpu::TextureView,
    numbers: wgpu::TextureView,
    custom: wgpu::TextureView,
}

impl Rasterise {
    /// With lists of `room` entries a tile.
    pub(crate) fn new(device: &wgpu::Device, shape: &MapShape, workgroups: Workgroups, room: u32) -> Self {
        let layout = layout(device);
        let module = gpu::shader(device, "rasterise", crate::wgsl::rasterise(shape.projection, workgroups.pairs()));
        let flag = |value: bool| f64::from(u8::from(value));
        let constants = [
            ("ROOM", f64::from(room)),
            ("BATCHED", flag(workgroups.has_cheap_barriers())),
            ("IN_FOURS", flag(shape.all_tiles() <= FEW_TILES)),
        ];
        let pipeline = gpu::compute_pipeline(device, "rasterise", &module, &[&layout], &constants);
        let nothing = |format| {
            let usage = wgpu::TextureUsages::TEXTURE_BINDING;
            maps::array_view(&maps::texture(device, "nothing", [1, 1, 1], format, usage))
        };
        let nothing = Nothing {
            depths: nothing(maps::DEPTHS),
            numbers: nothing(maps::NUMBERS),
            custom: nothing(wgpu::TextureFormat::Depth32Float),
        };
        Self { pipeline, layout, nothing }
    }

    /// For maps of `target`, with what the caller has drawn, if it has.
    pub(crate) fn bind_group(
        &self,
        device: &wgpu::Device,
        views: &wgpu::Buffer,
        workspace: &Workspace,
        maps: &Maps,
        target: Target,
        custom: Option<&wgpu::TextureView>,
    ) -> wgpu::BindGroup {
        let Workspace { records, state, lists, depths, numbers, .. } = workspace;
        let buffers = [records, state, lists, depths, numbers];
        let [map_depths, map_numbers] = maps.views(target);
        // The static casters' maps are made from nothing.
        let [static_depths, static_numbers] = match target {
            Target::Live if maps.keep_static() => maps.views(Target::Static),
            _ => [&self.nothing.depths, &self.nothing.numbers],
        };
        let mut resources = vec![gpu::dynamic(views, u64::from(MOST_ITEMS) * SLOT)];
        resources.extend(buffers.map(wgpu::Buffer::as_entire_binding));
        let textures = [map_depths, map_numbers, static_depths, static_numbers, custom.unwrap_or(&self.nothing.custom)];
        resources.extend(textures.map(wgpu::BindingResource::TextureView));
        gpu::bind_group(device, "rasterise", &self.layout, &resources)
    }

    /// Records a batch of `items` items with maps of a shape, of which `first` is the first of the recording.
    pub(crate) fn record(
        &self,
        pass: &mut wgpu::ComputePass,
        group: &wgpu::BindGroup,
        first: u32,
        items: u32,
        shape: &MapShape,
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[first * SLOT as u32]);
        pass.dispatch_workgroups(shape.tiles(), shape.tiles(), shape.projection.squares * items);
    }
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    use wgpu::{BindingType, BufferBindingType, TextureSampleType, TextureViewDimension::D2Array};
    let buffer = |ty, has_dynamic_offset| BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None };
    let storage = |read_only| buffer(BufferBindingType::Storage { read_only }, false);
    let map = |format| BindingType::StorageTexture {
        access: wgpu::StorageTextureAccess::WriteOnly,
        format,
        view_dimension: D2Array,
    };
    let read = |sample_type| BindingType::Texture { sample_type, view_dimension: D2Array, multisampled: false };
    let types = [
        buffer(BufferBindingType::Uniform, true),
        storage(true),
        storage(false),
        storage(true),
        storage(false),
        storage(false),
        map(maps::DEPTHS),
        map(maps::NUMBERS),
        read(TextureSampleType::Float { filterable: false }),
        read(TextureSampleType::Uint),
        read(TextureSampleType::Depth),
    ];
    gpu::layout_of(device, "rasterise", wgpu::ShaderStages::COMPUTE, &types)
}

const _: () = assert!(size_of::<View>() as u64 == SLOT);
