//! Pictures of where the errors are.

use crate::arguments::Rule;
use crate::figures::Measured;
use crate::truth_depth;
use anyhow::anyhow;
use dual_paraboloid::compare::error_figures::{Receiver, TexelVerdict, judge_texels, truth as ask_truth};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::measure::{Judged, Truth};
use dual_paraboloid::compare::scene::{Camera, Scene};
use dual_paraboloid::compare::shot::Shot;
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
pub fn write_all(
    folder: &Path,
    gpu: &Gpu,
    scene: &Scene,
    camera: &Camera,
    truth: &Truth,
    rule: Rule,
    measured: &[Measured],
) -> anyhow::Result<()> {
    let view = View::new(scene, camera, truth);
    for one in measured {
        if let Some(picture) = one.judged.as_ref().and_then(|judged| map(judged, truth)) {
            write(&folder.join("map.png"), &picture)?;
        }
        let lookup = one.entry.judged(rule);
        let values = lookup.and_then(|lookup| one.baseline.shadow_values(gpu, lookup, &view.inputs()));
        if let Some(values) = values {
            write(&folder.join(format!("screen-{}.png", one.entry.name())), &view.picture(&values))?;
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

/// What a camera sees of a scene within the light's range, and whether it is lit; what faces away isn't.
struct View {
    shot: Shot,
    light: DVec3,
    lit: Vec<bool>,
}

impl View {
    fn new(scene: &Scene, camera: &Camera, truth: &Truth) -> Self {
        let light = truth.view.position;
        let mut shot = Shot::take(scene, camera, WIDTH, HEIGHT);
        shot.seen.retain(|(_, receiver)| receiver.relative(light).length() <= truth.view.range);
        let receivers: Vec<Receiver> = shot.seen.iter().map(|&(_, receiver)| receiver).collect();
        let reached = ask_truth(&receivers, &truth.reference, &truth.view);
        let lit = receivers.iter().zip(reached).map(|(receiver, lit)| lit && receiver.incidence(light) > 0.0).collect();
        Self { lit, light, shot }
    }

    fn inputs(&self) -> Vec<(Vec3, Vec3)> {
        // One more, since there may be none, and buffers can't be empty.
        let nowhere = std::iter::once((Vec3::ZERO, Vec3::Y));
        self.shot.seen.iter().map(|(_, receiver)| (receiver.position, receiver.normal)).chain(nowhere).collect()
    }

    /// The answers on the left, the truth on the right.
    fn picture(&self, values: &[f32]) -> RgbImage {
        let mut picture = RgbImage::new(2 * WIDTH, HEIGHT);
        for (index, (pixel, receiver)) in self.shot.seen.iter().enumerate() {
            let shade = self.shade(receiver);
            let (x, y) = (*pixel as u32 % WIDTH, *pixel as u32 / WIDTH);
            let truth = if self.lit[index] { LIT } else { DARK };
            let faces_light = receiver.incidence(self.light) > 0.0;
            let answer = match (values[index] >= 0.5, self.lit[index]) {
                (true, false) if faces_light => LEAK,
                (false, true) => FALSE_SHADOW,
                _ => truth.map(|channel| shade * channel),
            };
            picture.put_pixel(x, y, Rgb(answer.map(|channel| channel as u8)));
            picture.put_pixel(WIDTH + x, y, Rgb(truth.map(|channel| (shade * channel) as u8)));
        }
        picture
    }

    /// Brightness of a surface, for its shape.
    fn shade(&self, receiver: &Receiver) -> f64 {
        let towards = (receiver.position.as_dvec3() - self.shot.eye).normalize_or_zero();
        0.4 + 0.6 * receiver.normal.as_dvec3().dot(towards).abs()
    }
}

fn write(path: &Path, picture: &RgbImage) -> anyhow::Result<()> {
    picture
        .save_with_format(path, image::ImageFormat::Png)
        .map_err(|error| anyhow!("can't write {}: {error}", path.display()))?;
    println!("picture    {}", path.display());
    Ok(())
}
