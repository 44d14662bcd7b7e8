//! The culling leaves out only what can't change the map.

use crate::claims::assert_culling_changes_nothing;
use crate::common::{gpu, soup};
use crate::watertight::shell;
use dual_paraboloid::compare::fill;
use dual_paraboloid::compare::procedural;
use dual_paraboloid::{Casters, PointLight, Sides};
use glam::{Quat, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// Random triangles from slivers to walls.
pub fn random_soup(rng: &mut Pcg64, count: usize) -> Vec<[Vec3; 3]> {
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
        assert_culling_changes_nothing(&mut casters, light, resolution, "a soup");
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
        assert_culling_changes_nothing(&mut soup(&triangles, Sides::Auto), light, 300, "shells");
    }
}

#[test]
fn the_hall() {
    let scene = procedural::hall();
    let mut casters = Casters::new(&gpu().device).unwrap();
    fill(&mut casters, gpu(), &scene, Sides::Auto).unwrap();
    let light = PointLight { position: scene.lights[0].position, range: 60.0, ..Default::default() };
    assert_culling_changes_nothing(&mut casters, light, 1024, "the hall");
}
