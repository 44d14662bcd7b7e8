//! What is loaded from a scene's file, and where a light and a camera are put in it.

use crate::stated::{SCENES, Stated};
use crate::{trial, trial_of, trial_of_folder};
use dual_paraboloid::compare::scene::{Alpha, LIGHTS, Scene, known_lights};
use glam::Vec3;
use libtest_mimic::Trial;
use std::path::Path;

/// Scenes whose first so many listed lights are in a room. The gallery has no roof, and its third light hangs where that
/// shows.
const ROOMS: [(&str, usize); 3] = [("interior_pandora", 5), ("gallery_vr", 2), ("fog_arcade_bevy", 3)];

pub fn trials() -> Vec<Trial> {
    vec![
        trial("listed_lights_belong_to_stated_scenes", listed_lights_belong_to_stated_scenes),
        trial_of_folder("every_file_of_the_folder_is_stated", every_file_of_the_folder_is_stated),
    ]
}

pub fn trials_of(scene: &'static Stated) -> Vec<Trial> {
    let mut trials = vec![
        trial_of(scene, "numbers", numbers_are_those_stated),
        trial_of(scene, "suggestions", suggestions_are_finite_and_repeatable),
    ];
    if ROOMS.iter().any(|(room, _)| *room == scene.name()) {
        trials.push(trial_of(scene, "camera", a_light_in_a_room_gets_a_camera_in_the_room));
    }
    if scene.mirrored > 0 {
        trials.push(trial_of(scene, "triangles", world_triangles_run_in_parallel_and_within_bounds));
    }
    trials
}

fn numbers_are_those_stated(stated: &Stated, scene: &Scene) {
    assert_eq!(scene.triangle_count(), stated.triangles, "triangles");
    assert_eq!(scene.instances.len(), stated.instances, "instances");
    let mirrored = scene.instances.iter().filter(|instance| instance.transform.matrix3.determinant() < 0.0);
    assert_eq!(mirrored.count(), stated.mirrored, "mirrored instances");
    assert_eq!(scene.lights.len(), stated.point_lights, "point lights");
    assert_eq!(scene.images.len(), stated.images, "images");
    let count = |has: fn(Alpha) -> bool| scene.materials.iter().filter(|material| has(material.alpha)).count();
    let masked = count(|alpha| matches!(alpha, Alpha::Mask { .. }));
    let blended = count(|alpha| matches!(alpha, Alpha::Blend));
    assert_eq!([masked, blended], stated.mask_blend, "materials with mask and blend");
    let (low, high) = scene.bounds().expect("a loaded scene is not empty");
    // The source states three decimals.
    assert!(low.abs_diff_eq(stated.low.into(), 6e-4), "low {low}");
    assert!(high.abs_diff_eq(stated.high.into(), 6e-4), "high {high}");
}

fn every_file_of_the_folder_is_stated(folder: &Path) {
    for entry in folder.read_dir().expect("the folder can be listed") {
        let name = entry.expect("the folder can be listed").file_name();
        let name = name.to_string_lossy();
        assert!(
            !name.ends_with(".glb") || SCENES.iter().any(|stated| stated.file == name),
            "{name} is not in the table"
        );
    }
}

fn world_triangles_run_in_parallel_and_within_bounds(_: &Stated, scene: &Scene) {
    let all = scene.world_triangles();
    assert_eq!(all.corners.len(), scene.triangle_count());
    assert_eq!([all.instance.len(), all.triangle.len()], [all.corners.len(); 2]);
    let (low, high) = scene.bounds().expect("the scene is not empty");
    // Rounding of coordinates this large.
    let slack = 1e-6 * low.abs().max(high.abs()).max_element();
    for (corners, (&instance, &triangle)) in all.corners.iter().zip(all.instance.iter().zip(&all.triangle)) {
        let instance = scene.instances[instance as usize];
        let mesh = &scene.meshes[instance.mesh];
        for (k, corner) in corners.iter().enumerate() {
            assert_eq!(corner.as_vec3().as_dvec3(), *corner, "a corner is not a value of f32");
            // Front faces are anticlockwise, mirrored or not.
            let k = if instance.transform.matrix3.determinant() < 0.0 { [0, 2, 1][k] } else { k };
            let position = Vec3::from(mesh.positions[mesh.indices[triangle as usize * 3 + k] as usize]);
            let expected = instance.transform.transform_point3(position);
            assert!(corner.as_vec3().abs_diff_eq(expected, slack), "{corner} is not {expected}");
            assert!(corner.as_vec3().cmpge(low - slack).all() && corner.as_vec3().cmple(high + slack).all());
        }
    }
}

fn suggestions_are_finite_and_repeatable(_: &Stated, scene: &Scene) {
    let light = scene.suggest_light();
    assert_eq!(light, scene.suggest_light());
    let (low, high) = scene.bounds().expect("the scene is not empty");
    let margin = 0.5 * (high - low).length();
    assert!(light.cmpge(low - margin).all() && light.cmple(high + margin).all(), "{light}");
    let camera = scene.suggest_camera(light);
    assert!(camera.eye.is_finite() && camera.target.distance(camera.eye) > 1e-4, "{camera:?}");
}

fn a_light_in_a_room_gets_a_camera_in_the_room(stated: &Stated, scene: &Scene) {
    let (low, high) = scene.bounds().expect("the scene is not empty");
    for (_, lights) in ROOMS.iter().filter(|(room, _)| *room == stated.name()) {
        for &light in &known_lights(stated.file)[..*lights] {
            let eye = scene.suggest_camera(light.into()).eye;
            assert!(eye.cmpgt(low).all() && eye.cmplt(high).all(), "eye {eye} for the light {light:?}");
        }
    }
}

fn listed_lights_belong_to_stated_scenes() {
    for (file, lights) in LIGHTS {
        assert!(SCENES.iter().any(|stated| stated.file == *file), "{file}");
        assert!(!lights.is_empty(), "{file}");
        assert_eq!(known_lights(file), *lights);
    }
    assert_eq!(known_lights("gallery_vr").len(), 3);
    assert!(known_lights("another").is_empty());
}
