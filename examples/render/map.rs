//! A light's pair of maps as a picture.

use dual_paraboloid::paraboloid;
use glam::Vec2;
use image::{Rgb, RgbImage};

const OUTSIDE: Rgb<u8> = Rgb([14, 20, 48]);
const EMPTY: Rgb<u8> = Rgb([0, 0, 0]);

/// The front hemisphere on the left and the back one on the right: near is bright, far is dark, by the logarithm of
/// the distance from the light. The guard bands are dimmed, and what is outside them is blue.
pub fn picture(depth: &[f32], resolution: u32, half_width: f32, near: f32) -> RgbImage {
    let half = 0.5 * resolution as f32;
    let place = |x: u32, y: u32| {
        let texel = Vec2::new((x % resolution) as f32 + 0.5 - half, half - y as f32 - 0.5);
        texel * (half_width / half)
    };
    let distance = |x: u32, y: u32| {
        let stored = depth[(y * 2 * resolution + x) as usize];
        // w is near / stored, and the point is w times this.
        (stored > 0.0).then(|| near / stored * paraboloid::unproject_scaled(place(x, y)).length())
    };
    let inside = |x: u32, y: u32| place(x, y).length() <= half_width;
    let (mut least, mut most) = (f32::MAX, f32::MIN);
    let texels = (0..resolution).flat_map(|y| (0..2 * resolution).map(move |x| (x, y)));
    for distance in texels.filter(|&(x, y)| inside(x, y)).filter_map(|(x, y)| distance(x, y)) {
        (least, most) = (least.min(distance), most.max(distance));
    }
    RgbImage::from_fn(2 * resolution, resolution, |x, y| match distance(x, y) {
        _ if !inside(x, y) => OUTSIDE,
        None => EMPTY,
        Some(distance) => {
            let share = (most / distance).ln() / (most / least).ln().max(1e-6);
            let guard = if place(x, y).length() > 1.0 { 0.5 } else { 1.0 };
            Rgb([((40.0 + 215.0 * share) * guard) as u8; 3])
        }
    })
}
