//! The truth for a light that has a size: how much of a sphere each receiver sees.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::PI;

use super::error_figures::Receiver;
use super::reference::{Reference, View};

/// The share of a sphere around the light, of a radius in world units, that each receiver sees: the part of its
/// outline's disc that nothing stands before, by `rays` rays in double precision, stratified over the disc.
///
/// Nothing occludes that stands where the receiver lies, or nearer than the clip distance to the ray's start on the
/// sphere. What of the sphere is behind the receiver's own surface counts as if that surface didn't occlude: light from
/// there comes from its back.
#[must_use]
pub fn shares_of_sphere(
    receivers: &[Receiver],
    reference: &Reference,
    view: &View,
    radius: f64,
    rays: usize,
) -> Vec<f64> {
    let share = |receiver: &Receiver| {
        let target = receiver.relative(view.position);
        let slack = receiver.slack(view.position);
        let seen = outline(target, radius, rays)
            .filter(|from| !reference.occluded_from(*from, target, Some(receiver.triangle), view.near, slack));
        seen.count() as f64 / rays as f64
    };
    receivers.par_iter().map(share).collect()
}

/// Points that fill the disc of a sphere around the light that a point sees, evenly: a golden-angle spiral.
fn outline(from: DVec3, radius: f64, count: usize) -> impl Iterator<Item = DVec3> {
    let ahead = from.normalize();
    let (across, up) = ahead.any_orthonormal_pair();
    let golden = PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |i| {
        let (r, turn) = (radius * ((i as f64 + 0.5) / count as f64).sqrt(), golden * i as f64);
        r * (turn.cos() * across + turn.sin() * up)
    })
}

/// How far the answers of a soft light are from the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SoftError {
    /// Share of the receivers that truly see a part of the sphere.
    pub penumbra_fraction: f64,
    /// Root of the mean square of all errors.
    pub rms: f64,
    /// The same in penumbras alone.
    pub penumbra_rms: f64,
    /// The error that 99 % stay below.
    pub p99: f64,
    /// The worst error.
    pub worst: f64,
}

/// Figures about `values`, given the [shares](shares_of_sphere) that are true.
#[must_use]
pub fn soft_error(values: &[f32], shares: &[f64]) -> SoftError {
    let errors: Vec<(f64, bool)> = values
        .iter()
        .zip(shares)
        .map(|(value, share)| ((f64::from(*value) - share).abs(), *share > 0.0 && *share < 1.0))
        .collect();
    let rms = |of: &dyn Fn(bool) -> bool| {
        let squares: Vec<f64> = errors.iter().filter(|(_, part)| of(*part)).map(|(error, _)| error * error).collect();
        (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
    };
    let mut sorted: Vec<f64> = errors.iter().map(|(error, _)| *error).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    SoftError {
        penumbra_fraction: errors.iter().filter(|(_, part)| *part).count() as f64 / errors.len().max(1) as f64,
        rms: rms(&|_| true),
        penumbra_rms: rms(&|part| part),
        p99: sorted.get(sorted.len() * 99 / 100).copied().unwrap_or_default(),
        worst: sorted.last().copied().unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::test_shapes::sheet;
    use glam::{DQuat, Vec3};

    /// Half of the light's disc and more, hidden by a straight edge: the share has a closed form.
    #[test]
    fn shares_behind_an_edge() {
        let mut scene = sheet(DVec3::new(-9.0, -9.0, 4.0), DVec3::X * 18.0, DVec3::Y * 18.0);
        scene.extend(sheet(DVec3::new(0.0, -9.0, 1.0), DVec3::X * 9.0, DVec3::Y * 18.0));
        let light = DVec3::new(0.5, 0.25, -0.125);
        let corners: Vec<_> = scene.iter().map(|triangle| triangle.map(|corner| corner + light)).collect();
        let reference = Reference::new(&corners, None, light);
        let view = View { position: light, orientation: DQuat::IDENTITY, near: 0.01, range: f64::INFINITY };
        let radius = 0.2;
        for share_of_radius in [-1.2, -0.7, -0.2, 0.0, 0.3, 0.9, 1.1] {
            // From the wall, the light's middle is so far from the edge's outline: similar triangles.
            let x = share_of_radius * radius * (4.0 - 1.0) / 1.0;
            let position = (light + DVec3::new(x, 0.0, 4.0)).as_vec3();
            let receiver = Receiver { position, normal: Vec3::Z, triangle: 0, rounding: 1e-6 };
            let share = shares_of_sphere(&[receiver], &reference, &view, radius, 4096)[0];
            let t = f64::clamp(share_of_radius, -1.0, 1.0);
            let expected = 0.5 - (t.asin() + t * (1.0 - t * t).sqrt()) / PI;
            // The disc faces the receiver and not the wall.
            assert!((share - expected).abs() < 0.01, "{share_of_radius}: {share}, not {expected}");
        }
    }

    #[test]
    fn errors_of_penumbras_are_told_apart() {
        let error = soft_error(&[1.0, 0.5, 0.2, 0.0], &[1.0, 0.9, 0.2, 0.0]);
        let expected = [0.5, 0.2, (0.16f64 / 2.0).sqrt(), 0.4];
        let found = [error.penumbra_fraction, error.rms, error.penumbra_rms, error.worst];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{error:?}");
        assert_eq!(soft_error(&[], &[]), SoftError::default());
    }
}
