//! What a person sees: the errors at a camera's pixels.

use std::sync::Arc;

use glam::{DVec2, Vec3};
use rand::Rng;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Truth, reference};
use crate::compare::baselines::{Baseline, Lookup};
use crate::compare::error_figures::{Receiver, is_lit, per_million};
use crate::compare::gpu::Gpu;
use crate::compare::reference::{Reference, Sides, View};
use crate::compare::scene::{Camera, Scene};
use crate::compare::shot::{Rays, Shot};

/// Points of a pixel along each of its sides: as many strata, with a random point in each.
const POINTS: usize = 4;

/// A lookup's errors at a camera's pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct PixelErrors {
    /// Asked over each pixel, as renderers do, where the lookup [takes that](Lookup::takes_pixel).
    pub pixels: PixelError,
    /// Asked at the pixels' middles alone.
    pub points: PixelError,
}

/// Figures about the answers at a camera's pixels. An answer of 0.5 or more means lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct PixelError {
    /// Number of pixels that count: what they show faces the light and is within its reach.
    pub pixels: usize,
    /// Wrong decisions by the truth at the pixels' middles, in parts per million of the pixels that count.
    pub wrong_ppm: f64,
    /// Mean absolute difference between the answer of a pixel and the share of the pixel that is lit.
    pub value_error: f64,
    /// Mean absolute difference between the answer of a pixel and the truth at its middle, 0 or 1.
    pub value_error_point: f64,
}

/// The truth at a camera's pixels.
///
/// A pixel's answer stands for the whole pixel, so it is held against the mean over the pixel: of 16 stratified
/// rays of the camera, those that meet a surface which faces the light and is no farther from the plane of what is
/// seen in the middle than a pixel is wide there. So past the outline of an object another one doesn't count, and the
/// facets of a curved surface do. The same pixels have the same rays every time.
#[derive(Debug, Clone)]
pub struct Pixels {
    receivers: Vec<Receiver>,
    lit: Vec<bool>,
    shares: Vec<f32>,
    eye: Vec3,
    /// Of a pixel in the middle, in radians.
    angle: f32,
}

impl Pixels {
    /// Casts the rays of a camera in the scene that the truth is of.
    #[must_use]
    pub fn new(truth: &Truth, scene: &Scene, camera: &Camera, width: u32, height: u32) -> Self {
        let view = &truth.view;
        let all = match truth.sides {
            Sides::Both => Arc::clone(&truth.reference),
            // What shows the light its back casts nothing, but the camera sees it.
            Sides::Front => Arc::new(reference(scene, view.position, Sides::Both)),
        };
        let Shot { mut seen, eye, pixel_angle, .. } = Shot::of(&all, camera, width, height);
        seen.retain(|(_, receiver)| faces_light(receiver, view));
        let look = Look { rays: Rays::new(camera, width, height), all: &all, casters: &truth.reference, view };
        let lit: Vec<bool> = seen.par_iter().map(|(_, receiver)| is_lit(receiver, &truth.reference, view)).collect();
        let shares = seen.par_iter().zip(&lit).map(|((pixel, middle), lit)| look.lit_share(*pixel, middle, *lit));
        let (shares, receivers) = (shares.collect(), seen.into_iter().map(|(_, receiver)| receiver).collect());
        Self { receivers, lit, shares, eye: eye.as_vec3(), angle: pixel_angle as f32 }
    }

    /// Positions and normals in the pixels' middles, as a shader takes them. May be none.
    #[must_use]
    pub fn inputs(&self) -> Vec<(Vec3, Vec3)> {
        self.receivers.iter().map(|receiver| (receiver.position, receiver.normal)).collect()
    }

    /// The errors of a lookup in a recorded map; `None` if no pixel counts, or for a lookup that doesn't read the map.
    #[must_use]
    pub fn errors(&self, gpu: &Gpu, baseline: &Baseline, lookup: Lookup) -> Option<PixelErrors> {
        let inputs = self.inputs();
        // A buffer can't be empty.
        if inputs.is_empty() {
            return None;
        }
        let points = self.judge(&baseline.shadow_values(gpu, lookup, &inputs)?)?;
        if !lookup.takes_pixel() {
            return Some(PixelErrors { pixels: points, points });
        }
        let pixels = self.judge(&baseline.pixel_values(gpu, lookup, &inputs, self.eye, self.angle)?)?;
        Some(PixelErrors { pixels, points })
    }

