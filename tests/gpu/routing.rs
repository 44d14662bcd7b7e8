//! The route leaves out only what can't change the map.

use crate::common::{Map, descriptor, gpu, map, soup, unrouted_map};
use crate::watertight::shell;
use dual_paraboloid::compare::fill;
use dual_paraboloid::compare::procedural;
use dual_paraboloid::compare::scene::{Scene, known_lights, scenes_dir};
use dual_paraboloid::{Casters, PointLight, PointShadows, Sides};
use glam::{Quat, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

pub fn assert_same(casters: &mut Casters, light: PointLight, resolution: u32, name: &str) {
    let routed = map(casters, light, resolution);
    let differences = routed.differences(&unrouted_map(casters, light, resolution));
    assert!(
        differences.is_empty(),
        "{name} at {resolution}: {} texels differ, as {:?}",
        differences.len(),
        &differences[..differences.len().min(3)]
    );
}

/// Random triangles from slivers to walls.
fn random_soup(rng: &mut Pcg64, count: usize) -> Vec<[Vec3; 3]> {
    let mut point = |size: f32| {
        Vec3::new(rng.random_range(-size..size), rng.random_range(-size..size), rng.random_range(-size..size))
    };
    (0..count)
        .map(|i| {
            let centre = point(10.0);
            let size = if i % 100 == 0 { 8.0 } else { [0.01, 0.1, 0.3, 1.0][i % 4] };
            [centre, centre + point(size), centre + point(size)]
        })
        .collect()
}

#[test]
fn random_scenes() {
    let mut rng = Pcg64::seed_from_u64(7);
    for (count, resolution) in [(10, 64), (300, 128), (20_000, 256), (3000, 1024)] {
        let mut casters = soup(&random_soup(&mut rng, count), Sides::Auto);
        let light = PointLight {
            orientation: Quat::from_rotation_x(rng.random_range(0.0..3.0)),
            range: 100.0,
            ..Default::default()
        };
        assert_same(&mut casters, light, resolution, "a soup");
    }
}

#[test]
fn closed_pieces_with_the_light_outside() {
    let mut rng = Pcg64::seed_from_u64(8);
    let mut triangles = Vec::new();
    for _ in 0..30 {
        let centre = Vec3::new(rng.random_range(-9.0..9.0), rng.random_range(-9.0..9.0), rng.random_range(-9.0..9.0));
        let mirrored = rng.random_bool(0.5);
        triangles.extend(shell(200, &mut rng).into_iter().map(|t| {
            let [a, b, c] = t.map(|p| centre + p * 0.4);
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
    }
    for turn in 0..8 {
        let light = PointLight {
            position: Vec3::new(rng.random_range(-5.0..5.0), rng.random_range(-5.0..5.0), 0.0),
            orientation: Quat::from_rotation_y(turn as f32),
            range: 100.0,
            ..Default::default()
        };
        assert_same(&mut soup(&triangles, Sides::Auto), light, 300, "shells");
    }
}

#[test]
fn every_scene() {
    let Some(folder) = scenes_dir() else {
        eprintln!("no scenes: set DP_SCENES to a folder with .glb files to test on them too");
        return;
    };
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "glb"));
    files.sort();
    for path in files {
        let scene = Scene::load(&path).unwrap();
        let mut casters = Casters::new(&gpu().device);
        fill(&mut casters, gpu(), &scene, Sides::Auto).unwrap();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let (low, high) = scene.bounds().unwrap();
        for position in known_lights(&name).iter().take(2) {
            let range = low.distance(high) * 2.0;
            let light = PointLight { position: Vec3::from(*position), range, near: range * 1e-5, ..Default::default() };
            assert_same(&mut casters, light, 512, &name);
        }
    }
}

#[test]
fn the_hall() {
    let scene = procedural::hall();
    let mut casters = Casters::new(&gpu().device);
    fill(&mut casters, gpu(), &scene, Sides::Auto).unwrap();
    let light = PointLight { position: scene.lights[0].position, range: 60.0, ..Default::default() };
    assert_same(&mut casters, light, 1024, "the hall");
}

#[test]
fn two_runs_give_the_same_bits() {
    let scene = procedural::hall();
    let run = || {
        let mut casters = Casters::new(&gpu().device);
        fill(&mut casters, gpu(), &scene, Sides::Auto).unwrap();
        let light = PointLight { position: scene.lights[0].position, range: 60.0, ..Default::default() };
        map(&mut casters, light, 512)
    };
    let (first, second) = (run(), run());
    assert!(first.depth.iter().any(|d| *d > 0.0));
    assert!(first.depth.iter().zip(&second.depth).all(|(a, b)| a.to_bits() == b.to_bits()));
}
