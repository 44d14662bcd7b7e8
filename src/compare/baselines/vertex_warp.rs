//! The paraboloid pair as published and as engines ship it (`shaders/compare/vertex_warp.wgsl`).

use super::cube::in_range;
use super::cube_lookup::{READ_ONLY_STORAGE, comparison_sampler, depth_texture, lookup_entry};
use super::culling::OrientedBox;
use super::instanced::{InstancedDraws, PassKind};
use super::lookup::{Bias, Lookup};
use super::scene_buffers::SceneBuffers;
use super::wide_map;
use crate::gpu;
use crate::light::PointLight;
use crate::view::axes;
use glam::Vec3;

pub(super) const SHADER: &str = include_str!("../../../shaders/compare/vertex_warp.wgsl");
const LOOKUP: &str = include_str!("../../../shaders/compare/vertex_warp_lookup.wgsl");

/// The lookup's text, for the bind group number `group`.
pub(super) fn lookup_text(group: u32) -> String {
    LOOKUP.replace("WARP_GROUP", &group.to_string())
}

/// One hemisphere as the pass sees it; twin of `WarpView`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
struct WarpView {
    right: Vec3,
    range: f32,
    up: Vec3,
    padding_0: u32,
    forward: Vec3,
    padding_1: u32,
    origin: Vec3,
    padding_2: u32,
}

impl WarpView {
    fn new(light: &PointLight, back: bool) -> Self {
        let [right, up, forward] = axes(light.orientation);
        let turn = if back { -1.0 } else { 1.0 };
        Self {
            right: right * turn,
            range: light.range,
            up,
            padding_0: 0,
            forward: forward * turn,
            padding_1: 0,
            origin: light.position,
            padding_2: 0,
        }
    }

    fn sees(&self, bounds: &OrientedBox) -> bool {
        bounds.touches_half_space(self.origin, self.forward, 0.0)
    }
}

/// A light as the lookup reads it; twin of `WarpLight`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
struct WarpRecord {
    right: Vec3,
    range: f32,
    up: Vec3,
    depth_bias: f32,
    forward: Vec3,
    normal_bias: f32,
    position: Vec3,
    padding: u32,
}

impl WarpRecord {
    fn new(light: &PointLight, bias: Bias) -> Self {
        let [right, up, forward] = axes(light.orientation);
        Self {
            right,
            range: light.range,
            up,
            depth_bias: bias.depth,
            forward,
            normal_bias: bias.normal,
            position: light.position,
            padding: 0,
        }
    }
}

/// A pair of maps from warped vertices: one pass, two viewports, instances culled by hemisphere. Always both
/// hemispheres, whatever the light's coverage.
#[derive(Debug)]
pub struct VertexWarp {
    map: wgpu::Texture,
    target: wgpu::TextureView,
    draws: InstancedDraws,
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    light: wgpu::Buffer,
    record: WarpRecord,
}

impl VertexWarp {
    /// Creates a pair of maps of `resolution` texels across each.
    #[must_use]
    pub fn new(device: &wgpu::Device, resolution: u32) -> Self {
        let map = wide_map(device, resolution);
        let target = map.create_view(&wgpu::TextureViewDescriptor::default());
        let layout = lookup_layout(device);
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let light = gpu::buffer(device, "compare::warp_light", size_of::<WarpRecord>() as u64, usage);
        let resources = [
            wgpu::BindingResource::TextureView(&target),
            wgpu::BindingResource::Sampler(&comparison_sampler(device)),
            light.as_entire_binding(),
        ];
        let bias = Lookup::VertexWarp.default_bias().unwrap_or_default();
        Self {
            draws: InstancedDraws::new(device, PassKind::VertexWarp, map.format(), 2, size_of::<WarpView>() as u64),
            group: gpu::bind_group(device, "compare::vertex_warp", &layout, &resources),
            map,
            target,
            layout,
            light,
            record: WarpRecord::new(&PointLight::default(), bias),
        }
    }

    /// Records both maps anew.
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneBuffers,
        light: &PointLight,
    ) {
        let views = [false, true].map(|back| WarpView::new(light, back));
        let reached = in_range(scene, light);
        self.draws.clear();
        for view in &views {
            let seen = |place: &u32| view.sees(&scene.placed()[*place as usize].bounds);
            self.draws.add_list(scene, reached.iter().copied().filter(seen));
        }
        self.draws.upload(device, queue, &views);
        let size = self.map.height() as f32;
        let mut pass = self.draws.begin(encoder, &self.target);
        for hemisphere in 0..2 {
            pass.set_viewport(size * hemisphere as f32, 0.0, size, size, 0.0, 1.0);
            self.draws.draw(&mut pass, scene, hemisphere, hemisphere);
        }
        drop(pass);
        self.record = WarpRecord::new(light, self.bias());
        self.write(queue);
    }

    /// Sets the bias of [`Lookup::VertexWarp`].
    pub(super) fn set_bias(&mut self, queue: &wgpu::Queue, bias: Bias) {
        (self.record.depth_bias, self.record.normal_bias) = (bias.depth, bias.normal);
        self.write(queue);
    }

    fn bias(&self) -> Bias {
        Bias { depth: self.record.depth_bias, normal: self.record.normal_bias, ..Bias::default() }
    }

    fn write(&self, queue: &wgpu::Queue) {
        queue.write_buffer(&self.light, 0, bytemuck::bytes_of(&self.record));
    }

    /// The pair, the front hemisphere in the left half. The depth is 1 less the distance over the range.
    #[must_use]
    pub fn map(&self) -> &wgpu::Texture {
        &self.map
    }

    pub(super) fn bind_group(&self) -> (&wgpu::BindGroup, &wgpu::BindGroupLayout) {
        (&self.group, &self.layout)
    }

    /// Bytes on the GPU beside the map.
    pub(super) fn working_memory(&self) -> u64 {
        self.draws.memory() + self.light.size()
    }
}

fn lookup_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("dual_paraboloid::compare::vertex_warp"),
        entries: &[
            lookup_entry(0, depth_texture(wgpu::TextureViewDimension::D2)),
            lookup_entry(1, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)),
            lookup_entry(2, READ_ONLY_STORAGE),
        ],
    })
}
