//! Casters and maps that are hardly any: the right map or an empty one. Triangles that are seen badly are in
//! `rasteriser.rs`.

use crate::common::{Map, box_inside, map, soup};
use dual_paraboloid::{PointLight, Sides};
use glam::{Quat, Vec3};

fn empty(map: &Map) -> bool {
    map.depth.iter().all(|d| *d == 0.0)
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
