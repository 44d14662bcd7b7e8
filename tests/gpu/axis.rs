//! The axes of the hemispheres, where a texel spans twice the angle that it spans at the rim: no more error there than
//! elsewhere, texel for texel.

use crate::common::{descriptor, gpu};
use crate::hard_cases::{boxes_around, orientation, room, scene};
use dual_paraboloid::PointLight;
use dual_paraboloid::compare::error_figures::{Receiver, sample_receivers, truth};
use dual_paraboloid::compare::measure::{Made, Truth, light_for};
use dual_paraboloid::compare::scene::Scene;
use dual_paraboloid::paraboloid::double as paraboloid;
use glam::{DVec2, Vec3};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use std::ops::Range;

/// Angles from the nearer axis, in degrees: around it, beside it, and at the rim.
const ZONES: [Range<f64>; 3] = [0.0..10.0, 10.0..25.0, 80.0..90.0];

/// Wrong answers in a zone, and what they are set against.
#[derive(Debug, Clone, Copy, Default)]
struct Zone {
    samples: usize,
    wrong: usize,
    /// Sum over the samples of the angle that a texel spans there, with 1 on the axis. The outline of a shadow that is
    /// drawn with texels of twice the side is wrong over twice the width.
    texels: f64,
}

impl Zone {
    /// Wrong answers per million samples if texels were as large as on the axis.
    fn ppm(&self) -> f64 {
        1e6 * self.wrong as f64 / self.texels
    }
}

/// Map coordinates of a receiver, and its zone.
fn place(truth: &Truth, receiver: &Receiver) -> (DVec2, Option<usize>) {
    let (x, _) = truth.view.to_hemisphere(receiver.relative(truth.view.position));
    let angle = x.normalize().z.acos().to_degrees();
    (paraboloid::project(x), ZONES.iter().position(|zone| zone.contains(&angle)))
}

/// The truth at receivers of the zones; of those at the rim, which are many, an eighth.
fn truth_of_zones(scene: &Scene, light: &PointLight, seed: u64) -> Truth {
    let mut result = Truth::new(scene, light, 0, seed);
    let drawn = sample_receivers(&result.reference, &result.view, 300_000, seed);
    let kept = (0..).zip(drawn).filter(|(number, receiver)| match place(&result, receiver).1 {
        Some(2) => number % 8 == 0,
        zone => zone.is_some(),
    });
    result.receivers = kept.map(|(_, receiver)| receiver).collect();
    result.lit = truth(&result.receivers, &result.reference, &result.view);
    result
}

/// Over many turns of the light every place of the scene comes to each zone alike, so they differ by what the map does
/// there and by chance.
#[test]
fn the_error_at_the_axis_is_the_error_elsewhere() {
    let mut random = Pcg64::seed_from_u64(12);
    let mut meshes = boxes_around(60, 1.0..3.0, &mut random);
    meshes.push(room(4.0));
    let scene = scene(meshes);
    // By votes, whose errors are those of the texels, and by the lookup.
    let mut zones = [[Zone::default(); 3]; 2];
    for turn in 0..16 {
        let light = PointLight { orientation: orientation(&mut random), ..light_for(&scene, Vec3::ZERO) };
        let truth = truth_of_zones(&scene, &light, turn);
        let made = Made::new(gpu(), &scene, light, &descriptor(256)).unwrap();
        let inputs = truth.inputs();
        let votes = gpu().vote_values(&made.shadows, made.light, &inputs);
        let values = gpu().shadow_values(&made.shadows, &made.casters, made.light, &inputs);
        for (zones, values) in zones.iter_mut().zip([votes, values]) {
            for ((receiver, lit), value) in truth.receivers.iter().zip(&truth.lit).zip(values) {
                let (p, Some(zone)) = place(&truth, receiver) else { continue };
                zones[zone].samples += 1;
                zones[zone].wrong += usize::from((value >= 0.5) != *lit);
                zones[zone].texels += paraboloid::texel_angle(p, 0.5);
            }
        }
    }
    for zones in zones {
        let [axis, others @ ..] = zones;
        println!("wrong per million, texel for texel: {:.0?} of {zones:?}", zones.map(|zone| zone.ppm()));
        for other in others {
            // Of a count the root, and of none one.
            let share = |zone: Zone| (zone.wrong.max(1) as f64).sqrt() * 1e6 / zone.texels;
            let chance = 3.0 * share(axis).hypot(share(other));
            assert!(axis.ppm() <= other.ppm() + chance, "{axis:?} {other:?}");
        }
    }
}
