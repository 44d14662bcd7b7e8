//! The rasteriser against its twin in double precision, and against itself where its parts meet.

use crate::common::{Map, Rasteriser, descriptor, filled, gpu, soup, tuning, tunings};
use crate::culling::random_soup;
use crate::hard_cases::orientation;
use crate::masked::{masked_room, random_sheets};
use crate::twin::{Judgement, Twin};
use crate::watertight::shell;
use dual_paraboloid::compare::gpu::Statistics;
use dual_paraboloid::compare::procedural;
use dual_paraboloid::{Casters, PointLight, PointShadows, Sides, Tuning, Workgroups};
use glam::Vec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// A way in which triangles are shared out, for each of both workgroups.
fn both(of: impl Fn(Tuning) -> Tuning) -> Vec<(&'static str, Tuning)> {
    let with = |(name, workgroups)| (name, of(Tuning { workgroups, ..tuning() }));
    [("GPU's", Workgroups::Gpu), ("software's", Workgroups::Software)].map(with).into()
}

/// Holds the maps by each rasteriser against the twin; returns how many texels they cover in all.
fn assert_twins(
    name: &str,
    twin: &Twin,
    casters: &mut Casters,
    light: PointLight,
    rasterisers: &mut [Rasteriser],
) -> usize {
    let mut covered = 0;
    // Most are the same to the bit, which needn't be judged again.
    let mut judged: Option<(Map, Judgement)> = None;
    for rasteriser in rasterisers {
        let map = rasteriser.map(casters, light);
        let judgement = match judged.take() {
            Some((last, judgement)) if last.depth == map.depth => judgement,
            _ => twin.judge(&map),
        };
        judgement.assert_exact(&format!("{name}, {}", rasteriser.name));
        covered += judgement.covered;
        judged = Some((map, judgement));
    }
    covered
}

/// The same for triangles.
fn assert_exact(name: &str, triangles: &[[Vec3; 3]], light: PointLight, rasterisers: &mut [Rasteriser]) -> usize {
    let (twin, mut casters) = (Twin::of_soup(triangles, &light), soup(triangles, Sides::Auto));
    assert_twins(name, &twin, &mut casters, light, rasterisers)
}

fn turned(rng: &mut Pcg64) -> PointLight {
    PointLight { orientation: orientation(rng), range: 100.0, ..Default::default() }
}

fn point(rng: &mut Pcg64, size: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)))
}

/// Triangles of all sizes and shapes: points of light to walls, and slivers.
pub fn mixed(rng: &mut Pcg64, count: usize) -> Vec<[Vec3; 3]> {
    let mut triangles = random_soup(rng, count);
    for triangle in triangles.iter_mut().step_by(3) {
        let [a, b, _] = *triangle;
        let width = 10f32.powf(rng.random_range(-4.0..-1.0));
        let longer = a + (b - a) * rng.random_range(1.0..20.0);
        *triangle = [a, longer, a + (longer - a) * rng.random_range(0.0..1.0) + point(rng, width)];
    }
    triangles
}

#[test]
fn random_scenes_by_every_tuning() {
    let mut rng = Pcg64::seed_from_u64(3);
    for (resolution, counts) in [(64, [1, 3, 10, 30, 300]), (250, [3, 30, 300, 1000, 3000])] {
        let mut rasterisers = Rasteriser::all(tunings(), resolution);
        let mut covered = 0;
        for count in counts {
            let (light, triangles) = (turned(&mut rng), mixed(&mut rng, count));
            covered += assert_exact(&format!("{count} triangles"), &triangles, light, &mut rasterisers);
        }
        assert!(covered > 100 * resolution as usize, "{covered}");
    }
}

#[test]
fn a_large_map() {
    let mut rng = Pcg64::seed_from_u64(4);
    let mut rasterisers = Rasteriser::all(both(|tuning| tuning), 1024);
    let (light, triangles) = (turned(&mut rng), mixed(&mut rng, 1000));
    assert_exact("a large map", &triangles, light, &mut rasterisers);
}

/// What is nearer than `near` is clipped, texel by texel.
#[test]
fn triangles_through_the_clip_distance() {
    let mut rng = Pcg64::seed_from_u64(5);
    let mut rasterisers = Rasteriser::all(tunings(), 128);
    for near in [0.5, 2.0] {
        let light = PointLight { near, ..turned(&mut rng) };
        let triangles = mixed(&mut rng, 300).into_iter().map(|t| t.map(|p| 0.2 * p)).collect::<Vec<_>>();
        assert_exact(&format!("near {near}"), &triangles, light, &mut rasterisers);
    }
}

