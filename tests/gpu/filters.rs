//! Filtered shadows: edges of one width everywhere, no line at the seam, no acne and no light where it is dark, and
//! spheres of light against ray tracing.

use crate::claims::{FILTERS, assert_even_where_it_should_be, filtered, made, record};
use crate::common::{descriptor, gpu};
use crate::hard_cases::{boxes_around, orientation, rod, room, scene};
use dual_paraboloid::compare::area_light::{shares_of_sphere, soft_error};
use dual_paraboloid::compare::error_figures::filter_error;
use dual_paraboloid::compare::measure::{Made, Truth, light_for};
use dual_paraboloid::compare::procedural::shapes::{cuboid, quad};
use dual_paraboloid::compare::scene::Scene;
use dual_paraboloid::{Coverage, Error, Filter, PointLight};
use glam::{Quat, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// The half of a wall's view that a sheet half way to it takes, over the wall, three units before a light at the origin
/// that looks along +Z.
fn half_plane() -> Scene {
    let wall = quad(Vec3::new(-3.0, -3.0, 3.0), Vec3::X * 6.0, Vec3::Y * 6.0);
    let sheet = quad(Vec3::new(0.0, -3.0, 1.5), Vec3::X * 3.0, Vec3::Y * 6.0);
    scene([wall, sheet])
}

/// Points of the wall at these angles from its middle, positive under the sheet.
fn across_the_edge(angles: &[f32]) -> Vec<(Vec3, Vec3)> {
    angles.iter().map(|angle| (Vec3::new(3.0 * angle.tan(), 0.0, 3.0), Vec3::Z)).collect()
}

/// Share of a disc on the lit side of a straight edge, which is so many of its radii from the middle.
fn share_of_disc(distance: f32) -> f32 {
    let t = distance.clamp(-1.0, 1.0);
    0.5 - (t.asin() + t * (1.0 - t * t).sqrt()) / PI
}

/// Turns of the light that put the wall's middle on the front's axis, beside it, near the rim, on it, and on the axis of
/// the back.
const TURNS: [f32; 6] = [0.0, 0.5, 1.3, FRAC_PI_2 - 0.01, FRAC_PI_2, PI];

/// Asserts that an edge is what `expected` says of angles in radii, wherever in the map it lies, and as wide.
fn assert_one_width(filter: Filter, radius: f32) {
    let scene = half_plane();
    let angles: Vec<f32> = (-60..=60).map(|k| 1.5 * radius * k as f32 / 60.0).collect();
    let inputs = across_the_edge(&angles);
    let mut widths = Vec::new();
    for turn in TURNS.iter().flat_map(|angle| [Vec3::X, Vec3::Y].map(|axis| Quat::from_axis_angle(axis, *angle))) {
        let light = PointLight { orientation: turn, filter, ..light_for(&scene, Vec3::ZERO) };
        let made = made(&scene, light, 1024);
        let values = gpu().filtered_values(&made.shadows, &made.casters, made.light, &inputs);
        for (angle, value) in angles.iter().zip(&values) {
            let expected = share_of_disc(angle / radius);
            assert!((value - expected).abs() < 0.06, "{turn}, {angle}: {value}, not {expected}");
        }
        let at = |share: f32| {
            let after = values.iter().position(|value| *value < share).unwrap();
            let (a, b) = (values[after - 1], values[after]);
            angles[after - 1] + (angles[after] - angles[after - 1]) * (a - share) / (a - b)
        };
        widths.push(at(0.25) - at(0.75));
    }
    // Half of the area of a disc is within 0.404 radii of a line through its middle.
    let (low, high) = widths.iter().fold((f32::MAX, 0.0f32), |(low, high), w| (low.min(*w), high.max(*w)));
    println!("{filter:?}: {:.3} to {:.3} of the width", low / (0.808 * radius), high / (0.808 * radius));
    assert!(low > 0.93 * 0.808 * radius && high < 1.07 * 0.808 * radius, "{low} to {high}");
}

#[test]
fn an_edge_of_a_disc_is_as_wide_at_the_rim_as_on_the_axis() {
    assert_one_width(Filter::Disc { radius: 0.04, taps: 128 }, 0.04);
}

/// The sheet is half way to the wall, so its penumbra is as wide to the light as the sphere to the wall.
#[test]
fn a_penumbra_is_as_wide_at_the_rim_as_on_the_axis() {
    assert_one_width(Filter::Soft { light_radius: 0.12, taps: 128 }, 0.04);
}

/// A wall is lit up to a block that stands on it: what rises beside a receiver isn't in its way.
#[test]
fn creases_are_not_dark() {
    let wall = quad(Vec3::new(-3.0, -3.0, 3.0), Vec3::X * 6.0, Vec3::Y * 6.0);
    let block = cuboid(Vec3::new(0.0, -3.0, 2.9), Vec3::new(2.0, 3.0, 3.0));
    let scene = scene([wall, block]);
    let light = PointLight { filter: Filter::soft(0.1), ..light_for(&scene, Vec3::new(-2.0, 0.0, 0.0)) };
    let mut made = made(&scene, light, 1024);
    let points: Vec<_> = (1..100).map(|k| (Vec3::new(-0.02 * k as f32, 0.1, 3.0), Vec3::Z)).collect();
    for filter in FILTERS {
        let dark = filtered(&mut made, light, filter, &points).into_iter().filter(|value| *value < 0.99).count();
        // Only a fixed disc darkens the crease, 0.01 radians of 3.6 wide.
        let allowed = if matches!(filter, Filter::Disc { .. }) { 3 } else { 1 };
        assert!(dark <= allowed, "{filter:?}: {dark} points beside the block are dark");
    }
}

/// Steps along paths across the seam, in random directions: how far each filter's values differ over each step, as the
/// root of the mean square over the paths, and at most. The middle step crosses.
fn steps_across_the_seam(filters: &[Filter], spacing: f32) -> Vec<Vec<(f64, f64)>> {
    const STEPS: usize = 9;
    let mut random = Pcg64::seed_from_u64(5);
    let mut meshes = boxes_around(60, 1.0..3.0, &mut random);
    meshes.push(room(4.0));
    let scene = scene(meshes);
    let mut squares = vec![vec![(0.0, 0.0f64); STEPS]; filters.len()];
    let mut paths = 0;
    for _ in 0..4 {
        let light = PointLight { orientation: orientation(&mut random), ..light_for(&scene, Vec3::ZERO) };
        let truth = Truth::new(&scene, &light, 0, 1);
        let mut inputs = Vec::new();
        for _ in 0..600 {
            let turn = random.random_range(0.0..TAU);
            let path: Vec<_> = (0..=STEPS)
                .filter_map(|k| {
                    let angle = spacing * (k as f32 - 0.5 * STEPS as f32);
                    let d = Vec3::new(turn.cos() * angle.cos(), turn.sin() * angle.cos(), angle.sin());
                    let d = (light.orientation * d).as_dvec3().normalize();
                    let hit = truth.reference.nearest(d, 0.0)?;
                    Some((hit.triangle / 2, ((d * hit.t).as_vec3(), truth.reference.normal(hit.triangle).as_vec3())))
                })
                .collect();
            // Where the surface ends there are steps of another kind.
            if path.iter().all(|(face, _)| *face == path[0].0) {
                inputs.extend(path.into_iter().map(|(_, input)| input));
                paths += 1;
            }
        }
        let mut made = made(&scene, light, 256);
        for (filter, squares) in filters.iter().zip(&mut squares) {
            for path in filtered(&mut made, light, *filter, &inputs).chunks_exact(STEPS + 1) {
                for (pair, square) in path.windows(2).zip(&mut *squares) {
                    let change = f64::from((pair[1] - pair[0]).abs());
                    *square = (square.0 + change * change, square.1.max(change));
                }
            }
        }
    }
    let rms = |(sum, most): (f64, f64)| ((sum / f64::from(paths)).sqrt(), most);
    squares.into_iter().map(|steps| steps.into_iter().map(rms).collect()).collect()
}

#[test]
fn no_filter_shows_the_seam() {
    let wide = [1.0f32, 5.0, 20.0].map(|degrees| Filter::Disc { radius: degrees.to_radians(), taps: 64 });
    // Sharp edges are steps anywhere.
    let filters = [&FILTERS[2..], &wide].concat();
    // Half a texel at the rim of 256.
    for (filter, mut steps) in filters.iter().zip(steps_across_the_seam(&filters, 0.5 * 2.0 * 1.03 / 256.0)) {
        let crossing = steps.remove(4);
        let (rms, most) = steps.iter().fold((0.0f64, 0.0f64), |(a, b), step| (a.max(step.0), b.max(step.1)));
        println!("{filter:?}: {:.4} (most {:.3}), elsewhere {rms:.4} (most {most:.3})", crossing.0, crossing.1);
        assert!(rms > 0.0 && crossing.0 <= 1.25 * rms && crossing.1 <= 1.1 * most, "{filter:?}: {crossing:?}");
    }
}

fn furnished() -> Scene {
    let mut meshes = boxes_around(40, 1.0..3.5, &mut Pcg64::seed_from_u64(21));
    meshes.push(room(4.0));
    scene(meshes)
}

#[test]
fn no_acne_and_no_light_in_the_dark() {
    let scene = furnished();
    let light = PointLight { orientation: Quat::from_rotation_x(0.9), ..light_for(&scene, Vec3::ZERO) };
    assert_even_where_it_should_be(&scene, light, 512, 20_000);
}

/// Under a plate that is near the wall it is dark, however wide the penumbras that bars nearer to the light throw there.
#[test]
fn wide_penumbras_beside_it_let_no_light_under_a_caster() {
    let wall = quad(Vec3::new(-3.0, -3.0, 3.0), Vec3::X * 6.0, Vec3::Y * 6.0);
    let plate = quad(Vec3::new(0.0, -3.0, 2.65), Vec3::X * 3.0, Vec3::Y * 6.0);
    let bars = (-8..=8).map(|k| Vec3::new(0.05 * k as f32 - 0.02, 0.0, 1.8));
    let bars = bars.map(|at| rod(at - Vec3::Y, at + Vec3::Y, 0.008));
    let scene = scene([wall, plate].into_iter().chain(bars));
    // The plate's penumbra and a texel and a half more, as seen from the light.
    let dark_from = 0.1 / 3.0 * (3.0 / 2.65 - 1.0) + 1.5 * 0.004;
    let angles: Vec<f32> = (0..100).map(|k| dark_from + 0.0002 * k as f32).collect();
    for turn in TURNS {
        let orientation = Quat::from_rotation_x(turn);
        let light = PointLight { orientation, filter: Filter::soft(0.1), ..light_for(&scene, Vec3::ZERO) };
        let made = made(&scene, light, 1024);
        let values = gpu().filtered_values(&made.shadows, &made.casters, made.light, &across_the_edge(&angles));
        let lit = values.iter().filter(|value| **value > 0.01).count();
        assert_eq!(lit, 0, "{turn}: {values:?}");
    }
}

/// Poles around the light, seen edge-on by half of their faces. They are two texels wide, so that some hundreds per million
/// are in false shadow.
#[test]
fn poles_seen_edge_on_have_no_acne() {
    let at = |k: i32| Vec3::new((0.07 * k as f32).cos(), (0.07 * k as f32).sin(), 0.0) * 0.8;
    let scene = scene((0..90).map(|k| rod(at(k) - 3.0 * Vec3::Z, at(k) + 6.0 * Vec3::Z, 0.01)));
    let light = PointLight { filter: Filter::Pcf3, ..light_for(&scene, Vec3::ZERO) };
    let truth = Truth::new(&scene, &light, 20_000, 1);
    let made = Made::new(gpu(), &scene, light, &descriptor(256)).unwrap();
    let values = gpu().filtered_values(&made.shadows, &made.casters, made.light, &truth.inputs());
    let acne = filter_error(&truth, &values, &made.geometry(), light.filter).acne_ppm;
    assert!(acne <= 1000.0, "{acne} per million are in false shadow");
}

/// Poles of a few texels across the seam, along it and across the axes of a light that is turned by an eighth.
fn poles() -> Scene {
    let turn = Quat::from_rotation_x(FRAC_PI_4);
    let seam = [(1.5, 0.3), (-1.2, 0.9), (0.4, -1.7)].map(|(x, y)| Vec3::new(x, y, 0.0));
    let across = seam.map(|at| rod(turn * (at - Vec3::Z * 2.5), turn * (at + Vec3::Z * 2.5), 0.06));
    let ends = [(1.3, -1.0, 1.0), (-1.9, -1.0, 1.3), (0.02, 1.4, 1.9)];
    let along =
        ends.map(|(z, left, right)| rod(turn * Vec3::new(-2.5, left, z), turn * Vec3::new(2.5, right, z), 0.06));
    scene(across.into_iter().chain(along).chain([room(4.0)]))
}

/// Spheres of light over plates and among boxes, against rays.
#[test]
fn soft_shadows_are_those_of_a_sphere() {
    let plate = |y: f32, half: f32| cuboid(Vec3::new(-half, y - 0.01, -half), Vec3::new(half, y + 0.01, half));
    let cases = [
        ("a plate half way", scene([room(4.0), plate(-2.0, 0.5)]), 0.06),
        ("a plate near the light", scene([room(4.0), plate(-0.6, 0.1)]), 0.08),
        ("a plate near the floor", scene([room(4.0), plate(-2.9, 0.9)]), 0.12),
        ("boxes", furnished(), 0.12),
        ("poles across the seam and the axes", poles(), 0.12),
    ];
    for (name, scene, allowed) in cases {
        for radius in [0.1, 0.25] {
            let light = PointLight {
                filter: Filter::soft(radius),
                orientation: Quat::from_rotation_x(FRAC_PI_4),
                ..light_for(&scene, Vec3::ZERO)
            };
            let truth = Truth::new(&scene, &light, 6000, 1);
            let shares = shares_of_sphere(&truth.receivers, &truth.reference, &truth.view, f64::from(radius), 256);
            let mut made = made(&scene, light, 512);
            let soft = soft_error(&filtered(&mut made, light, light.filter, &truth.inputs()), &shares);
            let point = soft_error(&filtered(&mut made, light, Filter::Sharp, &truth.inputs()), &shares);
            println!("{name}, {radius}: {soft:.4?}; unfiltered {:.4}", point.penumbra_rms);
            assert!(soft.penumbra_rms < allowed, "{name}, {radius}: {soft:?}");
            assert!(soft.penumbra_rms < 0.6 * point.penumbra_rms, "{name}, {radius}: no better than unfiltered");
        }
    }
}

#[test]
fn filters_by_name_are_those_of_the_light() {
    let scene = furnished();
    let light = PointLight { orientation: Quat::from_rotation_x(0.4), ..light_for(&scene, Vec3::ZERO) };
    let mut made = made(&scene, light, 128);
    let inputs = Truth::new(&scene, &light, 2000, 5).inputs();
    let sharp = filtered(&mut made, light, Filter::Sharp, &inputs);
    assert_eq!(sharp, gpu().shadow_values(&made.shadows, &made.casters, made.light, &inputs));
    let names = ["dp_shadow_hard", "", "dp_shadow_pcf3", "dp_shadow_pcf5", "dp_shadow_disc", "dp_shadow_soft"];
    for (filter, name) in FILTERS.into_iter().zip(names).filter(|(_, name)| !name.is_empty()) {
        let own = filtered(&mut made, light, filter, &inputs);
        let call = format!("{name}(0u, position, normal, view, 0.0)");
        assert_eq!(own, gpu().lookup_values(&made.shadows, &made.casters, &call, &inputs), "{name}");
        assert!(own != sharp || filter == Filter::Hard, "{name}");
        assert!(own.iter().all(|share| (0.0..=1.0).contains(share)), "{name}");
    }
    let hard = filtered(&mut made, light, Filter::Hard, &inputs);
    let decided = sharp.iter().map(|share| if *share >= 0.5 { 1.0 } else { 0.0 });
    assert_eq!(hard, decided.collect::<Vec<f32>>());
    // Without a size of their own both are unfiltered.
    for filter in [Filter::Disc { radius: 0.0, taps: 1 }, Filter::Soft { light_radius: 0.0, taps: 1 }] {
        let values = filtered(&mut made, light, filter, &inputs);
        let off = values.iter().zip(&sharp).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 1e-5, "{filter:?}: {off}");
    }
}

