//! Every covered texel has the number of the triangle that it shows.

use crate::common::{Map, Rasteriser, descriptor, filled, gpu, mesh_of, record, soup, tuning, tunings};
use crate::deforming::deformed_cloths;
use crate::hard_cases::orientation;
use crate::masked::masked_room;
use crate::rasteriser::mixed;
use crate::twin::Cone;
use crate::watertight::shell;
use dual_paraboloid::compare::numbered::NO_NUMBER;
use dual_paraboloid::compare::reference::View;
use dual_paraboloid::compare::scene::SceneMesh;
use dual_paraboloid::paraboloid::double as paraboloid;
use dual_paraboloid::{
    CasterMesh, Casters, Indices, InstanceId, PointLight, PointShadows, PointShadowsDescriptor, Sides, Tuning,
    Workgroups,
};
use glam::{Affine3A, Quat, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::collections::HashMap;

/// How far outside of its triangle a texel's centre may be, as the sine of an angle.
const EDGE: f64 = 1e-6;

/// What is wrong with a map's numbers.
#[derive(Debug, Default, PartialEq)]
struct Wrong {
    covered: usize,
    /// Empty texels with a number, and others without.
    none: usize,
    unknown: usize,
    /// Texels whose centre the triangle doesn't cover, or has another depth at.
    outside: usize,
    depth: usize,
    /// Texels whose triangle has a twin of a greater number.
    lesser: usize,
}

fn wrong(casters: &Casters, light: &PointLight, map: &Map) -> Wrong {
    let view = View {
        position: light.position.as_dvec3(),
        orientation: light.orientation.as_dquat(),
        near: f64::from(light.near),
        range: f64::from(light.range),
    };
    let triangles = gpu().numbered_triangles(casters);
    let greatest: HashMap<[u32; 9], u32> = triangles.iter().map(|(number, corners)| (bits(corners), *number)).collect();
    let mut result = Wrong::default();
    for texel in map.discs() {
        result.covered += usize::from(texel.depth > 0.0);
        if texel.depth == 0.0 || texel.number == NO_NUMBER {
            result.none += usize::from((texel.depth == 0.0) != (texel.number == NO_NUMBER));
            continue;
        }
        let corners = triangles.get(&texel.number);
        let cone = corners.and_then(|c| Cone::new(0, &c.map(|p| p.as_dvec3() - view.position), &view));
        let (Some(corners), Some(cone)) = (corners, cone) else {
            result.unknown += 1;
            continue;
        };
        let q = paraboloid::to_hemisphere(paraboloid::unproject_scaled(texel.p.as_dvec2()), texel.back);
        let outside = -cone.inside(q.normalize());
        let error = (cone.depth(q) / f64::from(texel.depth) - 1.0).abs() / cone.tolerance(q.normalize(), 0.0);
        result.outside += usize::from(outside > EDGE);
        result.depth += usize::from(error > 1.0);
        result.lesser += usize::from(greatest[&bits(corners)] > texel.number);
    }
    result
}

fn bits(corners: &[Vec3; 3]) -> [u32; 9] {
    let all: Vec<u32> = corners.iter().flat_map(|p| p.to_array().map(f32::to_bits)).collect();
    all.try_into().expect("three coordinates of three corners")
}

/// Asserts that there is nothing wrong, and that much of the map is covered.
fn assert_right(name: &str, casters: &Casters, light: &PointLight, map: &Map) {
    let wrong = wrong(casters, light, map);
    let counts = [wrong.none, wrong.unknown, wrong.outside, wrong.depth, wrong.lesser];
    assert!(counts == [0; 5] && wrong.covered > 1000, "{name}: {wrong:?}");
}

fn turned(rng: &mut Pcg64) -> PointLight {
    PointLight { orientation: orientation(rng), range: 100.0, ..Default::default() }
}

#[test]
fn by_every_tuning() {
    let mut rng = Pcg64::seed_from_u64(21);
    let light = turned(&mut rng);
    let mixed = mixed(&mut rng, 1000);
    // Every triangle twice, in one mesh, and once more as an instance.
    let doubled = mixed.repeat(2);
    let mut twice = soup(&doubled, Sides::Auto);
    add(&mut twice, &doubled);
    let scenes = [
        ("mixed", soup(&mixed, Sides::Auto)),
        ("twice", twice),
        ("masked", filled(&masked_room())),
        ("shell", soup(&shell(300, &mut rng), Sides::Auto)),
    ];
    let mut rasterisers = Rasteriser::all(tunings(), 200);
    for (name, mut casters) in scenes {
        for rasteriser in &mut rasterisers {
            let map = rasteriser.map(&mut casters, light);
            assert_right(&format!("{name}, {}", rasteriser.name), &casters, &light, &map);
        }
    }
}

fn add(casters: &mut Casters, triangles: &[[Vec3; 3]]) -> InstanceId {
    let SceneMesh { positions, indices, .. } = mesh_of(triangles);
    let indices = Indices::U32(&indices);
    let mesh = casters.add_mesh(&CasterMesh { positions: &positions, indices, ..Default::default() }).unwrap();
    casters.add_instance(mesh, Affine3A::IDENTITY).unwrap()
}

/// Maps that start from that of the static casters, some of which move in between.
#[test]
fn of_kept_maps() {
    let mut rng = Pcg64::seed_from_u64(22);
    let light = turned(&mut rng);
    let mut casters = soup(&mixed(&mut rng, 1000), Sides::Auto);
    let moving = add(&mut casters, &mixed(&mut rng, 500));
    casters.set_moving(moving, true).unwrap();
    for workgroups in [Workgroups::Gpu, Workgroups::Software] {
        let descriptor = PointShadowsDescriptor { keep_static: true, ..descriptor(200) };
        let shadows = PointShadows::tuned(&gpu().device, &descriptor, &Tuning { workgroups, ..tuning() }).unwrap();
        let (mut shadows, id) = record(shadows, &mut casters, light);
        let mut fresh = Rasteriser::new(("fresh", Tuning { workgroups, ..tuning() }), 200);
        for step in 0..3 {
            let kept = Map::read(&shadows, id);
            assert_right(&format!("step {step}"), &casters, &light, &kept);
            let expected = fresh.map(&mut casters, light);
            assert!(kept.depth == expected.depth && kept.numbers == expected.numbers, "step {step}");
            casters.set_transform(moving, Affine3A::from_translation(Vec3::X * (step as f32 - 0.5))).unwrap();
            gpu().submit(|encoder| {
                shadows.record(&gpu().device, &gpu().queue, encoder, &mut casters).unwrap();
            });
        }
    }
}

#[test]
fn of_deformed_casters() {
    let mut casters = deformed_cloths();
    let light = crate::deforming::light();
    for rasteriser in &mut Rasteriser::all(tunings(), 128) {
        let map = rasteriser.map(&mut casters, light);
        assert_right(rasteriser.name, &casters, &light, &map);
    }
}

/// Twenty maps of a busy scene have the same depths and numbers to the bit, with room and without. One mesh many times,
/// nearly at the same place, so that chunks that are drawn at the same time share texels.
#[test]
fn the_same_on_every_run() {
    let mut rng = Pcg64::seed_from_u64(23);
    let SceneMesh { positions, indices, .. } = mesh_of(&mixed(&mut rng, 200));
    let indices = Indices::U32(&indices);
    let mut casters = Casters::new(&gpu().device).unwrap();
    let mesh = casters.add_mesh(&CasterMesh { positions: &positions, indices, ..Default::default() }).unwrap();
    for _ in 0..40 {
        let turn = Quat::from_scaled_axis(1e-3 * Vec3::new(rng.random(), rng.random(), rng.random()));
        casters.add_instance(mesh, Affine3A::from_quat(turn)).unwrap();
    }
    let light = turned(&mut rng);
    let no_room = Tuning { small: Some(8), records: Some(100), ..tuning() };
    for (name, plain) in [("as it is", tuning()), ("without room", no_room)] {
        for workgroups in [Workgroups::Gpu, Workgroups::Software] {
            let mut rasteriser = Rasteriser::new((name, Tuning { workgroups, ..plain }), 64);
            let first = rasteriser.map(&mut casters, light);
            assert!(first.discs().filter(|texel| texel.depth > 0.0).count() > 300);
            for run in 1..20 {
                let again = rasteriser.map(&mut casters, light);
                assert!(again.depth == first.depth && again.numbers == first.numbers, "{name}, run {run}");
            }
        }
    }
}
