//! Maps of scenes whose depth has a closed form.

use crate::common::{Map, Rasteriser, Texel, box_inside, gpu, map, soup, tunings};
use crate::hard_cases::orientation;
use crate::twin::Twin;
use dual_paraboloid::{PointLight, Sides, paraboloid::double};
use glam::{DQuat, DVec3, Quat, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::f32::consts::FRAC_PI_2;

const RESOLUTIONS: [u32; 6] = [64, 128, 256, 512, 1024, 2048];

/// Relative rounding of a distance that went through depth in single precision: some steps of 2^-24 each. On a plane that is
/// seen at an angle in proportion to the inverse of its sine.
const ROUNDING: f64 = 1e-6;

/// Direction of a texel in world space.
fn direction(texel: &Texel, light: &PointLight) -> DVec3 {
    let x = double::to_hemisphere(double::unproject(texel.p.as_dvec2()), texel.back);
    DQuat::from_array(light.orientation.as_dquat().to_array()).mul_vec3(x)
}

/// Distance along a texel's direction that its depth means.
fn distance(texel: &Texel, light: &PointLight) -> f64 {
    let p = texel.p.as_dvec2();
    f64::from(light.near) / f64::from(texel.depth) * 0.5 * (1.0 + p.dot(p))
}

/// Asserts that every texel is on a surface given by the distance and the cosine of incidence along a direction, within
/// rounding.
fn assert_surface(map: &Map, light: &PointLight, surface: impl Fn(DVec3) -> (f64, f64)) {
    for texel in map.discs() {
        let (expected, cosine) = surface(direction(&texel, light));
        let allowed = ROUNDING / cosine;
        let error = (distance(&texel, light) - expected).abs() / expected;
        assert!(texel.depth > 0.0 && error <= allowed, "{texel:?}: off by {error}, {allowed} allowed");
    }
}

#[test]
fn inside_a_box() {
    let (low, high) = (Vec3::new(-3.0, -1.0, -5.0), Vec3::new(2.0, 2.5, 4.0));
    let mut casters = soup(&box_inside(low, high), Sides::Both);
    let orientations = [Quat::IDENTITY, Quat::from_rotation_y(0.7) * Quat::from_rotation_x(1.1)];
    for (resolution, orientation) in RESOLUTIONS.iter().flat_map(|r| orientations.map(|o| (*r, o))) {
        let light = PointLight { position: Vec3::new(0.4, 0.3, -0.2), orientation, range: 50.0, ..Default::default() };
        let map = map(&mut casters, light, resolution);
        assert_surface(&map, &light, |d| {
            let origin = light.position.as_dvec3();
            let to = |axis: usize| {
                let wall = if d[axis] > 0.0 { high[axis] } else { low[axis] };
                if d[axis] == 0.0 { f64::INFINITY } else { (f64::from(wall) - origin[axis]) / d[axis] }
            };
            let axis = (0..3).min_by(|a, b| to(*a).total_cmp(&to(*b))).unwrap();
            // At an edge of the box either wall may be drawn: the steeper one counts.
            let cosine = (0..3).filter(|a| to(*a) < to(axis) * 1.0001).map(|a| d[a].abs()).fold(1.0, f64::min);
            (to(axis), cosine)
        });
    }
}

#[test]
fn inside_a_sphere() {
    use dual_paraboloid::compare::procedural::shapes::icosphere;
    let sphere = icosphere(4.0, 5);
    let triangles: Vec<[Vec3; 3]> = sphere
        .indices
        .chunks_exact(3)
        .map(|t| [t[0], t[1], t[2]].map(|v| Vec3::from(sphere.positions[v as usize])))
        .collect();
    let mut casters = soup(&triangles, Sides::Both);
    for resolution in RESOLUTIONS {
        let light = PointLight { range: 50.0, ..Default::default() };
        let map = map(&mut casters, light, resolution);
        // The sphere is a polyhedron: its faces lie inside by up to the sagitta of their edges.
        let flat = (1.0 - (0.0365f64 * 0.5).cos()) * 2.0;
        for texel in map.discs() {
            let distance = distance(&texel, &light) / 4.0;
            assert!(distance <= 1.0 + ROUNDING && distance >= 1.0 - flat - ROUNDING, "{texel:?}: {distance}");
        }
    }
}

#[test]
fn above_a_plane() {
    let (a, b, c, d) = (
        Vec3::new(-1000.0, -2.0, -1000.0),
        Vec3::new(1000.0, -2.0, -1000.0),
        Vec3::new(1000.0, -2.0, 1000.0),
        Vec3::new(-1000.0, -2.0, 1000.0),
    );
    let mut casters = soup(&[[a, b, c], [a, c, d]], Sides::Both);
    for orientation in
        [Quat::IDENTITY, Quat::from_rotation_x(FRAC_PI_2), Quat::from_rotation_z(0.3) * Quat::from_rotation_x(0.8)]
    {
        for resolution in [64, 256, 1024] {
            let light = PointLight { orientation, range: 4000.0, ..Default::default() };
            let map = map(&mut casters, light, resolution);
            for texel in map.discs() {
                let d = direction(&texel, &light);
                // Where the ray meets the plane, in half widths.
                let at = 0.002 * d.x.abs().max(d.z.abs()) / -d.y;
                if d.y > 0.0 || at > 1.001 {
                    assert_eq!(texel.depth, 0.0, "{texel:?} is beyond the plane");
                } else if at < 0.999 {
                    let (expected, distance) = (2.0 / -d.y, distance(&texel, &light));
                    let error = (distance - expected).abs() / expected;
                    assert!(error < ROUNDING / -d.y, "{texel:?}: off by {error}");
                }
            }
        }
    }
    gpu().wait();
}

/// Fins seen from their edge, none of which has a point nearer than 1: no texel whose ray meets one is nearer than that.
/// Few others show any: so thin are some fins that the room for rounding at edges widens them by half, and beyond the tips
/// of their triangles, as sharp as they are thin, by dozens of texels.
#[test]
fn no_texel_of_fins_seen_edge_on_is_nearer() {
    let mut random = Pcg64::seed_from_u64(5);
    let (near, far) = (1.0, 2.0);
    let fins = (0..2000).flat_map(|_| {
        let turn = orientation(&mut random);
        let (width, off) = (10f32.powf(random.random_range(-2.0..0.0)), 10f32.powf(random.random_range(-7.0..-2.0)));
        let corner = |x: f32, z: f32| turn * Vec3::new(x, off, z);
        let quad = [corner(0.0, near), corner(width, near), corner(width, far), corner(0.0, far)];
        [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
    });
    let fins: Vec<[Vec3; 3]> = fins.collect();
    let mut casters = soup(&fins, Sides::Both);
    let light = PointLight { range: 50.0, ..Default::default() };
    let twin = Twin::of_soup(&fins, &light);
    for (resolution, step) in [(256, 1), (1024, 5)] {
        for mut rasteriser in Rasteriser::all(tunings().into_iter().step_by(step).collect(), resolution) {
            let map = rasteriser.map(&mut casters, light);
            let (met, beside): (Vec<_>, Vec<_>) =
                map.discs().filter(|texel| texel.depth > 0.0).partition(|texel| twin.meets(texel));
            let nearest = met.iter().map(|texel| 1.0 - distance(texel, &light)).fold(0.0, f64::max);
            let name = format!("{} at {resolution}", rasteriser.name);
            assert!(nearest <= ROUNDING, "{name}: nearer by {nearest}");
            assert!(
                met.len() > 900 && 300 * beside.len() <= met.len(),
                "{name}: {} beside {}",
                beside.len(),
                met.len()
            );
        }
    }
}
