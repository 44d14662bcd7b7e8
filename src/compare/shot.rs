//! What a camera sees of a scene: a receiver for each pixel, by rays in double precision.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::error_figures::Receiver;
use super::reference::Reference;
use super::scene::{Camera, Scene};

/// The surfaces that a camera sees.
#[derive(Debug, Clone)]
pub struct Shot {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// The camera's position in the world.
    pub eye: DVec3,
    /// Angle of a pixel in the middle, in radians.
    pub pixel_angle: f64,
    /// The number of each pixel that shows a surface, row by row from the upper left, and the surface's point there.
    pub seen: Vec<(usize, Receiver)>,
}

impl Shot {
    /// Casts a ray through the middle of each pixel. Backs of single-sided meshes are looked through, as renderers cull
    /// them.
    #[must_use]
    pub fn take(scene: &Scene, camera: &Camera, width: u32, height: u32) -> Self {
        Self::of(&reference(scene, camera), camera, width, height)
    }

    /// [`Self::take`] at several sizes.
    #[must_use]
    pub fn take_sizes(scene: &Scene, camera: &Camera, sizes: &[(u32, u32)]) -> Vec<Self> {
        let reference = reference(scene, camera);
        sizes.iter().map(|&(width, height)| Self::of(&reference, camera, width, height)).collect()
    }

    /// [`Self::take`] of triangles that are there already, all of which cast.
    #[must_use]
    pub fn of(reference: &Reference, camera: &Camera, width: u32, height: u32) -> Self {
        let rays = Rays::new(camera, width, height);
        let look = |pixel: usize| Some((pixel, rays.look(reference, pixel, DVec2::splat(0.5))?));
        let pixels = width as usize * height as usize;
        let pixel_angle = rays.up.length() / rays.half_size[1];
        Self { width, height, eye: rays.eye, pixel_angle, seen: (0..pixels).into_par_iter().filter_map(look).collect() }
    }
}

/// The scene around the camera's eye.
fn reference(scene: &Scene, camera: &Camera) -> Reference {
    let triangles = scene.world_triangles();
    Reference::new(&triangles.corners, None, camera.eye.as_dvec3())
        .with_cut_outs(scene.cut_outs(&triangles))
        .with_double_sided(scene.double_sided(&triangles))
}

/// The rays of a camera's pixels.
pub(super) struct Rays {
    width: usize,
    half_size: [f64; 2],
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
}

impl Rays {
    pub(super) fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let eye = camera.eye.as_dvec3();
        let forward = (camera.target.as_dvec3() - eye).normalize_or(DVec3::NEG_Z);
        let right = forward.cross(DVec3::Y).normalize_or(DVec3::X);
        let tangent = (0.5 * f64::from(camera.fov_y)).tan();
        Self {
            width: width as usize,
            half_size: [width, height].map(|pixels| 0.5 * f64::from(pixels)),
            eye,
            forward,
            right: right * tangent,
            up: right.cross(forward) * tangent,
        }
    }

    /// What is seen in a place of a pixel, from (0, 0) on the upper left to (1, 1): the side that faces the camera.
    pub(super) fn look(&self, reference: &Reference, pixel: usize, place: DVec2) -> Option<Receiver> {
        let direction = self.direction(pixel, place);
        let hit = reference.seen_from(self.eye - reference.light_position(), direction)?;
        let normal = reference.normal(hit.triangle);
        let normal = if normal.dot(direction) < 0.0 { normal } else { -normal };
        Some(receiver(self.eye + direction * hit.t, normal, hit.triangle))
    }

    /// Width of a pixel, square to the ray through its middle, at a point of the world.
    pub(super) fn pixel_width(&self, point: DVec3) -> f64 {
        // `up` is as long as half of the picture's height at distance 1.
        (point - self.eye).dot(self.forward) * self.up.length() / self.half_size[1]
    }

    fn direction(&self, pixel: usize, place: DVec2) -> DVec3 {
        let [half_width, half_height] = self.half_size;
        let x = (pixel % self.width) as f64 + place.x - half_width;
        let y = half_height - (pixel / self.width) as f64 - place.y;
        (self.forward + (self.right * x + self.up * y) / half_height).normalize()
    }
}

fn receiver(point: DVec3, normal: DVec3, triangle: u32) -> Receiver {
    let position = point.as_vec3();
    let rounding = (point - position.as_dvec3()).length();
    Receiver { position, normal: normal.as_vec3(), triangle, rounding }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::procedural::{few_large, shapes::quad};
    use crate::compare::scene::{Material, SceneInstance};
    use glam::{Affine3A, Vec3};

    #[test]
    fn a_room_fills_the_picture() {
        let camera = Camera { eye: Vec3::new(0.0, 4.0, 0.0), target: Vec3::new(0.0, 0.0, -1.0), fov_y: 1.0 };
        let (scene, (width, height)) = (few_large(), (32, 18));
        let shot = Shot::take(&scene, &camera, width, height);
        assert_eq!(shot.seen.len(), 32 * 18);
        let (low, high) = scene.bounds().expect("the room isn't empty");
        for (place, (pixel, receiver)) in shot.seen.iter().enumerate() {
            assert_eq!(*pixel, place);
            let inside = receiver.position.cmpge(low - 1e-4).all() && receiver.position.cmple(high + 1e-4).all();
            assert!(inside && (receiver.normal.length() - 1.0).abs() < 1e-6);
        }
        // The first pixel is on the upper left, and right is +X for a camera that looks along -Z.
        let seen = |index: usize| (shot.seen[index].1.position - camera.eye).normalize();
        assert!(seen(0).x < seen(31).x && seen(0).y > seen(17 * 32).y);
    }

    /// A wall is looked through from behind unless its mesh is double-sided; what is seen faces the camera.
    #[test]
    fn backs_are_culled_as_renderers_do() {
        for (double_sided, behind) in [(false, -2.0), (true, -1.0)] {
            let scene = Scene {
                meshes: vec![
                    quad(Vec3::new(-9.0, -9.0, -1.0), Vec3::Y * 18.0, Vec3::X * 18.0),
                    quad(Vec3::new(-9.0, -9.0, -2.0), Vec3::X * 18.0, Vec3::Y * 18.0),
                ],
                instances: (0..2).map(|mesh| SceneInstance { mesh, transform: Affine3A::IDENTITY }).collect(),
                materials: vec![Material { double_sided, ..Material::default() }],
                ..Scene::default()
            };
            let camera = Camera { eye: Vec3::ZERO, target: Vec3::NEG_Z, fov_y: 1.0 };
            let shot = Shot::take(&scene, &camera, 8, 4);
            assert_eq!(shot.seen.len(), 32);
            let faces =
                |(_, seen): &(usize, Receiver)| seen.normal == Vec3::Z && (seen.position.z - behind).abs() < 1e-5;
            assert!(shot.seen.iter().all(faces), "{double_sided}");
        }
    }

    #[test]
    fn pixels_are_as_wide_as_the_angle_of_view_says() {
        let camera = Camera { eye: Vec3::ZERO, target: Vec3::NEG_Z, fov_y: 2.0 * 0.5f32.atan() };
        let rays = Rays::new(&camera, 20, 10);
        // The picture is as high as it is far away, whatever is beside the middle.
        assert!((rays.pixel_width(DVec3::new(0.7, 0.1, -3.0)) - 0.3).abs() < 1e-6);
    }
}
