//! Pictures of where the errors are.

use crate::figures::Measured;
use crate::truth_depth;
use anyhow::anyhow;
use dual_paraboloid::compare::error_figures::{Receiver, TexelVerdict, judge_texels, truth as ask_truth};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::measure::{Judged, Truth};
use dual_paraboloid::compare::reference::Reference;
use dual_paraboloid::compare::scene::{Camera, Scene};
use glam::{DVec3, Vec3};
use image::{GenericImage, Rgb, RgbImage};
use std::path::Path;

/// Pixels of a view of the scene.
const WIDTH: u32 = 480;
const HEIGHT: u32 = 270;

const NOT_JUDGED: Rgb<u8> = Rgb([14, 20, 48]);
const EMPTY: Rgb<u8> = Rgb([0, 0, 0]);
const RIGHT: Rgb<u8> = Rgb([72, 72, 72]);
const WRONG_SURFACE: Rgb<u8> = Rgb([255, 210, 0]);
const HOLE: Rgb<u8> = Rgb([255, 40, 40]);
const PHANTOM: Rgb<u8> = Rgb([255, 60, 255]);

const LEAK: [f64; 3] = [255.0, 50.0, 40.0];
const FALSE_SHADOW: [f64; 3] = [70.0, 120.0, 255.0];
const LIT: [f64; 3] = [225.0, 222.0, 215.0];
const DARK: [f64; 3] = [80.0, 80.0, 84.0];

/// Writes `map.png` where there is a pair of ours, and `screen-METHOD.png` for each method that has a lookup.
pub fn write_all(folder: &Path, gpu: &Gpu, scene: &Scene, truth: &Truth, measured: &[Measured]) -> anyhow::Result<()> {
    let shot = Shot::take(scene, truth);
    for one in measured {
        if let Some(picture) = one.judged.as_ref().and_then(|judged| map(judged, truth)) {
            write(&folder.join("map.png"), &picture)?;
        }
        let values = one.entry.lookup.and_then(|lookup| one.baseline.shadow_values(gpu, lookup, &shot.inputs()));
        if let Some(values) = values {
            write(&folder.join(format!("screen-{}.png", one.entry.name())), &shot.picture(&values))?;
        }
    }
    Ok(())
}

/// The verdict on every texel above, the depths that were ray-cast below.
fn map(judged: &Judged, truth: &Truth) -> Option<RgbImage> {
    let (ideal, _) = judged.ideal.as_ref()?;
    let r = ideal.geometry.resolution;
    let verdicts = judge_texels(&judged.stored, ideal, &truth.reference, &truth.view);
    let verdicts = RgbImage::from_fn(2 * r, r, |x, y| match verdicts[(y * 2 * r + x) as usize] {
        TexelVerdict::NotJudged => NOT_JUDGED,
        TexelVerdict::Empty => EMPTY,
        TexelVerdict::Right(_) => RIGHT,
        TexelVerdict::WrongSurface => WRONG_SURFACE,
        TexelVerdict::Hole => HOLE,
        TexelVerdict::Phantom => PHANTOM,
    });
    let depths: Vec<f32> = ideal.depths.iter().map(|&depth| depth as f32).collect();
    let half_width = 1.0 + ideal.geometry.guard as f32;
    let depths = truth_depth::picture(&depths, r, half_width, truth.view.near as f32);
    let mut both = RgbImage::new(2 * r, 2 * r);
    both.copy_from(&verdicts, 0, 0).ok()?;
    both.copy_from(&depths, 0, r).ok()?;
    Some(both)
}

/// What a camera sees of a scene.
struct Shot {
    /// A receiver for each pixel that shows a surface, with the pixel's number.
    seen: Vec<(usize, Receiver)>,
    /// Brightness of each, for its shape.
    shade: Vec<f64>,
    lit: Vec<bool>,
}

impl Shot {
    fn take(scene: &Scene, truth: &Truth) -> Self {
        let light = truth.view.position;
        let rays = Rays::new(&scene.suggest_camera(light.as_vec3()));
        let from_eye = Reference::new(&scene.world_triangles().corners, None, rays.eye);
        let mut shot = Self { seen: Vec::new(), shade: Vec::new(), lit: Vec::new() };
        for pixel in 0..(WIDTH * HEIGHT) as usize {
            let direction = rays.direction(pixel);
            let Some(hit) = from_eye.nearest(direction, 0.0) else { continue };
            let point = rays.eye + direction * hit.t;
            let normal = from_eye.normal(hit.triangle);
            if (point - light).length() > truth.view.range {
                continue;
            }
            let receiver = receiver(point, normal, hit.triangle);
            shot.seen.push((pixel, receiver));
            shot.shade.push(0.4 + 0.6 * normal.dot(direction).abs());
        }
        let receivers: Vec<Receiver> = shot.seen.iter().map(|&(_, receiver)| receiver).collect();
        shot.lit = ask_truth(&receivers, &truth.reference, &truth.view);
        shot
    }

    fn inputs(&self) -> Vec<(Vec3, Vec3)> {
        // One more, since there may be none, and buffers can't be empty.
        let nowhere = std::iter::once((Vec3::ZERO, Vec3::Y));
        self.seen.iter().map(|(_, receiver)| (receiver.position, receiver.normal)).chain(nowhere).collect()
    }

    /// The answers on the left, the truth on the right.
    fn picture(&self, values: &[f32]) -> RgbImage {
        let mut picture = RgbImage::new(2 * WIDTH, HEIGHT);
        for (index, &(pixel, _)) in self.seen.iter().enumerate() {
            let (x, y) = (pixel as u32 % WIDTH, pixel as u32 / WIDTH);
            let truth = if self.lit[index] { LIT } else { DARK };
            let answer = match (values[index] >= 0.5, self.lit[index]) {
                (true, false) => LEAK,
                (false, true) => FALSE_SHADOW,
                _ => truth.map(|channel| self.shade[index] * channel),
            };
            picture.put_pixel(x, y, Rgb(answer.map(|channel| channel as u8)));
            picture.put_pixel(WIDTH + x, y, Rgb(truth.map(|channel| (self.shade[index] * channel) as u8)));
        }
        picture
    }
}

fn receiver(point: DVec3, normal: DVec3, triangle: u32) -> Receiver {
    let position = point.as_vec3();
    let rounding = (point - position.as_dvec3()).length();
    Receiver { position, normal: normal.as_vec3(), triangle, rounding }
}

/// The rays of a camera's pixels.
struct Rays {
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
}

impl Rays {
    fn new(camera: &Camera) -> Self {
        let eye = camera.eye.as_dvec3();
        let forward = (camera.target.as_dvec3() - eye).normalize_or(DVec3::NEG_Z);
        let right = forward.cross(DVec3::Y).normalize_or(DVec3::X);
        let height = (0.5 * f64::from(camera.fov_y)).tan();
        Self { eye, forward, right: right * height, up: right.cross(forward) * height }
    }

    fn direction(&self, pixel: usize) -> DVec3 {
        let (width, height) = (f64::from(WIDTH), f64::from(HEIGHT));
        let x = (pixel % WIDTH as usize) as f64 + 0.5 - 0.5 * width;
        let y = 0.5 * height - (pixel / WIDTH as usize) as f64 - 0.5;
        (self.forward + (self.right * x + self.up * y) / (0.5 * height)).normalize()
    }
}

fn write(path: &Path, picture: &RgbImage) -> anyhow::Result<()> {
    picture
        .save_with_format(path, image::ImageFormat::Png)
        .map_err(|error| anyhow!("can't write {}: {error}", path.display()))?;
    println!("picture    {}", path.display());
    Ok(())
}
