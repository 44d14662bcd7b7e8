//! Casters and lights in unlucky places: the right map or an empty one, no NaN, no hang.

use crate::common::{Map, box_inside, map, soup};
use dual_paraboloid::{PointLight, Sides, paraboloid::double};
use glam::{Quat, Vec3};

fn finite(map: &Map) -> bool {
    map.depth.iter().all(|d| (0.0..=1.0).contains(d))
}

fn empty(map: &Map) -> bool {
    map.depth.iter().all(|d| *d == 0.0)
}

/// The light 1 mm above a quad 4 km wide, in every orientation of the hemispheres.
#[test]
fn a_quad_of_4_km_1_mm_under_the_light() {
    let (s, y) = (2000.0, -0.001);
    let [a, b, c, d] = [(-s, -s), (s, -s), (s, s), (-s, s)].map(|(x, z)| Vec3::new(x, y, z));
    let mut casters = soup(&[[a, b, c], [a, c, d]], Sides::Both);
    for k in 0..12 {
        let orientation = Quat::from_rotation_x(k as f32 * 0.7) * Quat::from_rotation_y(k as f32 * 0.3);
        let light = PointLight { orientation, range: 5000.0, near: 1e-4, ..Default::default() };
        let map = map(&mut casters, light, 256);
        assert!(finite(&map));
        for texel in map.discs() {
            let x = double::to_hemisphere(double::unproject(texel.p.as_dvec2()), texel.back);
            let direction = orientation.as_dquat() * x;
            let footprint = double::texel_angle(texel.p.as_dvec2(), f64::from(map.texel()));
            if direction.y < -footprint {
                let p = texel.p.as_dvec2();
                let distance = 1e-4 / f64::from(texel.depth) * 0.5 * (1.0 + p.dot(p));
                let expected = 0.001 / -direction.y;
                let allowed = 1e-5 + footprint / -direction.y;
                assert!((distance / expected - 1.0).abs() < allowed, "{texel:?}: {distance} is not {expected}");
            } else if direction.y > footprint {
                assert_eq!(texel.depth, 0.0, "{texel:?} is above the quad");
            }
        }
    }
}

/// Naively drawn, a triangle around the axis behind a hemisphere covers that hemisphere's whole map.
#[test]
fn a_triangle_around_the_axis_behind() {
    let around = [Vec3::new(-1.0, -1.0, -2.0), Vec3::new(1.0, -1.0, -2.0), Vec3::new(0.0, 1.0, -2.0)];
    for scale in [1e-3, 1.0, 50.0] {
        let triangle = around.map(|p| p * Vec3::new(scale, scale, 1.0));
        let map = map(&mut soup(&[triangle], Sides::Both), PointLight { range: 200.0, ..Default::default() }, 128);
        assert!(finite(&map));
        assert!(map.within(1.0).filter(|t| !t.back).all(|t| t.depth == 0.0), "the front sees what is behind it");
        assert!(map.within(0.1).filter(|t| t.back).any(|t| t.depth > 0.0) || scale < 0.1, "the back doesn't see it");
    }
}

#[test]
fn the_light_in_the_plane_on_an_edge_and_on_a_vertex() {
    let quad = |o: Vec3| [o + Vec3::new(-2.0, 0.0, -2.0), o + Vec3::new(3.0, 0.0, -2.0), o + Vec3::new(0.0, 0.0, 3.0)];
    let edge = [Vec3::new(-1.0, 0.0, 0.0), Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 3.0, 0.5)];
    let tilted = [Vec3::new(-1.0, -2.0, 1.0), Vec3::new(1.0, 2.0, -1.0), Vec3::new(0.3, 1.0, 2.0)];
    let vertex = [Vec3::ZERO, Vec3::new(1.0, 0.2, 0.3), Vec3::new(0.1, 1.0, -0.4)];
    let cases = [quad(Vec3::ZERO), quad(Vec3::new(10.0, 0.0, 0.0)), edge, tilted, vertex];
    for (number, triangle) in cases.into_iter().enumerate() {
        for k in 0..10 {
            let orientation = Quat::from_rotation_x(k as f32) * Quat::from_rotation_z(0.4 * k as f32);
            let light = PointLight { orientation, range: 100.0, ..Default::default() };
            let map = map(&mut soup(&[triangle], Sides::Both), light, 128);
            assert!(finite(&map), "case {number}, orientation {k}");
            // Seen edge-on it may touch a line of texels and nothing else.
            let covered = map.within(1.0).filter(|t| t.depth > 0.0).count();
            assert!(covered <= 2 * 2 * 128, "case {number}, orientation {k}: {covered} texels");
        }
    }
}

#[test]
fn all_casters_in_one_hemisphere() {
    let walls: Vec<[Vec3; 3]> = box_inside(Vec3::new(-1.0, -1.0, 2.0), Vec3::new(1.0, 1.0, 3.0));
    for back in [false, true] {
        let orientation = if back { Quat::from_rotation_y(std::f32::consts::PI) } else { Quat::IDENTITY };
        let map = map(&mut soup(&walls, Sides::Auto), PointLight { orientation, ..Default::default() }, 128);
        assert!(map.within(1.0).any(|t| t.back == back && t.depth > 0.0));
        assert!(map.within(1.0).all(|t| t.back == back || t.depth == 0.0));
    }
}

#[test]
fn no_casters_and_casters_of_no_area() {
    assert!(empty(&map(&mut soup(&[], Sides::Auto), PointLight::default(), 64)));
    let point = [Vec3::new(0.0, 0.0, 1.0); 3];
    let line = [Vec3::new(-1.0, 0.3, 1.0), Vec3::new(0.0, 0.3, 1.0), Vec3::new(1.0, 0.3, 1.0)];
    assert!(empty(&map(&mut soup(&[point, line], Sides::Auto), PointLight::default(), 64)));
}

#[test]
fn one_texel_and_the_largest_resolution() {
    let walls = box_inside(Vec3::splat(-2.0), Vec3::splat(2.0));
    for resolution in [1, 2, 3, 7] {
        let map = map(&mut soup(&walls, Sides::Auto), PointLight::default(), resolution);
        assert!(map.within(0.5).all(|t| t.depth > 0.0), "an empty texel at {resolution}");
    }
    let widest = crate::common::gpu().device.limits().max_texture_dimension_2d / 2;
    let map = map(&mut soup(&walls, Sides::Auto), PointLight::default(), widest.min(4096));
    assert!(map.discs().all(|t| t.depth > 0.0));
}