/// Their part in the other hemisphere's map is what is outside of their edges' arcs.
#[test]
fn triangles_around_the_axis_behind() {
    let mut rng = Pcg64::seed_from_u64(6);
    let mut rasterisers = Rasteriser::all(tunings(), 64);
    for round in 0..30 {
        let light = turned(&mut rng);
        let behind = light.orientation * Vec3::Z * if round % 2 == 0 { -1.0 } else { 1.0 };
        let triangle = loop {
            let corners = [0; 3].map(|_| point(&mut rng, 3.0));
            let inside = |k: usize| corners[k].cross(corners[(k + 1) % 3]).dot(behind) > 0.0;
            let touches_the_other = corners.iter().any(|p| p.dot(behind) < 0.0);
            if (0..3).all(inside) && touches_the_other {
                break corners;
            }
        };
        assert_exact(&format!("around the axis, {round}"), &[triangle], light, &mut rasterisers);
    }
}

/// The light on a triangle's plane, within it and beside it, on an edge and on a corner; of three that meet there.
#[test]
fn the_light_on_planes_edges_and_corners() {
    let mut rng = Pcg64::seed_from_u64(7);
    let mut rasterisers = Rasteriser::all(tunings(), 64);
    let whole = |rng: &mut Pcg64| Vec3::from_array(std::array::from_fn(|_| rng.random_range(-8..9) as f32));
    for round in 0..10 {
        let (u, v) = (whole(&mut rng), whole(&mut rng));
        let cases: Vec<[Vec3; 3]> = [[u, v, -(u + v)], [u, v, u + v], [u, -u, v], [u, -2.0 * u, v], [Vec3::ZERO, u, v]]
            .into_iter()
            .filter(|[a, b, c]| (b - a).cross(c - a) != Vec3::ZERO)
            .collect();
        let wall = [u * 3.0 + Vec3::X, v * 3.0 + Vec3::X, whole(&mut rng)];
        let triangles = [cases, vec![wall; 1]].concat();
        let light = turned(&mut rng);
        assert_exact(&format!("round {round}"), &triangles, light, &mut rasterisers);
    }
}

/// Floors of kilometres, a millimetre to a metre under the light.
#[test]
fn floors_of_kilometres() {
    let mut rng = Pcg64::seed_from_u64(8);
    let mut rasterisers = Rasteriser::all(tunings(), 128);
    for round in 0..6 {
        let turn = orientation(&mut rng);
        let (half, height) = (10f32.powf(rng.random_range(2.0..3.7)), 10f32.powf(rng.random_range(-3.0..0.0)));
        let [a, b, c, d] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, z)| turn * Vec3::new(half * x, -height, half * z));
        let light = PointLight { near: 1e-4, range: 1e4, ..turned(&mut rng) };
        assert_exact(&format!("floor {round}"), &[[a, b, c], [a, c, d]], light, &mut rasterisers);
    }
}

/// How many texels have other depths or numbers, and by how much depths differ at most, relatively, where there are two.
fn differences(one: &Map, other: &Map) -> (usize, f32) {
    let radius = one.half_width - one.texel();
    let pairs = one.within(radius).zip(other.within(radius));
    let differ = pairs.filter(|(a, b)| a.depth.to_bits() != b.depth.to_bits() || a.number != b.number);
    differ.fold((0, 0.0), |(count, worst), (a, b)| {
        let relative = if a.depth.min(b.depth) > 0.0 { (a.depth / b.depth - 1.0).abs() } else { 0.0 };
        (count + 1, relative.max(worst))
    })
}

