//! What holds of any scene. This program asks it of scenes made in code, `tests/scenes` of the test scenes.

use crate::common::{descriptor, gpu, map, unculled_map};
use dual_paraboloid::compare::error_figures::filter_error;
use dual_paraboloid::compare::measure::{Made, Truth, light_for};
use dual_paraboloid::compare::scene::Scene;
use dual_paraboloid::{Casters, Filter, PointLight};
use glam::Vec3;

/// All filters with the settings that they have by default; the soft light has a radius of 0.1.
pub const FILTERS: [Filter; 6] =
    [Filter::Hard, Filter::Sharp, Filter::Pcf3, Filter::Pcf5, Filter::disc(0.01), Filter::soft(0.1)];

/// How far from a silhouette, in texels, a texel's centre may be taken to be on its other side.
pub const MARGIN: f64 = 1e-3;

/// A light's maps of a scene.
pub fn made(scene: &Scene, light: PointLight, resolution: u32) -> Made {
    let made = Made::new(gpu(), scene, light, &descriptor(resolution)).unwrap();
    gpu().wait();
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
    gpu().filtered_values(&made.shadows, &made.casters, made.light, inputs)
}

/// Three standard deviations of a count, in parts per million of `samples`. Library and floor answer for the same
/// receivers; where their maps differ by less than a texel it's chance which of the receivers at a boundary fall
/// between, so that the count of wrong ones varies as that of rare events does, by its root.
pub fn slack_ppm(wrong_ppm: f64, samples: usize) -> f64 {
    let count = wrong_ppm * 1e-6 * samples as f64;
    3.0 * count.max(1.0).sqrt() * 1e6 / samples as f64
}

/// Asserts that leaving triangles out changes nothing but the depth of some texels by rounding.
pub fn assert_culling_changes_nothing(casters: &mut Casters, light: PointLight, resolution: u32, name: &str) {
    let culled = map(casters, light, resolution);
    let differences = culled.differences(&unculled_map(casters, light, resolution));
    let beyond_rounding: Vec<_> =
        differences.iter().filter(|(texel, depth)| (texel.depth / depth - 1.0).abs() > 1e-6).collect();
    assert!(
        beyond_rounding.is_empty(),
        "{name} at {resolution}: {} texels differ, as {:?}",
        beyond_rounding.len(),
        &beyond_rounding[..beyond_rounding.len().min(3)]
    );
}

/// Asserts of a scene with holes that at most a hundredth more is wrong than with the ideal map, and that the map is
/// the ray-cast one.
pub fn assert_holes_are_true(scene: &Scene, position: Vec3, resolution: u32, samples: usize) {
    let light = light_for(scene, position);
    let truth = Truth::new(scene, &light, samples, 1);
    let made = Made::new(gpu(), scene, light, &descriptor(resolution)).unwrap();
    let figures = made.figures(gpu(), &truth);
    let (wrong, ideal) = (figures.shadow.error.wrong_ppm, figures.ideal.wrong_ppm);
    assert!(wrong <= 1.01 * ideal + 20.0, "{}: {wrong} of a million are wrong, ideally {ideal}", scene.name);
    assert!(figures.map.silhouette_distance_max <= MARGIN, "{}: {:?}", scene.name, figures.map);
    // Without the holes it would be wrong by far.
    let whole = Made::new(gpu(), &scene.without_holes(), light, &descriptor(resolution)).unwrap();
    let values = gpu().shadow_values(&whole.shadows, &whole.casters, whole.light, &truth.inputs());
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
