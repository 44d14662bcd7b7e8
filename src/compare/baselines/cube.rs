//! Cube maps from instanced draws: culled by face, not culled at all, or in one multiview pass.

use super::cube_lookup::CubeLookup;
use super::cube_map::{CubeMap, FACES};
use super::instanced::{InstancedDraws, InstancedView, PassKind};
use super::lookup::ConstantBias;
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

/// Six passes into a cube map along the world's axes, as engines record them. The light's orientation and coverage
/// don't matter to it.
#[derive(Debug)]
pub struct Cube {
    culling: Culling,
    map: CubeMap,
    draws: InstancedDraws,
    lookup: CubeLookup,
}

impl Cube {
    /// Creates a cube map of `resolution` texels across a face.
    #[must_use]
    pub fn new(device: &wgpu::Device, resolution: u32, culling: Culling) -> Self {
        let map = CubeMap::new(device, resolution);
        Self {
            culling,
            draws: InstancedDraws::new(device, PassKind::OneView, 6, size_of::<InstancedView>() as u64),
            lookup: CubeLookup::new(device, &map),
            map,
        }
    }

    /// Records the whole map anew.
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        scene: &SceneBuffers,
        light: &PointLight,
        bias: ConstantBias,
    ) {
        self.list(scene, light);
        self.draws.upload(device, queue, &FACES.map(|face| face.view(light)));
        for (face, target) in self.map.faces().iter().enumerate() {
            let mut pass = self.draws.begin(encoder, target);
            let list = if self.culling == Culling::None { 0 } else { face };
            self.draws.draw(&mut pass, scene, face, list);
        }
        self.lookup.write(queue, light, bias);
    }

    /// Lists what each face draws: one list for all faces without culling.
    fn list(&mut self, scene: &SceneBuffers, light: &PointLight) {
        self.draws.clear();
        if self.culling == Culling::None {
            self.draws.add_all(scene);
            return;
        }
        let reached = in_range(scene, light);
        for face in FACES {
            let seen = |place: &u32| face.sees(light, &scene.placed()[*place as usize].bounds);
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

    /// Bytes on the GPU beside the map.
    pub(super) fn working_memory(&self) -> u64 {
        self.draws.memory()
    }
}

/// One pass over all faces of a cube map, with each instance in the light's range drawn once. The light's
/// orientation and coverage don't matter to it.
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
        let map = CubeMap::new(device, resolution);
        let view_size = size_of::<[InstancedView; FACES.len()]>() as u64;
        Some(Self {
            target: map.all_faces(),
            draws: InstancedDraws::new(device, PassKind::SixViews, 1, view_size),
            lookup: CubeLookup::new(device, &map),
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
        bias: ConstantBias,
    ) {
        self.draws.clear();
        self.draws.add_list(scene, in_range(scene, light).into_iter());
        self.draws.upload(device, queue, &[FACES.map(|face| face.view(light))]);
        let mut pass = self.draws.begin(encoder, &self.target);
        self.draws.draw(&mut pass, scene, 0, 0);
        drop(pass);
        self.lookup.write(queue, light, bias);
    }

    /// The cube texture.
    #[must_use]
    pub fn map(&self) -> &wgpu::Texture {
        self.map.texture()
    }

    pub(super) fn lookup(&self) -> &CubeLookup {
        &self.lookup
    }

    /// Bytes on the GPU beside the map.
    pub(super) fn working_memory(&self) -> u64 {
        self.draws.memory()
    }
}

/// Places of the instances that the light may reach.
pub(super) fn in_range(scene: &SceneBuffers, light: &PointLight) -> Vec<u32> {
    let reached = |bounds: &super::culling::OrientedBox| bounds.touches_sphere(light.position, light.range);
    let places = (0..).zip(scene.placed());
    places.filter(|(_, placed)| reached(&placed.bounds)).map(|(place, _)| place).collect()
}