/// Both workgroups make the same bits. What is drawn at once and what by the tiles may round apart: a few texels in a
/// hundred thousand have their centre on an edge, or another depth by rounding.
#[test]
fn tunings_agree() {
    let mut rng = Pcg64::seed_from_u64(9);
    let hall = procedural::hall();
    let in_hall = PointLight { position: hall.lights[0].position, ..turned(&mut rng) };
    let scenes = [
        ("mixed", soup(&mixed(&mut rng, 3000), Sides::Auto), turned(&mut rng)),
        ("shell", soup(&shell(500, &mut rng), Sides::Auto), turned(&mut rng)),
        ("hall", filled(&hall), in_hall),
        ("sheets", random_sheets(&mut rng, Sides::Auto), turned(&mut rng)),
    ];
    let mut rasterisers = Rasteriser::all(tunings(), 256);
    let half = rasterisers.len() / 2;
    for (name, mut casters, light) in scenes {
        let maps: Vec<Map> = rasterisers.iter_mut().map(|rasteriser| rasteriser.map(&mut casters, light)).collect();
        assert!(maps[0].discs().filter(|texel| texel.depth > 0.0).count() > 10_000);
        for (k, rasteriser) in rasterisers.iter().enumerate() {
            let name = format!("{name}, {}", rasteriser.name);
            let (count, worst) = differences(&maps[0], &maps[k]);
            assert!(count <= 10 && worst <= 1e-6, "{name}: {count} texels differ, by up to {worst}");
            // Both differ in what is drawn at once by default.
            if k > half && tunings()[k].1.small == tunings()[k - half].1.small {
                assert_eq!(differences(&maps[k], &maps[k - half]).0, 0, "{name}, from the other workgroups");
            }
        }
    }
}

/// A map with at most so many records and jobs, and how many were wanted.
fn limited(casters: &mut Casters, light: PointLight, tuning: &Tuning) -> (Map, Statistics) {
    let shadows = PointShadows::tuned(&gpu().device, &descriptor(160), tuning).unwrap();
    let (shadows, id) = crate::common::record(shadows, casters, light);
    (Map::read(&shadows, id), gpu().statistics(&shadows))
}

/// Exactly as much room as is wanted makes the same map as plenty; with one less it is drawn another way, and right.
#[test]
fn records_and_jobs_that_just_fit() {
    let mut rng = Pcg64::seed_from_u64(10);
    let (light, triangles) = (turned(&mut rng), mixed(&mut rng, 300));
    let (twin, mut casters) = (Twin::of_soup(&triangles, &light), soup(&triangles, Sides::Auto));
    for (workgroups, large) in both(|tuning| Tuning { small: Some(0), ..tuning }) {
        let (plenty, wanted) = limited(&mut casters, light, &large);
        assert!(wanted.large > 100 && wanted.jobs > 20, "{wanted:?}");
        for less in [0, 1, wanted.jobs / 2] {
            let records = Tuning { records: Some(wanted.large - less), ..large };
            let jobs = Tuning { jobs: Some(wanted.jobs - less), ..large };
            for limit in [records, jobs] {
                let (map, statistics) = limited(&mut casters, light, &limit);
                assert_eq!(statistics, wanted);
                twin.judge(&map).assert_exact(workgroups);
                if less == 0 {
                    assert!(map.depth == plenty.depth && map.numbers == plenty.numbers, "{limit:?}");
                }
            }
        }
    }
}

/// What had no room leaves nothing behind for the next map.
#[test]
fn a_map_after_one_without_room() {
    let mut rng = Pcg64::seed_from_u64(11);
    let light = turned(&mut rng);
    let few = [[Vec3::new(-1.0, -1.0, 2.0), Vec3::new(1.0, -1.0, 2.0), Vec3::new(0.0, 1.0, 2.0)]];
    let (mut few, mut many) = (soup(&few, Sides::Auto), soup(&mixed(&mut rng, 300), Sides::Auto));
    for limit in both(|tuning| Tuning { small: Some(0), records: Some(10), room: 2, ..tuning }) {
        let mut rasteriser = Rasteriser::new(limit, 64);
        let before = rasteriser.map(&mut few, light);
        rasteriser.map(&mut many, light);
        let after = rasteriser.map(&mut few, light);
        assert!(before.depth.iter().any(|depth| *depth > 0.0));
        assert!(before.depth == after.depth && before.numbers == after.numbers);
    }
}

/// Casters with holes, drawn with room and without.
#[test]
fn a_masked_room_by_every_tuning() {
    let scene = masked_room();
    let mut rng = Pcg64::seed_from_u64(12);
    let mut rasterisers = Rasteriser::all(tunings(), 128);
    for _ in 0..2 {
        let light = PointLight { position: point(&mut rng, 0.5), ..turned(&mut rng) };
        let (twin, mut casters) = (Twin::new(&scene, &light), filled(&scene));
        let covered = assert_twins("masked room", &twin, &mut casters, light, &mut rasterisers);
        assert!(covered > 100_000, "{covered}");
    }
}
