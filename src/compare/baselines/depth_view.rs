//! One plain view of everything: what drawing each triangle once costs.

use super::instanced::{InstancedDraws, InstancedView, PassKind};
use super::scene_buffers::SceneBuffers;
use super::wide_map;
use glam::{Vec3, Vec4};

/// Direction of view: askew, so that floors and walls along the world's axes are drawn as surfaces.
const FORWARD: Vec3 = Vec3::new(1.0, -2.0, -3.0);

/// One orthographic view of the whole scene, into a map as large as a pair. Nothing is culled or clipped.
#[derive(Debug)]
pub struct DepthView {
    map: wgpu::Texture,
    target: wgpu::TextureView,
    draws: InstancedDraws,
}

impl DepthView {
    /// Creates a map of twice `resolution` by `resolution` texels.
    #[must_use]
    pub fn new(device: &wgpu::Device, resolution: u32) -> Self {
        let map = wide_map(device, resolution);
        Self {
            target: map.create_view(&wgpu::TextureViewDescriptor::default()),
            draws: InstancedDraws::new(device, PassKind::OneView, map.format(), 1, size_of::<InstancedView>() as u64),
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
    ) {
        self.draws.clear();
        self.draws.add_all(scene);
        self.draws.upload(device, queue, &[whole_scene(scene.bounds())]);
        let mut pass = self.draws.begin(encoder, &self.target);
        self.draws.draw(&mut pass, scene, 0, 0);
    }

    /// The map: 1 nearest to the eye, 0 farthest.
    #[must_use]
    pub fn map(&self) -> &wgpu::Texture {
        &self.map
    }

    /// Bytes on the GPU beside the map.
    pub(super) fn working_memory(&self) -> u64 {
        self.draws.memory()
    }
}

/// The view that just holds a box.
fn whole_scene((low, high): (Vec3, Vec3)) -> InstancedView {
    let forward = FORWARD.normalize();
    let right = Vec3::Y.cross(forward).normalize();
    let up = forward.cross(right);
    let half = 0.5 * (high - low);
    // One over the box's reach along an axis, with room for rounding.
    let fit = |axis: Vec3| axis / (axis.abs().dot(half) * 1.001).max(f32::MIN_POSITIVE);
    InstancedView {
        rows: [fit(right).extend(0.0), fit(up).extend(0.0), (-0.5 * fit(forward)).extend(0.5), Vec4::W],
        origin: 0.5 * (low + high),
        padding: 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_view_holds_the_box() {
        let (low, high) = (Vec3::new(-3.0, 5.0, 100.0), Vec3::new(40.0, 6.0, 170.0));
        let view = whole_scene((low, high));
        for corner in 0..8 {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            let p = (Vec3::from_array([0, 1, 2].map(pick)) - view.origin).extend(1.0);
            let [x, y, z, w] = view.rows.map(|row| row.dot(p));
            assert!(x.abs() < 1.0 && y.abs() < 1.0 && (0.0..=1.0).contains(&z) && w == 1.0);
        }
    }
}
