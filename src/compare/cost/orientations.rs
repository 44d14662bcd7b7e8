//! How maps are turned while errors are counted.

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
        // Each axis goes to each octant as often as to the others.
        for axis in Vec3::AXES {
            let mut octants = [0; 8];
            for turn in &many {
                let to = *turn * axis;
                octants[usize::from(to.x > 0.0) + 2 * usize::from(to.y > 0.0) + 4 * usize::from(to.z > 0.0)] += 1;
            }
            assert!(octants.iter().all(|count| (400..600).contains(count)), "{octants:?}");
        }
    }
}
