//! What holds of any scene. This program asks it of scenes made in code, `tests/scenes` of the test scenes.

use crate::common::{descriptor, gpu, map, unrouted_map};
use dual_paraboloid::compare::error_figures::filter_error;
use dual_paraboloid::compare::ideal::{NO_TRIANGLE, ideal_map};
use dual_paraboloid::compare::measure::{Made, Truth, light_for};
use dual_paraboloid::compare::scene::Scene;
use dual_paraboloid::paraboloid::double as paraboloid;
use dual_paraboloid::{Casters, Filter, PointLight};
use glam::Vec3;

/// All filters with the settings that they have by default; the soft light has a radius of 0.1.
pub const FILTERS: [Filter; 6] =
    [Filter::Hard, Filter::Bilinear, Filter::Pcf3, Filter::Pcf5, Filter::disc(0.01), Filter::soft(0.1)];

/// A light's maps of a scene, with room for every piece.
pub fn made(scene: &Scene, light: PointLight, resolution: u32) -> Made {
    let mut made = Made::new(gpu(), scene, light, &descriptor(resolution)).unwrap();
    gpu().wait();
    record(&mut made);
    made
}

/// Records again, and returns the number of maps made anew.
pub fn record(made: &mut Made) -> u32 {
    let Made { shadows, casters, .. } = made;
    let count = gpu().submit(|encoder| shadows.record(&gpu().device, &gpu().queue, encoder, casters)).unwrap();
    gpu().wait();
    count
}

/// Answers by another filter of the same map.
pub fn filtered(made: &mut Made, light: PointLight, filter: Filter, inputs: &[(Vec3, Vec3)]) -> Vec<f32> {
    made.shadows.set(made.light, PointLight { filter, ..light }).unwrap();
    assert_eq!(record(made), 0, "another filter made the map stale");
    gpu().filtered_values(&made.shadows, made.light, inputs)
}

/// Three standard deviations of a count, in parts per million of `samples`. Library and floor answer for the same
/// receivers; where their maps differ by less than a texel it's chance which of the receivers at a boundary fall
/// between, so that the count of wrong ones varies as that of rare events does, by its root.
pub fn slack_ppm(wrong_ppm: f64, samples: usize) -> f64 {
    let count = wrong_ppm * 1e-6 * samples as f64;
    3.0 * count.max(1.0).sqrt() * 1e6 / samples as f64
}

/// Asserts that leaving triangles out changes no bit of a map.
pub fn assert_routed_is_unrouted(casters: &mut Casters, light: PointLight, resolution: u32, name: &str) {
    let routed = map(casters, light, resolution);
    let differences = routed.differences(&unrouted_map(casters, light, resolution));
    assert!(
        differences.is_empty(),
        "{name} at {resolution}: {} texels differ, as {:?}",
        differences.len(),
        &differences[..differences.len().min(3)]
    );
}

/// Asserts of a scene with holes that at most a tenth more is wrong than with the ideal map, and that no wrong texel is
/// away from a silhouette.
pub fn assert_holes_are_true(scene: &Scene, position: Vec3, resolution: u32, samples: usize) {
    let light = light_for(scene, position);
    let truth = Truth::new(scene, &light, samples, 1);
    let made = Made::new(gpu(), scene, light, &descriptor(resolution)).unwrap();
    let figures = made.figures(gpu(), &truth);
    let (wrong, ideal) = (figures.shadow.error.wrong_ppm, figures.ideal.wrong_ppm);
    assert!(wrong <= 1.1 * ideal, "{}: {wrong} of a million are wrong, ideally {ideal}", scene.name);
    assert_eq!(figures.map.strays, 0, "{}: {:?}", scene.name, figures.map);
    // Without the holes it would be wrong by far.
    let whole = Made::new(gpu(), &scene.without_holes(), light, &descriptor(resolution)).unwrap();
    let values = gpu().shadow_values(&whole.shadows, whole.light, &truth.inputs());
    assert!(truth.wrong_ppm(&values) > 1.2 * wrong, "{} has no holes that matter", scene.name);
}