    /// Error figures of a method's answers; `None` if no pixel counts.
    ///
    /// # Panics
    /// When there are not as many values as pixels that count.
    #[must_use]
    pub fn judge(&self, values: &[f32]) -> Option<PixelError> {
        let pixels = self.receivers.len();
        assert_eq!(values.len(), pixels, "one value a pixel");
        let point = |lit: bool| f32::from(u8::from(lit));
        let wrong = values.iter().zip(&self.lit).filter(|(value, lit)| (**value >= 0.5) != **lit).count();
        let from_shares = values.iter().zip(&self.shares).map(|(value, share)| f64::from((value - share).abs()));
        let from_points = values.iter().zip(&self.lit).map(|(value, lit)| f64::from((value - point(*lit)).abs()));
        (pixels > 0).then(|| PixelError {
            pixels,
            wrong_ppm: per_million(wrong, pixels),
            value_error: from_shares.sum::<f64>() / pixels as f64,
            value_error_point: from_points.sum::<f64>() / pixels as f64,
        })
    }
}

/// Whether the seen side faces the light, where maps hold it.
fn faces_light(receiver: &Receiver, view: &View) -> bool {
    let distance = receiver.relative(view.position).length();
    (view.near..=view.range).contains(&distance) && receiver.incidence(view.position) > 0.0
}

struct Look<'a> {
    rays: Rays,
    /// What the camera sees.
    all: &'a Reference,
    /// What throws shadows.
    casters: &'a Reference,
    view: &'a View,
}

