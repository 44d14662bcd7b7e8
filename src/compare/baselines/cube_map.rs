//! The cube map that the cube baselines draw to: six faces along the light's axes, a little wider than a quarter circle.

use super::culling::OrientedBox;
use super::instanced::InstancedView;
use crate::light::PointLight;
use glam::Vec3;

/// Width in texels of the guard band around a face's quarter circle. Bilinear filtering of a direction on the border
/// takes texels whose centres lie up to half a texel beyond it; the 64th is room for rounding. So every tap is in the
/// receiver's own face, where its depth is along the receiver's own axis.
///
/// The seamless filtering of cube textures does without, but compares texels of the neighbour's axis with a reference
/// along the receiver's, and texels that are gathered by hand can't have it. With either, hardware comparisons err alike:
/// 1.01 times as often with the band on four scenes, two turns and R = 256 and 1024, by geometric mean; one scene turned the
/// other way differs by more. So one map serves all lookups.
const GUARD: f32 = 0.5 + 1.0 / 64.0;

/// What a texel of a cube holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CubeDepth {
    /// `near / z` in four bytes: the same relative precision at every distance.
    Float32,
    /// Two bytes. Their steps are even in the depth, which the rasteriser interpolates as `a + b / z`: reversed or not,
    /// an error in z grows with z squared over the near distance. So precision is best where the near plane is as far
    /// out as it may be, just before the nearest surface, and 0 is at the light's range. Reversed only so that
    /// all maps compare alike.
    Unorm16,
}

impl CubeDepth {
    pub(super) fn format(self) -> wgpu::TextureFormat {
        match self {
            Self::Float32 => wgpu::TextureFormat::Depth32Float,
            Self::Unorm16 => wgpu::TextureFormat::Depth16Unorm,
        }
    }

    /// Bytes of a texel.
    #[must_use]
    pub fn bytes(self) -> u64 {
        match self {
            Self::Float32 => 4,
            Self::Unorm16 => 2,
        }
    }
}

/// How a face's depth follows from the distance z along its axis: `scale / z + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DepthMapping {
    /// Distance of the near plane.
    pub(super) near: f32,
    pub(super) scale: f32,
    pub(super) offset: f32,
}

impl DepthMapping {
    /// `near / z`: 1 at the near plane, 0 at infinity.
    pub(super) fn infinite(near: f32) -> Self {
        Self { near, scale: near, offset: 0.0 }
    }

    /// 1 at the near plane, 0 at the distance `far`.
    fn finite(near: f32, far: f32) -> Self {
        let share = near / (far - near);
        Self { near, scale: share * far, offset: -share }
    }

    /// The mapping of a cube around a light, of whose scene nothing is nearer to it than `nearest`.
    pub(super) fn new(depth: CubeDepth, light: &PointLight, nearest: f32, half_width: f32) -> Self {
        if depth == CubeDepth::Float32 {
            return Self::infinite(light.near);
        }
        // The axis lies farthest off in a face's corner.
        let along_axis = nearest / (1.0 + 2.0 * half_width * half_width).sqrt();
        Self::finite((0.999 * along_axis).min(0.5 * light.range).max(light.near), light.range)
    }
}

/// One face of a cube map: the axes of its view in light space, which are those by which the hardware looks it up.
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

    /// The face's axes in the world.
    fn turned(self, light: &PointLight) -> Self {
        let [right, up, forward] = [self.right, self.up, self.forward].map(|axis| light.orientation * axis);
        Self { right, up, forward }
    }

    /// From `-half_width` to `half_width` at distance 1 along the axis.
    pub(super) fn view(self, light: &PointLight, half_width: f32, depth: DepthMapping) -> InstancedView {
        let Self { right, up, forward } = self.turned(light);
        InstancedView {
            rows: [
                (right / half_width).extend(0.0),
                (up / half_width).extend(0.0),
                (forward * depth.offset).extend(depth.scale),
                forward.extend(0.0),
            ],
            origin: light.position,
            padding: 0,
        }
    }

    /// Whether some of a box may be in the face's frustum, from the near plane to the light's range.
    pub(super) fn sees(self, light: &PointLight, half_width: f32, near: f32, bounds: &OrientedBox) -> bool {
        let Self { right, up, forward } = self.turned(light);
        let within = |normal, distance| bounds.touches_half_space(light.position, normal, distance);
        [right, -right, up, -up].into_iter().all(|side| within(half_width * forward + side, 0.0))
            && within(forward, near)
            && within(-forward, -light.range)
    }
}

/// A cube of depth.
#[derive(Debug)]
pub(super) struct CubeMap {
    texture: wgpu::Texture,
    faces: Vec<wgpu::TextureView>,
    depth: CubeDepth,
}

impl CubeMap {
    pub(super) fn new(device: &wgpu::Device, resolution: u32, depth: CubeDepth) -> Self {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("dual_paraboloid::compare::cube"),
            size: wgpu::Extent3d { width: resolution, height: resolution, depth_or_array_layers: FACES.len() as u32 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: depth.format(),
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
        Self { texture, faces, depth }
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

    pub(super) fn depth(&self) -> CubeDepth {
        self.depth
    }

    /// Half a face's width at distance 1 along its axis: 1 for the quarter circle, and the guard band.
    pub(super) fn half_width(&self) -> f32 {
        half_width(self.resolution())
    }
}

/// That of any map of so many texels across a face.
pub(super) fn half_width(resolution: u32) -> f32 {
    let resolution = resolution as f32;
    // Maps of a few texels keep half of them for the quarter circle.
    resolution / (resolution - 2.0 * GUARD.min(0.25 * resolution))
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

    #[test]
    fn taps_of_the_quarter_circle_are_within_the_face() {
        for resolution in [4, 100, 1182, 8192] {
            // In texels, where integers are the centres.
            let texel = 2.0 * half_width(resolution) / resolution as f32;
            let border = 0.5 * resolution as f32 + 1.0 / texel - 0.5;
            assert!(border.floor() + 1.0 <= (resolution - 1) as f32, "{resolution}: {border}");
            assert!((half_width(resolution) - 1.0) / texel < 0.52, "{resolution}");
        }
        assert_eq!(half_width(1), 2.0);
    }

    #[test]
    fn depth_is_1_at_the_near_plane_and_0_at_the_far_one() {
        let light = PointLight { near: 0.01, range: 30.0, ..Default::default() };
        let float = DepthMapping::new(CubeDepth::Float32, &light, 2.0, 1.0);
        assert_eq!(float, DepthMapping { near: 0.01, scale: 0.01, offset: 0.0 });
        let unorm = DepthMapping::new(CubeDepth::Unorm16, &light, 2.0, 1.0);
        // 2 / sqrt(3), and a little room.
        assert!((unorm.near - 1.1547).abs() < 2e-3, "{}", unorm.near);
        let at = |z: f32| unorm.scale / z + unorm.offset;
        assert!((at(unorm.near) - 1.0).abs() < 1e-6 && at(30.0).abs() < 1e-6, "{unorm:?}");
        // Never nearer than the light's own near plane.
        assert_eq!(DepthMapping::new(CubeDepth::Unorm16, &light, 0.0, 1.0).near, 0.01);
    }
}