/// Of one hemisphere alone, what is behind is dark, in part of the kernel too.
#[test]
fn behind_one_hemisphere_it_is_dark() {
    let scene = scene([room(4.0)]);
    let light = PointLight { coverage: Coverage::Hemisphere, ..light_for(&scene, Vec3::ZERO) };
    let radius = 0.1;
    let mut made = made(&scene, light, 256);
    let angles = [-0.05f32, 0.001, 0.05, 0.12];
    let inputs: Vec<_> = angles.iter().map(|angle| (Vec3::new(4.0, 0.5, 4.0 * angle.tan()), Vec3::X)).collect();
    let values = filtered(&mut made, light, Filter::Disc { radius, taps: 256 }, &inputs);
    for (angle, value) in angles.iter().zip(values) {
        let expected = if *angle < 0.0 { 0.0 } else { share_of_disc(-angle / radius) };
        assert!((value - expected).abs() < 0.03, "{angle}: {value}, not {expected}");
    }
}

#[test]
fn wrong_settings_are_refused() {
    let scene = scene([room(4.0)]);
    let good = light_for(&scene, Vec3::ZERO);
    let mut made = made(&scene, good, 32);
    let wrong = [
        ("filter's radius", Filter::Disc { radius: -0.1, taps: 8 }),
        ("filter's radius", Filter::Disc { radius: f32::NAN, taps: 8 }),
        ("filter's radius", Filter::Disc { radius: 0.36, taps: 8 }),
        ("filter's number of taps", Filter::Disc { radius: 0.1, taps: 0 }),
        ("filter's number of taps", Filter::Disc { radius: 0.1, taps: 257 }),
        ("filter's light radius", Filter::Soft { light_radius: -1.0, taps: 8 }),
        ("filter's light radius", Filter::Soft { light_radius: f32::NAN, taps: 8 }),
        ("filter's light radius", Filter::Soft { light_radius: f32::INFINITY, taps: 8 }),
        ("filter's number of taps", Filter::Soft { light_radius: 1.0, taps: 0 }),
    ];
    for (name, filter) in wrong {
        match made.shadows.set(made.light, PointLight { filter, ..good }) {
            Err(Error::InvalidLight { what, .. }) => assert_eq!(what, name),
            other => panic!("{filter:?}: {other:?}"),
        }
    }
    assert_eq!(record(&mut made), 0, "refused values made the light stale");
}

