//! Cube maps from instanced draws: culled by face, not culled at all, or in one multiview pass.

use super::cube_lookup::CubeLookup;
use super::cube_map::{CubeDepth, CubeMap, DepthMapping, FACES};
use super::instanced::{InstancedDraws, InstancedView, PassKind};
use super::scene_buffers::SceneBuffers;
use crate::light::PointLight;

/// Which instances each face of a [`Cube`] draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Culling {
    /// Those whose box touches the light's range and the face's frustum.
    Frustum,
    /// All.
    None,
}

/// Six passes into a cube map along the light's axes, as engines record them. Always all directions, whatever the
/// light's coverage.
#[derive(Debug)]
pub struct Cube {
    culling: Culling,
    map: CubeMap,
    draws: InstancedDraws,
    lookup: CubeLookup,
    nearest: f32,
}

impl Cube {
    /// Creates a cube map of `resolution` texels across a face.
    #[must_use]
    pub fn new(device: &wgpu::Device, resolution: u32, culling: Culling, depth: CubeDepth) -> Self {
        let map = CubeMap::new(device, resolution, depth);
        let view_size = size_of::<InstancedView>() as u64;
        Self {
            culling,
            draws: InstancedDraws::new(device, PassKind::OneView, depth.format(), 6, view_size),
            lookup: CubeLookup::new(device, map.texture()),
            map,
            nearest: 0.0,
        }
    }

    /// Says that no surface is nearer to the light than `nearest`, in world units: [`CubeDepth::Unorm16`] puts its near
    /// plane there, from the next recording on. Otherwise it is the light's.
    pub fn set_nearest(&mut self, nearest: f32) {
        self.nearest = nearest;
    }

    /// Records the whole map anew.
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneBuffers,
        light: &PointLight,
    ) {
        let half_width = self.map.half_width();
        let depth = DepthMapping::new(self.map.depth(), light, self.nearest, half_width);
        self.list(scene, light, depth.near);
        self.draws.upload(device, queue, &FACES.map(|face| face.view(light, half_width, depth)));
        for (face, target) in self.map.faces().iter().enumerate() {
            let mut pass = self.draws.begin(encoder, target);
            let list = if self.culling == Culling::None { 0 } else { face };
            self.draws.draw(&mut pass, scene, face, list);
        }
        self.lookup.set_light(queue, light, depth);
    }

    /// Lists what each face draws: one list for all faces without culling.
    fn list(&mut self, scene: &SceneBuffers, light: &PointLight, near: f32) {
        self.draws.clear();
        if self.culling == Culling::None {
            self.draws.add_all(scene);
            return;
        }
        let reached = in_range(scene, light);
        let half_width = self.map.half_width();
        for face in FACES {
            let seen = |place: &u32| face.sees(light, half_width, near, &scene.placed()[*place as usize].bounds);
            self.draws.add_list(scene, reached.iter().copied().filter(seen));
        }
    }

    /// The cube texture.
    #[must_use]
    pub fn map(&self) -> &wgpu::Texture {
        self.map.texture()
    }

    pub(super) fn lookup(&self) -> &CubeLookup {
        &self.lookup
    }

    pub(super) fn lookup_mut(&mut self) -> &mut CubeLookup {
        &mut self.lookup
    }

    /// Bytes on the GPU beside the map.
    pub(super) fn working_memory(&self) -> u64 {
        self.draws.memory() + self.lookup.memory()
    }
}

/// One pass over all faces of a cube map, with each instance in the light's range drawn once. Always all directions,
/// whatever the light's coverage.
#[derive(Debug)]
pub struct CubeMultiview {
    map: CubeMap,
    target: wgpu::TextureView,
    draws: InstancedDraws,
    lookup: CubeLookup,
}

impl CubeMultiview {
    /// Whether the device was made with [`wgpu::Features::MULTIVIEW`] over six layers or more.
    #[must_use]
    pub fn is_supported(device: &wgpu::Device) -> bool {
        let views = device.limits().max_multiview_view_count;
        device.features().contains(wgpu::Features::MULTIVIEW) && views >= FACES.len() as u32
    }

    /// Creates a cube map of `resolution` texels across a face; `None` where it isn't [supported](Self::is_supported).
    #[must_use]
    pub fn new(device: &wgpu::Device, resolution: u32) -> Option<Self> {
        if !Self::is_supported(device) {
            return None;
        }
        let map = CubeMap::new(device, resolution, CubeDepth::Float32);
        let view_size = size_of::<[InstancedView; FACES.len()]>() as u64;
        Some(Self {
            target: map.all_faces(),
            draws: InstancedDraws::new(device, PassKind::SixViews, map.depth().format(), 1, view_size),
            lookup: CubeLookup::new(device, map.texture()),
            map,
        })
    }

    /// Records the whole map anew.
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneBuffers,
        light: &PointLight,
    ) {
        let depth = DepthMapping::infinite(light.near);
        self.draws.clear();
        self.draws.add_list(scene, in_range(scene, light).into_iter());
        self.draws.upload(device, queue, &[FACES.map(|face| face.view(light, self.map.half_width(), depth))]);
        let mut pass = self.draws.begin(encoder, &self.target);
        self.draws.draw(&mut pass, scene, 0, 0);
        drop(pass);
        self.lookup.set_light(queue, light, depth);
    }

    /// The cube texture.
    #[must_use]
    pub fn map(&self) -> &wgpu::Texture {
        self.map.texture()
    }

    pub(super) fn lookup(&self) -> &CubeLookup {
        &self.lookup
    }

    pub(super) fn lookup_mut(&mut self) -> &mut CubeLookup {
        &mut self.lookup
    }

    /// Bytes on the GPU beside the map.
    pub(super) fn working_memory(&self) -> u64 {
        self.draws.memory() + self.lookup.memory()
    }
}

/// Places of the instances that the light may reach.
pub(super) fn in_range(scene: &SceneBuffers, light: &PointLight) -> Vec<u32> {
    let reached = |bounds: &super::culling::OrientedBox| bounds.touches_sphere(light.position, light.range);
    let places = (0..).zip(scene.placed());
    places.filter(|(_, placed)| reached(&placed.bounds)).map(|(place, _)| place).collect()
}
