//! The cube map that the cube baselines draw to: six faces along the world's axes.

use super::culling::OrientedBox;
use super::instanced::InstancedView;
use crate::light::PointLight;
use glam::{Vec3, Vec4};

/// One face of a cube map: the axes of its view in the world, which are those by which the hardware looks it up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    right: Vec3,
    up: Vec3,
    forward: Vec3,
}

/// The faces in the order of a cube texture's layers.
pub(super) const FACES: [Face; 6] = [
    Face::new(Vec3::NEG_Z, Vec3::Y, Vec3::X),
    Face::new(Vec3::Z, Vec3::Y, Vec3::NEG_X),
    Face::new(Vec3::X, Vec3::NEG_Z, Vec3::Y),
    Face::new(Vec3::X, Vec3::Z, Vec3::NEG_Y),
    Face::new(Vec3::X, Vec3::Y, Vec3::Z),
    Face::new(Vec3::NEG_X, Vec3::Y, Vec3::NEG_Z),
];

impl Face {
    const fn new(right: Vec3, up: Vec3, forward: Vec3) -> Self {
        Self { right, up, forward }
    }

    /// A quarter circle from side to side, depth `near` over the distance along the axis, nothing too far.
    pub(super) fn view(&self, light: &PointLight) -> InstancedView {
        InstancedView {
            rows: [self.right.extend(0.0), self.up.extend(0.0), Vec4::W * light.near, self.forward.extend(0.0)],
            origin: light.position,
            padding: 0,
        }
    }

    /// Whether some of a box may be in the face's frustum, from the near plane to the light's range.
    pub(super) fn sees(&self, light: &PointLight, bounds: &OrientedBox) -> bool {
        let sides = [self.right, -self.right, self.up, -self.up];
        let within = |normal, distance| bounds.touches_half_space(light.position, normal, distance);
        sides.into_iter().all(|side| within(self.forward + side, 0.0))
            && within(self.forward, light.near)
            && within(-self.forward, -light.range)
    }
}

/// A cube of depth.
#[derive(Debug)]
pub(super) struct CubeMap {
    texture: wgpu::Texture,
    faces: Vec<wgpu::TextureView>,
}

impl CubeMap {
    pub(super) fn new(device: &wgpu::Device, resolution: u32) -> Self {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("dual_paraboloid::compare::cube"),
            size: wgpu::Extent3d { width: resolution, height: resolution, depth_or_array_layers: FACES.len() as u32 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Depth32Float,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let face = |layer| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                label: Some("dual_paraboloid::compare::cube_face"),
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: layer,
                array_layer_count: Some(1),
                ..Default::default()
            })
        };
        let faces = (0..FACES.len() as u32).map(face).collect();
        Self { texture, faces }
    }

    pub(super) fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }

    /// A view of each face.
    pub(super) fn faces(&self) -> &[wgpu::TextureView] {
        &self.faces
    }

    /// A view of all faces as layers.
    pub(super) fn all_faces(&self) -> wgpu::TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor {
            label: Some("dual_paraboloid::compare::cube_faces"),
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        })
    }

    /// Texels across a face.
    pub(super) fn resolution(&self) -> u32 {
        self.texture.width()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_mirrored_views() {
        for face in FACES {
            assert_eq!(face.right.cross(face.up), face.forward);
        }
    }
}
