//! Loads every test scene and holds it to the numbers that its source states.
//!
//! The scenes are third-party files outside this repository; see `scenes_dir` for where they are looked for.

use std::{path::PathBuf, time::Instant};

use dual_paraboloid::compare::scene::{Alpha, LIGHTS, Scene, known_lights, scenes_dir};
use glam::Vec3;

/// What the source of a scene says about it.
struct Stated {
    file: &'static str,
    /// Drawn triangles, instances counted.
    triangles: usize,
    /// One per primitive of each placed mesh.
    instances: usize,
    /// Of those, with a negative determinant.
    mirrored: usize,
    low: [f32; 3],
    high: [f32; 3],
    point_lights: usize,
    images: usize,
    /// Materials with an alpha mask, and with blending.
    mask_blend: [usize; 2],
}

const fn stated(file: &'static str, triangles: usize, instances: usize, low: [f32; 3], high: [f32; 3]) -> Stated {
    Stated { file, triangles, instances, mirrored: 0, low, high, point_lights: 0, images: 0, mask_blend: [0, 0] }
}

const SCENES: &[Stated] = &[
    // One mesh of 206 primitives.
    stated("interior_pandora.glb", 60_694, 206, [-36.8, 0.0, -20.8], [36.8, 22.4, 20.8]),
    stated("gallery_vr.glb", 1_930, 1, [-5.058, -0.002, -5.058], [5.058, 5.052, 5.061]),
    stated("fog_arcade_bevy.glb", 360, 1, [-3.16, 0.016, -6.742], [3.16, 6.322, 6.742]),
    Stated { mask_blend: [0, 1], ..stated("cornell_nvpro.glb", 16_732, 10, [-5.05, -5.05, -5.05], [5.05, 5.05, 5.0]) },
    // 20 placed meshes of 60 primitives.
    stated("town_godot.glb", 30_477, 60, [-1024.0, -4.64, -1024.0], [1024.0, 17.756, 1024.0]),
    stated("barn_lamp.glb", 10_203, 3, [-0.105, -0.198, 0.0], [0.086, 0.057, 0.227]),
    stated("carbon_cage.glb", 215_579, 3, [-7.138, -6.365, -6.943], [6.865, 7.29, 6.943]),
    Stated {
        images: 1,
        mask_blend: [1, 0],
        ..stated("dutch_ship.glb", 69_162, 3, [-10.326, -2.0, -3.488], [13.745, 22.657, 3.321])
    },
    Stated {
        images: 1,
        mask_blend: [1, 0],
        ..stated("house_masked.glb", 10_497, 2, [-0.251, -0.002, -0.252], [0.251, 0.185, 0.252])
    },
    Stated { images: 3, mask_blend: [3, 1], ..stated("alpha_modes.glb", 61, 9, [-4.3, -0.1, -0.75], [4.3, 2.3, 0.55]) },
    // 70 placed meshes of 87 primitives, every one mirrored.
    Stated { mirrored: 87, ..stated("mirrored_props.glb", 23_388, 87, [-11.0, -9.714, -11.0], [11.0, 0.486, 11.0]) },
    stated("teapots_expanded.glb", 7_656_770, 1_900, [-339.411, 0.0, -339.411], [339.411, 13.298, 339.411]),
    Stated { mask_blend: [0, 1], ..stated("flight_helmet.glb", 94_722, 6, [-0.204, 0.0, -0.172], [0.163, 0.716, 0.2]) },
    stated("head_lps.glb", 17_684, 1, [-0.221, 0.0, -0.084], [0.232, 0.421, 0.19]),
    Stated {
        point_lights: 3,
        ..stated("lights_level_blenvy.glb", 306, 5, [-46.768, -0.804, -46.768], [46.768, 3.069, 46.768])
    },
];

fn folder() -> Option<PathBuf> {
    let folder = scenes_dir();
    if folder.is_none() {
        eprintln!("no folder of test scenes, nothing is tested: set DP_SCENES to one that has them");
    }
    folder
}

#[test]
fn every_scene_has_the_stated_numbers() {
    let Some(folder) = folder() else { return };
    for stated in SCENES {
        let scene = Scene::load(&folder.join(stated.file)).unwrap_or_else(|error| panic!("{error}"));
        let file = stated.file;
        assert_eq!(scene.triangle_count(), stated.triangles, "{file}: triangles");
        assert_eq!(scene.instances.len(), stated.instances, "{file}: instances");
        let mirrored = scene.instances.iter().filter(|instance| instance.transform.matrix3.determinant() < 0.0);
        assert_eq!(mirrored.count(), stated.mirrored, "{file}: mirrored instances");
        assert_eq!(scene.lights.len(), stated.point_lights, "{file}: point lights");
        assert_eq!(scene.images.len(), stated.images, "{file}: images");
        let count = |has: fn(Alpha) -> bool| scene.materials.iter().filter(|material| has(material.alpha)).count();
        let masked = count(|alpha| matches!(alpha, Alpha::Mask { .. }));
        let blended = count(|alpha| matches!(alpha, Alpha::Blend));
        assert_eq!([masked, blended], stated.mask_blend, "{file}: materials with mask and blend");
        let (low, high) = scene.bounds().expect("a loaded scene is not empty");
        // The source states three decimals.
        assert!(low.abs_diff_eq(stated.low.into(), 6e-4), "{file}: low {low}");
        assert!(high.abs_diff_eq(stated.high.into(), 6e-4), "{file}: high {high}");
    }
}

