//! Where the first light's shadows differ from the truth by ray casting, as a picture.

use crate::arguments::Arguments;
use dual_paraboloid::compare::area_light::shares_of_sphere;
use dual_paraboloid::compare::error_figures::{Receiver, truth};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::reference::{Reference, View};
use dual_paraboloid::compare::scene::{Camera, Scene};
use dual_paraboloid::compare::shot::Shot;
use dual_paraboloid::{Casters, Filter, LightId, PointLight, PointShadows};
use glam::Vec3;
use image::{Rgb, RgbImage};

/// Rays from each pixel's surface to a sphere of light.
const RAYS: usize = 64;

/// Grey where the shadow is right, from black in the dark to white in the light; red where it is too light and blue
/// where it is too dark, the more the more. A soft light is held against its sphere, any other against a point.
pub fn picture(
    gpu: &Gpu,
    arguments: &Arguments,
    scene: &Scene,
    camera: &Camera,
    (shadows, casters): (&PointShadows, &Casters),
    (id, light): (LightId, &PointLight),
) -> RgbImage {
    let (width, height) = arguments.size.into();
    let shot = Shot::take(scene, camera, width, height);
    let receivers: Vec<Receiver> = shot.seen.iter().map(|&(_, receiver)| receiver).collect();
    let truths = truths(scene, light, &receivers);
    // One more, since there may be none, and buffers can't be empty.
    let nowhere = std::iter::once((Vec3::ZERO, Vec3::Y));
    let inputs: Vec<_> = receivers.iter().map(|receiver| (receiver.position, receiver.normal)).chain(nowhere).collect();
    let values = gpu.filtered_values(shadows, casters, id, &inputs);
    let mut picture = RgbImage::new(width, height);
    for (((pixel, _), truth), value) in shot.seen.iter().zip(truths).zip(values) {
        picture.put_pixel(*pixel as u32 % width, *pixel as u32 / width, color(f64::from(value), truth));
    }
    picture
}

/// The share of the light that truly arrives at each receiver.
pub fn truths(scene: &Scene, light: &PointLight, receivers: &[Receiver]) -> Vec<f64> {
    let view = View {
        position: light.position.as_dvec3(),
        orientation: light.orientation.as_dquat(),
        near: light.near.into(),
        range: light.range.into(),
    };
    let reference = Reference::new(&scene.world_triangles().corners, None, view.position);
    match light.filter {
        Filter::Soft { light_radius, .. } => shares_of_sphere(receivers, &reference, &view, light_radius.into(), RAYS),
        _ => truth(receivers, &reference, &view).into_iter().map(|lit| f64::from(u8::from(lit))).collect(),
    }
}

fn color(value: f64, truth: f64) -> Rgb<u8> {
    let error = value - truth;
    let grey = (0.2 + 0.6 * truth) * (1.0 - error.abs());
    let signed = [error.max(0.0), 0.0, (-error).max(0.0)];
    Rgb(signed.map(|over| (255.0 * (grey + over).clamp(0.0, 1.0)) as u8))
}