/// At the light, without a normal, on the axes, in the light's plane, inside of the sphere, in the smallest maps: some
/// share.
#[test]
fn degenerate_receivers_have_a_share() {
    let scene = scene([room(4.0)]);
    let light = light_for(&scene, Vec3::ZERO);
    let points = [Vec3::ZERO, 1e-30 * Vec3::X, Vec3::Z, Vec3::NEG_Z, Vec3::X, Vec3::new(0.3, 0.0, -4.0)];
    let normals = [Vec3::ZERO, Vec3::X, Vec3::Z, 1e-20 * Vec3::Y];
    let inputs: Vec<_> = points.iter().flat_map(|point| normals.map(|normal| (*point, normal))).collect();
    for resolution in [1, 2, 16, 256] {
        let mut made = made(&scene, light, resolution);
        let extreme = [
            Filter::Disc { radius: Filter::WIDEST, taps: 1 },
            Filter::Soft { light_radius: 1e30, taps: 3 },
            Filter::soft(3.0),
        ];
        for filter in FILTERS.into_iter().chain(extreme) {
            for (value, input) in filtered(&mut made, light, filter, &inputs).iter().zip(&inputs) {
                assert!((0.0..=1.0).contains(value), "{filter:?} at {resolution}: {value} at {input:?}");
            }
        }
    }
}

#[test]
fn noise_turns_the_taps() {
    let scene = half_plane();
    let angles: Vec<f32> = (-20..=20).map(|k| 0.002 * k as f32).collect();
    let inputs = across_the_edge(&angles);
    for filter in [Filter::disc(0.05), Filter::soft(0.1)] {
        let light = PointLight { filter, ..light_for(&scene, Vec3::ZERO) };
        let made = made(&scene, light, 256);
        let with_noise = |noise: f32| {
            let call = format!("dp_shadow_filtered({}u, position, normal, view, {noise:?})", made.light.index());
            gpu().lookup_values(&made.shadows, &made.casters, &call, &inputs)
        };
        let [still, turned] = [0.0, 0.37].map(with_noise);
        let differing = still.iter().zip(&turned).filter(|(a, b)| (*a - *b).abs() > 1e-3).count();
        assert!(differing > 20, "{filter:?}: {differing} of {} samples in the penumbra", inputs.len());
        // Twice the same is the same, and another turn is no other penumbra.
        assert_eq!(turned, with_noise(0.37));
        let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
        assert!((mean(&still) - mean(&turned)).abs() < 0.03, "{filter:?}: {} and {}", mean(&still), mean(&turned));
    }
}
