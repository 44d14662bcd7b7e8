//! The culling leaves out only what can't change the map.

use crate::claims::assert_culling_changes_nothing;
use crate::common::{filled, gpu, map, soup, unculled_map};
use crate::hard_cases::scene;
use crate::watertight::shell;
use dual_paraboloid::compare::fill;
use dual_paraboloid::compare::procedural::{self, shapes::cuboid};
use dual_paraboloid::compare::scene::SceneMesh;
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

#[test]
fn a_light_so_near_that_fronts_are_cut_away() {
    let body = cuboid(Vec3::splat(-1.0), Vec3::splat(1.0));
    for direction in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
        for (distance, cuts) in [(0.3, true), (2.5, false)] {
            let scene = scene([body.clone()]);
            let light = PointLight { position: (1.0 + distance) * direction, near: 1.0, ..Default::default() };
            let mut casters = filled(&scene);
            let (culled, all) = (map(&mut casters, light, 64), unculled_map(&mut casters, light, 64));
            assert!(culled.differences(&all).is_empty(), "{distance} along {direction}");
            // What shows through the cut is the far side.
            let nearest = culled.depth.iter().fold(0.0f32, |a, b| a.max(*b));
            assert!(nearest > 0.0 && (!cuts || nearest < 1.0), "{nearest}");
        }
    }
}

/// A bow tie, extruded: of its two lobes the smaller one is inside out. Its longer sides are cut into rows, and end in the
/// crossing.
fn bow_tie() -> SceneMesh {
    let outline = [[-1.0, -0.5], [2.0, 1.0], [2.0, -1.0], [-1.0, 0.5]];
    let mut mesh = SceneMesh::default();
    // Each side of the outline as rows of squares, with the corners of its neighbours.
    let points: Vec<[f32; 2]> = (0..4)
        .flat_map(|side| {
            let (a, b): ([f32; 2], [f32; 2]) = (outline[side], outline[(side + 1) % 4]);
            // Not through the crossing itself.
            (0..7).map(move |k| [0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) * k as f32 / 7.0))
        })
        .collect();
    let count = points.len() as u32;
    for z in [0.0, 1.0] {
        mesh.positions.extend(points.iter().map(|&[x, y]| [x, y, z]));
    }
    for k in 0..count {
        let (a, b) = (k, (k + 1) % count);
        mesh.indices.extend([a, b, count + b, a, count + b, count + a]);
    }
    // Fans from a point in the greater lobe.
    for (z, from) in [(0.0, 0), (1.0, count)] {
        let middle = mesh.positions.len() as u32;
        mesh.positions.push([1.6, 0.05, z]);
        for k in 0..count {
            let (a, b) = (from + k, from + (k + 1) % count);
            mesh.indices.extend(if from == 0 { [middle, b, a] } else { [middle, a, b] });
        }
    }
    mesh
}

#[test]
fn lobes_that_are_inside_out() {
    for (turn, mirrored) in [(0.0, false), (0.7, true)] {
        let mut mesh = bow_tie();
        if mirrored {
            mesh.indices.as_chunks_mut().0.iter_mut().for_each(|[_, b, c]: &mut [u32; 3]| std::mem::swap(b, c));
        }
        let mut casters = filled(&scene([mesh]));
        for position in
            [Vec3::new(-3.0, 0.1, 0.4), Vec3::new(-0.9, 1.5, 0.5), Vec3::new(-0.5, 0.1, 3.0), Vec3::new(4.0, 0.3, -1.0)]
        {
            let light = PointLight { position, orientation: Quat::from_rotation_y(turn), ..Default::default() };
            let (culled, all) = (map(&mut casters, light, 128), unculled_map(&mut casters, light, 128));
            assert!(all.depth.iter().filter(|depth| **depth > 0.0).count() > 50);
            let differences = culled.differences(&all);
            assert!(differences.is_empty(), "{position}: {} texels, as {:?}", differences.len(), differences[0]);
        }
    }
}
