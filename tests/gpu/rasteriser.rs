//! The rasteriser against its twin in double precision, and against itself where its parts meet.

use crate::common::{Map, descriptor, gpu, record, soup};
use dual_paraboloid::paraboloid::double as paraboloid;
use dual_paraboloid::{Casters, PointLight, PointShadows, Sides, Tuning, Workgroups};
use glam::{DVec2, DVec3, Quat, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// A light's map with the stages set to work otherwise.
pub fn tuned_map(casters: &mut Casters, light: PointLight, resolution: u32, tuning: &Tuning) -> Map {
    let shadows = PointShadows::tuned(&gpu().device, &descriptor(resolution), tuning).unwrap();
    let (shadows, id) = record(shadows, casters, light);
    Map::read(&shadows, id)
}

fn tuning() -> Tuning {
    Tuning::of(&gpu().device)
}

/// All ways to share triangles out between what is drawn at once and what the tiles draw.
pub fn tunings() -> Vec<(&'static str, Tuning)> {
    vec![
        ("as it is", tuning()),
        ("all small", Tuning { small: Some(100_000), ..tuning() }),
        ("all large", Tuning { small: Some(0), ..tuning() }),
        ("half", Tuning { small: Some(8), ..tuning() }),
        ("no records", Tuning { small: Some(0), records: Some(1), ..tuning() }),
        ("no lists", Tuning { small: Some(0), room: 1, ..tuning() }),
        ("gpu", Tuning { workgroups: Workgroups::Gpu, ..tuning() }),
        ("gpu, all large", Tuning { workgroups: Workgroups::Gpu, small: Some(0), ..tuning() }),
        ("gpu, no lists", Tuning { workgroups: Workgroups::Gpu, small: Some(0), room: 1, ..tuning() }),
    ]
}

/// What the rays through the texels' centres meet, triangle by triangle, in double precision.
fn twin(triangles: &[[Vec3; 3]], light: &PointLight, map: &Map) -> Vec<f64> {
    let turn = light.orientation.as_dquat().inverse();
    let near = f64::from(light.near);
    let placed: Vec<[DVec3; 3]> =
        triangles.iter().map(|t| t.map(|p| turn * (p.as_dvec3() - light.position.as_dvec3()))).collect();
    map.texels()
        .map(|texel| {
            let q = paraboloid::unproject_scaled(DVec2::new(f64::from(texel.p.x), f64::from(texel.p.y)));
            let q = paraboloid::to_hemisphere(q, texel.back);
            let depth = |&[a, b, c]: &[DVec3; 3]| {
                let n = (b - a).cross(c - a);
                let d = n.dot(a);
                let inside = [a.cross(b), b.cross(c), c.cross(a)].iter().all(|e| e.dot(q) * d >= 0.0);
                let z = near * n.dot(q) / d;
                if inside && z > 0.0 && z <= 1.0 { z } else { 0.0 }
            };
            placed.iter().map(depth).fold(0.0, f64::max)
        })
        .collect()
}

#[test]
fn debug_random() {
    let mut rng = Pcg64::seed_from_u64(3);
    for (count, size, resolution) in [(1, 8.0, 64), (3, 8.0, 64), (20, 4.0, 64), (200, 1.0, 128), (200, 6.0, 128)] {
        let mut point = |size: f32| {
            Vec3::new(rng.random_range(-size..size), rng.random_range(-size..size), rng.random_range(-size..size))
        };
        let triangles: Vec<[Vec3; 3]> = (0..count)
            .map(|_| {
                let centre = point(10.0);
                [centre, centre + point(size), centre + point(size)]
            })
            .collect();
        let light = PointLight { orientation: Quat::from_rotation_x(1.0), range: 100.0, ..Default::default() };
        for (name, tuning) in tunings() {
            let map = tuned_map(&mut soup(&triangles, Sides::Auto), light, resolution, &tuning);
            let expected = twin(&triangles, &light, &map);
            let (mut holes, mut phantoms, mut wrong) = (0, 0, 0);
            for (texel, &expected) in map.texels().zip(&expected) {
                if texel.p.length() > map.half_width - map.texel() {
                    continue;
                }
                let z = f64::from(texel.depth);
                match (z > 0.0, expected > 0.0) {
                    (false, true) => holes += 1,
                    (true, false) => phantoms += 1,
                    (true, true) if (z / expected - 1.0).abs() > 1e-4 => wrong += 1,
                    _ => (),
                }
            }
            println!("{count} {size} {resolution} {name}: holes {holes} phantoms {phantoms} wrong {wrong}");
        }
    }
}
