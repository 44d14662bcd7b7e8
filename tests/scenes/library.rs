//! What the library makes of the test scenes.

use crate::claims::{MARGIN, assert_culling_changes_nothing, assert_even_where_it_should_be, assert_holes_are_true};
use crate::common::{descriptor, gpu};
use crate::stated::Stated;
use crate::trial_of;
use dual_paraboloid::compare::fill;
use dual_paraboloid::compare::measure::{Figures, Made, Truth, choose_light, light_for};
use dual_paraboloid::compare::scene::{Scene, known_lights};
use dual_paraboloid::compare::walk::{IdealWalks, STEPS};
use dual_paraboloid::{Casters, PointLight, Sides};
use glam::Vec3;
use libtest_mimic::Trial;

/// Scenes with holes that matter. The sails of `dutch_ship` have none.
const HOLES: [&str; 2] = ["house_masked", "alpha_modes"];

/// Scenes that are asked whether filters leave even light and even dark alone.
const FILTERS: [&str; 3] = ["barn_lamp", "gallery_vr", "lights_level_blenvy"];

pub fn trials_of(scene: &'static Stated) -> Vec<Trial> {
    let mut trials = vec![
        trial_of(scene, "culling", leaving_triangles_out_changes_nothing),
        trial_of(scene, "map", the_map_is_the_ray_cast_one),
    ];
    if HOLES.contains(&scene.name()) {
        trials.push(trial_of(scene, "holes", holes_are_as_true_as_resolution_allows));
    }
    if FILTERS.contains(&scene.name()) {
        trials.push(trial_of(scene, "filters", no_acne_and_no_light_in_the_dark));
    }
    trials
}

/// The lights listed for a scene, or its own.
fn lights(stated: &Stated, scene: &Scene) -> Vec<Vec3> {
    let listed = known_lights(stated.file).iter().copied().map(Vec3::from);
    let own = scene.lights.iter().map(|light| light.position);
    listed.chain(own).collect()
}

fn leaving_triangles_out_changes_nothing(stated: &Stated, scene: &Scene) {
    let mut casters = Casters::new(&gpu().device).unwrap();
    fill(&mut casters, gpu(), scene, Sides::Auto).unwrap();
    let (low, high) = scene.bounds().unwrap();
    let lights = lights(stated, scene);
    assert!(!lights.is_empty(), "no light to ask for");
    for position in lights.into_iter().take(2) {
        let range = low.distance(high) * 2.0;
        let light = PointLight { position, range, near: range * 1e-5, ..Default::default() };
        assert_culling_changes_nothing(&mut casters, light, 512, stated.name());
    }
}

fn the_map_is_the_ray_cast_one(stated: &Stated, scene: &Scene) {
    for position in lights(stated, scene).into_iter().take(2) {
        let light = light_for(scene, position);
        let truth = Truth::new(scene, &light, 20_000, 1);
        let made = Made::new(gpu(), scene, light, &descriptor(256)).unwrap();
        let Figures { map, shadow, .. } = made.figures(gpu(), &truth);
        let (ideal, _) = truth.ideal(made.geometry());
        let rule = IdealWalks::new(scene).shadows(&truth, &ideal, STEPS);
        let wrong = shadow.error.wrong_ppm - truth.judge(&rule).wrong_ppm;
        let off = map.holes + map.phantoms + (map.wrong_surface_ppm * 1e-6 * map.texels as f64).round() as usize;
        assert!(off <= 2 && map.silhouette_distance_max <= MARGIN, "{map:?}");
        assert!(map.depth_error_p99 <= 5e-7 && map.depth_error_max <= 3e-5, "{map:?}");
        assert!(wrong.abs() <= 100.0, "of a million {wrong} more are wrong than by the rule on the ray-cast map");
    }
}

fn holes_are_as_true_as_resolution_allows(stated: &Stated, scene: &Scene) {
    assert_holes_are_true(scene, lights(stated, scene)[0], 256, 50_000);
}

fn no_acne_and_no_light_in_the_dark(_: &Stated, scene: &Scene) {
    let (light, _) = choose_light(scene, None, None);
    assert_even_where_it_should_be(scene, light, 512, 10_000);
}
