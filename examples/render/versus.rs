//! The same view by three kinds of shadows, side by side.

use crate::arguments::Arguments;
use crate::error::truths;
use dual_paraboloid::compare::baselines::{Baseline, DeviceScene, Lookup, Method};
use dual_paraboloid::compare::error_figures::Receiver;
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::measure::{Judge, Truth};
use dual_paraboloid::compare::scene::{Camera, Scene};
use dual_paraboloid::compare::shot::Shot;
use dual_paraboloid::{PointLight, Sides};
use glam::Vec3;
use image::{Rgb, RgbImage};

/// Samples of a pixel along each axis.
const SAMPLES: u32 = 3;
/// Pixels between the pictures.
const GAP: u32 = 4;
/// Points of the scene that the cube's bias is searched with.
const RECEIVERS: usize = 100_000;
/// Light from everywhere, for what is as bright as most lit surfaces.
const AMBIENT: f32 = 0.03;

/// This library on the left, in the middle a cube of as many bytes with the hardware's comparison and the bias that is best
/// for the scene, ray casting on the right.
pub fn picture(
    gpu: &Gpu,
    arguments: &Arguments,
    scene: &Scene,
    camera: &Camera,
    light: &PointLight,
) -> anyhow::Result<RgbImage> {
    let (width, height) = arguments.size.into();
    let shot = Shot::take(scene, camera, SAMPLES * width, SAMPLES * height);
    let receivers: Vec<Receiver> = shot.seen.iter().map(|&(_, receiver)| receiver).collect();
    // One more, since there may be none, and buffers can't be empty.
    let nowhere = std::iter::once((Vec3::ZERO, Vec3::Y));
    let inputs: Vec<_> = receivers.iter().map(|receiver| (receiver.position, receiver.normal)).chain(nowhere).collect();

    let truth = Truth::new(scene, light, RECEIVERS, 1);
    let mut judge = Judge::new(gpu, *light, &truth);
    let mut device_scene = DeviceScene::new(gpu, scene, Sides::Auto)?;
    let mut pair = Baseline::new(&gpu.device, Method::Paraboloid, arguments.resolution)?;
    judge.record(&mut pair, &mut device_scene, light.orientation)?;
    let angle = SAMPLES as f32 * shot.pixel_angle as f32;
    let own = pair.pixel_values(gpu, Lookup::Paraboloid, &inputs, shot.eye.as_vec3(), angle).unwrap_or_default();
    // Two squares of eight bytes a texel, six of four.
    let side = (f64::from(arguments.resolution) * (2.0 / 3.0_f64).sqrt()).round() as u32;
    let mut cube = Baseline::new(&gpu.device, Method::Cube, side)?;
    judge.fit(&mut cube, &[Lookup::CubeHardware], &mut device_scene)?;
    let cubes = cube.shadow_values(gpu, Lookup::CubeHardware, &inputs).unwrap_or_default();
    let rays: Vec<f32> = truths(scene, light, &receivers).into_iter().map(|share| share as f32).collect();

    let arriving: Vec<f32> = receivers.iter().map(|receiver| irradiance(receiver, light)).collect();
    let mut sorted: Vec<f32> = arriving.iter().copied().filter(|value| *value > 0.0).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    let bright = sorted.get(sorted.len() * 9 / 10).copied().unwrap_or(1.0);
    let mut picture = RgbImage::from_pixel(3 * width + 2 * GAP, height, Rgb([255; 3]));
    for (panel, values) in (0..).zip([own, cubes, rays]) {
        let mut sums = vec![0.0; (width * height) as usize];
        for (((pixel, _), arriving), value) in shot.seen.iter().zip(&arriving).zip(&values) {
            let (x, y) = (*pixel as u32 % (SAMPLES * width), *pixel as u32 / (SAMPLES * width));
            let light = AMBIENT + arriving / bright * value;
            sums[(y / SAMPLES * width + x / SAMPLES) as usize] += light / (SAMPLES * SAMPLES) as f32;
        }
        for (index, sum) in (0..).zip(sums) {
            let level = (255.0 * (1.0 - (-1.2 * sum).exp()).powf(1.0 / 2.2)) as u8;
            picture.put_pixel(panel * (width + GAP) + index % width, index / width, Rgb([level; 3]));
        }
    }
    Ok(picture)
}

/// Without shadows, on the side that is seen.
fn irradiance(receiver: &Receiver, light: &PointLight) -> f32 {
    let to_light = light.position - receiver.position;
    let cosine = receiver.normal.normalize().dot(to_light.normalize()).max(0.0);
    cosine / to_light.length_squared().max(1e-12)
}