impl Look<'_> {
    /// The share of a pixel that is lit, of what it shows of the surface in its middle.
    fn lit_share(&self, pixel: usize, middle: &Receiver, middle_is_lit: bool) -> f32 {
        let mut random = Pcg64::new(0, pixel as u128);
        let depth = self.rays.pixel_width(middle.position.as_dvec3());
        let (mut lit, mut seen) = (0_u16, 0_u16);
        for stratum in 0..POINTS * POINTS {
            let within = DVec2::new(random.random(), random.random());
            let place = (DVec2::new((stratum % POINTS) as f64, (stratum / POINTS) as f64) + within) / POINTS as f64;
            let Some(point) = self.rays.look(self.all, pixel, place) else { continue };
            let apart = (point.position - middle.position).as_dvec3();
            if apart.dot(middle.normal.as_dvec3()).abs() <= depth && faces_light(&point, self.view) {
                seen += 1;
                lit += u16::from(is_lit(&point, self.casters, self.view));
            }
        }
        if seen > 0 { f32::from(lit) / f32::from(seen) } else { f32::from(u8::from(middle_is_lit)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::procedural::shapes::quad;
    use crate::compare::scene::SceneInstance;
    use crate::{PointLight, Sides as Casting};
    use glam::Affine3A;

    /// Pixels each way.
    const SIZE: usize = 20;

    /// A wall at a distance of 10, in pixels of 0.5 by 0.5. A plate behind the camera throws a shadow from x = 1.125 on,
    /// a quarter into the pixels of column 12, which span 1 to 1.5.
    fn wall(light_z: f32, casting: Casting) -> Pixels {
        let wall = quad(Vec3::new(-9.0, -9.0, -10.0), Vec3::X * 18.0, Vec3::Y * 18.0);
        let plate = quad(Vec3::new(1.125 / 4.0, -50.0, 5.0), Vec3::X * 50.0, Vec3::Y * 100.0);
        // Shows its back to both camera and light.
        let averted = quad(Vec3::new(-9.0, -9.0, -8.0), Vec3::Y * 18.0, Vec3::X * 18.0);
        let count = if casting == Casting::Front { 3 } else { 2 };
        let instances = (0..count).map(|mesh| SceneInstance { mesh, transform: Affine3A::IDENTITY }).collect();
        let scene = Scene { meshes: vec![wall, plate, averted], instances, ..Scene::default() };
        let light = PointLight { position: Vec3::Z * light_z, range: 100.0, near: 1e-3, ..Default::default() };
        let truth = Truth::with_sides(&scene, &light, casting, 100, 1);
        let camera = Camera { eye: Vec3::ZERO, target: Vec3::NEG_Z, fov_y: 2.0 * 0.5f32.atan() };
        Pixels::new(&truth, &scene, &camera, SIZE as u32, SIZE as u32)
    }

    fn answers(of_column: impl Fn(usize) -> f32) -> Vec<f32> {
        (0..SIZE * SIZE).map(|pixel| of_column(pixel % SIZE)).collect()
    }

    /// Answers that are right at every point err by the shares of the pixels that the edge crosses, and answers that are
    /// those shares by nothing.
    #[test]
    fn value_error_is_that_of_a_known_edge() {
        for casting in [Casting::Auto, Casting::Front] {
            let pixels = wall(10.0, casting);
            let judge = |of_column: fn(usize) -> f32| {
                let error = pixels.judge(&answers(of_column)).expect("pixels");
                assert_eq!(error.pixels, SIZE * SIZE);
                [error.wrong_ppm * 20e-6, error.value_error * 20.0, error.value_error_point * 20.0]
            };
            let assert_near = |found: [f64; 3], expected: [f64; 3]| {
                assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?} {expected:?}");
            };
            assert_near(judge(|column| if column < 12 { 1.0 } else { 0.0 }), [0.0, 0.25, 0.0]);
            assert_near(
                judge(|column| [1.0, 0.25, 0.0][(column >= 12) as usize + (column > 12) as usize]),
                [0.0, 0.0, 0.25],
            );
            assert_near(judge(|_| 1.0), [8.0, 7.75, 8.0]);
            assert_near(judge(|_| 0.5), [8.0, 9.75, 10.0]);
        }
    }

    #[test]
    fn pixels_that_face_away_from_the_light_do_not_count() {
        let pixels = wall(-30.0, Casting::Auto);
        assert!(pixels.inputs().is_empty());
        assert_eq!(pixels.judge(&[]), None);
    }

    /// Of a pixel that an object's outline crosses only what shows the object is its share.
    #[test]
    fn another_surface_does_not_count() {
        // What is left of the middle of column 10, lit, before a wall that a plate darkens.
        let column = quad(Vec3::new(-9.0, -9.0, -5.0), Vec3::X * 9.125, Vec3::Y * 18.0);
        let wall = quad(Vec3::new(-90.0, -90.0, -50.0), Vec3::X * 180.0, Vec3::Y * 180.0);
        // Shows the camera its back.
        let plate = quad(Vec3::new(-90.0, -90.0, -25.0), Vec3::Y * 180.0, Vec3::X * 180.0);
        let instances = (0..3).map(|mesh| SceneInstance { mesh, transform: Affine3A::IDENTITY }).collect();
        let scene = Scene { meshes: vec![column, wall, plate], instances, ..Scene::default() };
        let light = PointLight { position: Vec3::new(0.0, 0.0, 1.0), range: 1e3, near: 1e-3, ..Default::default() };
        let truth = Truth::new(&scene, &light, 0, 1);
        let camera = Camera { eye: Vec3::ZERO, target: Vec3::NEG_Z, fov_y: 2.0 * 0.5f32.atan() };
        let pixels = Pixels::new(&truth, &scene, &camera, SIZE as u32, SIZE as u32);
        let values: Vec<f32> =
            pixels.receivers.iter().map(|seen| if seen.position.z > -6.0 { 1.0 } else { 0.0 }).collect();
        let error = pixels.judge(&values).expect("pixels");
        assert_eq!((error.wrong_ppm, error.value_error), (0.0, 0.0), "{error:?}");
        assert!(values.contains(&1.0) && values.contains(&0.0));
    }
}