/// Asserts for all filters that surfaces in the light are lit and those in the dark are dark, where all of the kernel
/// is: at 99.99 % and at 99.9 % of the samples, within chance.
pub fn assert_even_where_it_should_be(scene: &Scene, light: PointLight, resolution: u32, samples: usize) {
    let mut made = made(scene, light, resolution);
    let truth = Truth::new(scene, &light, samples, 3);
    for filter in FILTERS {
        let filter = match filter {
            Filter::Soft { .. } => Filter::soft(0.005 * light.range),
            other => other,
        };
        let values = filtered(&mut made, light, filter, &truth.inputs());
        let error = filter_error(&truth, &values, &made.geometry(), filter);
        let (acne, underlight) = (100.0 + slack_ppm(100.0, samples), 1000.0 + slack_ppm(1000.0, samples));
        let is_even = error.acne_ppm <= acne && error.underlight_ppm <= underlight;
        assert!(is_even, "{}, {filter:?}: {error:?}", scene.name);
    }
}

/// How far a texel's depth is off the surface that the ray through its centre meets, in texel footprints along the
/// surface's normal, for each texel that is a texel or more inside a triangle: whose eight neighbours see the same one.
/// Infinite where the map is empty.
pub fn surface_errors(made: &Made, truth: &Truth) -> Vec<f64> {
    let geometry = made.geometry();
    let ideal = ideal_map(&truth.reference, &truth.view, geometry);
    let stored = gpu().read_map(&made.shadows, made.light);
    let is_inside = |back: bool, i: u32, j: u32| {
        let triangle = ideal.triangles[geometry.index(back, i, j)];
        let mut around = (i - 1..=i + 1).flat_map(|i| (j - 1..=j + 1).map(move |j| (i, j)));
        triangle != NO_TRIANGLE && around.all(|(i, j)| ideal.triangles[geometry.index(back, i, j)] == triangle)
    };
    let error = |index: usize| {
        let (back, i, j) = geometry.texel_at(index);
        let p = geometry.centre(i, j);
        // In the discs no texel is at the image's border.
        if p.length() > 1.0 + geometry.guard - 2.0 * geometry.texel() || !is_inside(back, i, j) {
            return None;
        }
        let distance = |depth: f64| truth.view.near / depth * paraboloid::unproject_scaled(p).length();
        let point = truth.view.to_world(paraboloid::unproject(p), back) * distance(f64::from(stored[index]));
        let footprint = distance(ideal.depths[index]) * paraboloid::texel_angle(p, geometry.texel());
        let height = truth.reference.height(point, ideal.triangles[index]).abs() / footprint;
        Some(if height.is_finite() { height } else { f64::INFINITY })
    };
    (0..geometry.texels()).filter_map(error).collect()
}

/// Asserts that a scene has more pieces than a first recording has room for, which then draws what found none exactly, and
/// that the maps of this recording and of the next, which has room, are both those of rays.
pub fn assert_exact_without_room(scene: &Scene, light: PointLight) {
    let truth = Truth::new(scene, &light, 100, 1);
    let mut made = Made::new(gpu(), scene, light, &descriptor(64)).unwrap();
    gpu().wait();
    // The split's error in depth, 4/3 of a tolerance of a tenth, and half a step of the rasteriser's grid.
    let bound = 0.1 * 4.0 / 3.0 + 0.5 / 256.0;
    for lacks_room in [true, false] {
        let statistics = gpu().statistics(&made.shadows);
        assert_eq!(statistics.without_room[0] > 0, lacks_room, "{statistics:?}");
        let errors = surface_errors(&made, &truth);
        assert!(errors.len() > 500, "{} texels are inside a triangle", errors.len());
        let off = errors.iter().filter(|error| **error > bound).count();
        let worst = errors.iter().copied().fold(0.0, f64::max);
        assert_eq!(off, 0, "of {} texels, by up to {worst} footprints; {statistics:?}", errors.len());
        // At an edge a texel may show the other side of it: edges are drawn within two fifths of the tolerance of their place,
        // and on the rasteriser's grid. An eighth of a texel is what the search for silhouettes resolves above that.
        let map = made.figures(gpu(), &truth).map;
        assert!(map.silhouette_distance_max <= 0.125, "{map:?}; {statistics:?}");
        record(&mut made);
    }
}
