//! The join of the two hemispheres: no more error there than elsewhere, and one hemisphere alone.

use crate::common::{box_inside, descriptor, gpu, record, soup};
use crate::hard_cases::{boxes_around, orientation, room, scene};
use dual_paraboloid::compare::measure::{Made, Truth, light_for};
use dual_paraboloid::{Coverage, PointLight, PointShadows, Sides};
use glam::Vec3;
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// Receivers between two angles from the plane of the seam, in degrees: how many, and how many wrong.
fn wrong_between(truth: &Truth, values: &[f32], angles: std::ops::Range<f64>) -> (usize, usize) {
    let mut counts = (0, 0);
    for ((receiver, lit), value) in truth.receivers.iter().zip(&truth.lit).zip(values) {
        let x = truth.view.orientation.inverse() * receiver.relative(truth.view.position).normalize();
        if angles.contains(&x.z.abs().asin().to_degrees()) {
            counts.0 += 1;
            counts.1 += usize::from((*value >= 0.5) != *lit);
        }
    }
    counts
}

/// Over many turns of the light every place of the scene comes to the seam and to the band beside it alike, so the two
/// differ by what the seam does and by chance.
#[test]
fn the_error_at_the_seam_is_the_error_beside_it() {
    let mut random = Pcg64::seed_from_u64(11);
    let mut meshes = boxes_around(60, 1.0..3.0, &mut random);
    meshes.push(room(4.0));
    let scene = scene(meshes);
    let (mut seam, mut beside) = ((0, 0), (0, 0));
    for turn in 0..24 {
        let light = PointLight { orientation: orientation(&mut random), ..light_for(&scene, Vec3::ZERO) };
        let truth = Truth::new(&scene, &light, 60_000, turn);
        let made = Made::new(gpu(), &scene, light, &descriptor(256)).unwrap();
        let values = gpu().shadow_values(&made.shadows, &made.casters, made.light, &truth.inputs());
        let (a, b) = (wrong_between(&truth, &values, 0.0..2.0), wrong_between(&truth, &values, 2.0..6.0));
        seam = (seam.0 + a.0, seam.1 + a.1);
        beside = (beside.0 + b.0, beside.1 + b.1);
    }
    let rate = |(all, wrong): (usize, usize)| wrong as f64 / all as f64;
    let chance = 3.0 * rate(beside) * (1.0 / seam.1 as f64 + 1.0 / beside.1 as f64).sqrt();
    println!("seam {:.0} ppm of {}, beside it {:.0} ppm of {}", rate(seam) * 1e6, seam.0, rate(beside) * 1e6, beside.0);
    assert!(rate(seam) <= rate(beside) + chance, "{seam:?} {beside:?}");
}

#[test]
fn one_hemisphere_is_half_of_both() {
    let mut casters = soup(&box_inside(Vec3::new(-2.0, -1.0, -3.0), Vec3::new(2.5, 2.0, 1.5)), Sides::Auto);
    let full = PointLight { position: Vec3::new(0.2, 0.1, -0.3), ..Default::default() };
    let mut made = |light| {
        let shadows = PointShadows::new(&gpu().device, &descriptor(128)).unwrap();
        record(shadows, &mut casters, light)
    };
    let (both, a) = made(full);
    let (one, b) = made(PointLight { coverage: Coverage::Hemisphere, ..full });
    let (both_maps, one_map) = (gpu().read_map(&both, a), gpu().read_map(&one, b));
    for (row, (left, right)) in both_maps.chunks(256).zip(one_map.chunks(256)).enumerate() {
        assert!(left[..128] == right[..128], "the front differs in row {row}");
        assert!(right[128..].iter().all(|depth| *depth == 0.0), "something behind in row {row}");
    }
    let receivers: Vec<(Vec3, Vec3)> =
        (0..100).map(|i| (Vec3::new(0.3, 0.05, -1.5 + 0.03 * i as f32), Vec3::new(0.1, 1.0, 0.2))).collect();
    let values =
        [(&both, a), (&one, b)].map(|(shadows, light)| gpu().shadow_values(shadows, &casters, light, &receivers));
    let [full, half] = values;
    for ((position, _), (full, half)) in receivers.iter().zip(full.into_iter().zip(half)) {
        let expected = if position.z < -0.3 { 0.0 } else { full };
        assert_eq!(half, expected, "at {position}");
    }
}
