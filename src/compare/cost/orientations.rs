//! Errors in maps of random orientations.

use crate::Error;
use crate::compare::baselines::{Baseline, Bias, DeviceScene, Lookup};
use crate::compare::measure::Judge;
use glam::Quat;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::f32::consts::TAU;

/// Random rotations, all alike likely: the same for the same `seed`, and the first of many are the few.
///
/// Uniform by Shoemake, "Uniform Random Rotations", Graphics Gems III (1992).
#[must_use]
pub fn orientations(count: usize, seed: u64) -> Vec<Quat> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut next = || {
        let [share, a, b]: [f32; 3] = std::array::from_fn(|_| random.random_range(0.0..1.0));
        let ((sin_a, cos_a), (sin_b, cos_b)) = ((TAU * a).sin_cos(), (TAU * b).sin_cos());
        let (short, long) = ((1.0 - share).sqrt(), share.sqrt());
        Quat::from_xyzw(short * sin_a, short * cos_a, long * sin_b, long * cos_b).normalize()
    };
    (0..count).map(|_| next()).collect()
}

/// How wrong a lookup is in maps of several orientations.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnedErrors {
    /// Wrong answers of each orientation, in parts per million.
    pub wrong_ppm: Vec<f64>,
    /// The same on fronts alone, without the backs of double-sided surfaces.
    pub wrong_front_ppm: Vec<f64>,
    /// The bias that was found best in the first one, for all; `None` of lookups whose bias is fixed.
    pub bias: Option<Bias>,
}

impl TurnedErrors {
    /// Wrong answers over all orientations, in parts per million: as many receivers were asked in each.
    #[must_use]
    pub fn mean(&self) -> f64 {
        mean(&self.wrong_ppm)
    }

    /// [`Self::mean`] on fronts alone.
    #[must_use]
    pub fn front_mean(&self) -> f64 {
        mean(&self.wrong_front_ppm)
    }
}

fn mean(ppm: &[f64]) -> f64 {
    ppm.iter().sum::<f64>() / ppm.len().max(1) as f64
}

/// Asks all of a method's lookups in maps of all `orientations`, of which the first is that of the judge's light.
///
/// # Errors
/// [`Error::InvalidLight`].
pub fn turned_errors(
    judge: &mut Judge,
    baseline: &mut Baseline,
    scene: &mut DeviceScene,
    orientations: &[Quat],
) -> Result<Vec<(Lookup, TurnedErrors)>, Error> {
    let lookups = baseline.method().lookups();
    let biases = judge.fit(baseline, lookups, scene)?;
    let without = |(&lookup, bias)| (lookup, TurnedErrors { wrong_ppm: Vec::new(), wrong_front_ppm: Vec::new(), bias });
    let mut all: Vec<(Lookup, TurnedErrors)> = lookups.iter().zip(biases).map(without).collect();
    for (number, &orientation) in orientations.iter().enumerate() {
        if number > 0 {
            judge.record(baseline, scene, orientation)?;
        }
        for (lookup, errors) in &mut all {
            if let Some([all, fronts]) = judge.wrong_ppm(baseline, *lookup) {
                errors.wrong_ppm.push(all);
                errors.wrong_front_ppm.push(fronts);
            }
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn they_are_repeatable_and_everywhere() {
        let many = orientations(4000, 7);
        assert_eq!(orientations(8, 7), many[..8]);
        assert_ne!(orientations(8, 8), many[..8]);
        assert!(many.iter().all(|turn| turn.is_normalized()));
        // Where an axis goes is uniform over the sphere, so that each coordinate is uniform over -1..1.
        for axis in Vec3::AXES {
            for coordinate in Vec3::AXES {
                let mut eighths = [0; 8];
                for turn in &many {
                    eighths[(4.0 * ((*turn * axis).dot(coordinate) + 1.0)).clamp(0.0, 7.0) as usize] += 1;
                }
                assert!(eighths.iter().all(|count| (420..580).contains(count)), "{axis} {coordinate}: {eighths:?}");
            }
        }
    }
}