#[test]
fn every_file_of_the_folder_is_stated() {
    let Some(folder) = folder() else { return };
    for entry in folder.read_dir().expect("the folder can be listed") {
        let name = entry.expect("the folder can be listed").file_name();
        let name = name.to_string_lossy();
        assert!(
            !name.ends_with(".glb") || SCENES.iter().any(|stated| stated.file == name),
            "{name} is not in the table"
        );
    }
}

#[test]
fn world_triangles_run_in_parallel_and_within_bounds() {
    let Some(folder) = folder() else { return };
    let scene = Scene::load(&folder.join("mirrored_props.glb")).unwrap_or_else(|error| panic!("{error}"));
    let all = scene.world_triangles();
    assert_eq!(all.corners.len(), scene.triangle_count());
    assert_eq!([all.instance.len(), all.triangle.len()], [all.corners.len(); 2]);
    let (low, high) = scene.bounds().expect("the scene is not empty");
    for (corners, (&instance, &triangle)) in all.corners.iter().zip(all.instance.iter().zip(&all.triangle)) {
        let instance = scene.instances[instance as usize];
        let mesh = &scene.meshes[instance.mesh];
        for (k, corner) in corners.iter().enumerate() {
            assert_eq!(corner.as_vec3().as_dvec3(), *corner, "a corner is not a value of f32");
            // Front faces are anticlockwise, mirrored or not.
            let k = if instance.transform.matrix3.determinant() < 0.0 { [0, 2, 1][k] } else { k };
            let position = Vec3::from(mesh.positions[mesh.indices[triangle as usize * 3 + k] as usize]);
            let expected = instance.transform.transform_point3(position);
            assert!(corner.as_vec3().abs_diff_eq(expected, 1e-5), "{corner} is not {expected}");
            assert!(corner.as_vec3().cmpge(low - 1e-5).all() && corner.as_vec3().cmple(high + 1e-5).all());
        }
    }
}

#[test]
fn suggestions_are_finite_repeatable_and_fast() {
    let Some(folder) = folder() else { return };
    for stated in SCENES {
        let scene = Scene::load(&folder.join(stated.file)).unwrap_or_else(|error| panic!("{error}"));
        let start = Instant::now();
        let light = scene.suggest_light();
        let seconds = start.elapsed().as_secs_f32();
        // One second is the promise, on an optimised build and a machine that is not busy.
        assert!(cfg!(debug_assertions) || seconds < 3.0, "{}: {seconds} s", stated.file);
        assert_eq!(light, scene.suggest_light(), "{}", stated.file);
        let (low, high) = scene.bounds().expect("the scene is not empty");
        let margin = 0.5 * (high - low).length();
        assert!(light.cmpge(low - margin).all() && light.cmple(high + margin).all(), "{}: {light}", stated.file);
        let camera = scene.suggest_camera(light);
        assert!(camera.eye.is_finite() && camera.target.distance(camera.eye) > 1e-4, "{}: {camera:?}", stated.file);
    }
}

#[test]
fn a_light_in_a_room_gets_a_camera_in_the_room() {
    let Some(folder) = folder() else { return };
    // The gallery has no roof, and its third light hangs where that shows.
    for (file, lights) in [("interior_pandora.glb", 5), ("gallery_vr.glb", 2), ("fog_arcade_bevy.glb", 3)] {
        let scene = Scene::load(&folder.join(file)).unwrap_or_else(|error| panic!("{error}"));
        let (low, high) = scene.bounds().expect("the scene is not empty");
        for &light in &known_lights(file)[..lights] {
            let eye = scene.suggest_camera(light.into()).eye;
            assert!(eye.cmpgt(low).all() && eye.cmplt(high).all(), "{file}: eye {eye} for the light {light:?}");
        }
    }
}

#[test]
fn listed_lights_belong_to_stated_scenes() {
    for (file, lights) in LIGHTS {
        assert!(SCENES.iter().any(|stated| stated.file == *file), "{file}");
        assert!(!lights.is_empty(), "{file}");
        assert_eq!(known_lights(file), *lights);
    }
    assert_eq!(known_lights("gallery_vr").len(), 3);
    assert!(known_lights("another").is_empty());
}
