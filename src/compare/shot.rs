//! What a camera sees of a scene: a receiver for each pixel, by rays in double precision.

use glam::DVec3;
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
    /// The number of each pixel that shows a surface, row by row from the upper left, and the surface's point there.
    pub seen: Vec<(usize, Receiver)>,
}

impl Shot {
    /// Casts a ray through the middle of each pixel.
    #[must_use]
    pub fn take(scene: &Scene, camera: &Camera, width: u32, height: u32) -> Self {
        Self::look(&reference(scene, camera), camera, width, height)
    }

    /// [`Self::take`] at several sizes.
    #[must_use]
    pub fn take_sizes(scene: &Scene, camera: &Camera, sizes: &[(u32, u32)]) -> Vec<Self> {
        let reference = reference(scene, camera);
        sizes.iter().map(|&(width, height)| Self::look(&reference, camera, width, height)).collect()
    }

    fn look(reference: &Reference, camera: &Camera, width: u32, height: u32) -> Self {
        let rays = Rays::new(camera, width, height);
        let look = |pixel: usize| {
            let direction = rays.direction(pixel);
            let hit = reference.nearest(direction, 0.0)?;
            let point = rays.eye + direction * hit.t;
            Some((pixel, receiver(point, reference.normal(hit.triangle), hit.triangle)))
        };
        let pixels = width as usize * height as usize;
        Self { width, height, eye: rays.eye, seen: (0..pixels).into_par_iter().filter_map(look).collect() }
    }
}

/// The scene around the camera's eye.
fn reference(scene: &Scene, camera: &Camera) -> Reference {
    let triangles = scene.world_triangles();
    let eye = camera.eye.as_dvec3();
    Reference::new(&triangles.corners, None, eye).with_cut_outs(scene.cut_outs(&triangles))
}

fn receiver(point: DVec3, normal: DVec3, triangle: u32) -> Receiver {
    let position = point.as_vec3();
    let rounding = (point - position.as_dvec3()).length();
    Receiver { position, normal: normal.as_vec3(), triangle, rounding }
}

/// The rays of a camera's pixels.
struct Rays {
    width: usize,
    half_size: [f64; 2],
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
}

impl Rays {
    fn new(camera: &Camera, width: u32, height: u32) -> Self {
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

    fn direction(&self, pixel: usize) -> DVec3 {
        let [half_width, half_height] = self.half_size;
        let x = (pixel % self.width) as f64 + 0.5 - half_width;
        let y = half_height - (pixel / self.width) as f64 - 0.5;
        (self.forward + (self.right * x + self.up * y) / half_height).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::procedural::few_large;
    use glam::Vec3;

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
}
