//! The workgroups that ship for GPUs and those for software make the same maps, on whichever device this is.

use crate::common::{Rasteriser, gpu, soup, tuning};
use crate::masked::random_sheets;
use crate::culling::random_soup;
use dual_paraboloid::compare::{fill, procedural};
use dual_paraboloid::{Casters, PointLight, Sides, Tuning, Workgroups};
use glam::{Quat, Vec3};
use rand::SeedableRng;
use rand_pcg::Pcg64;

fn assert_alike(casters: &mut Casters, light: PointLight, resolution: u32) {
    let [one, other] = [Workgroups::Gpu, Workgroups::Software].map(|workgroups| {
        Rasteriser::new(("", Tuning { workgroups, ..tuning() }), resolution).map(casters, light)
    });
    let shown = one.discs().filter(|texel| texel.depth > 0.0).count();
    assert!(shown > one.discs().count() / 10, "{shown} texels show something");
    let differences = one.differences(&other);
    assert!(differences.is_empty(), "{} texels differ, as {:?}", differences.len(), differences[0]);
}

fn turned(position: Vec3, range: f32) -> PointLight {
    PointLight { position, orientation: Quat::from_rotation_x(0.7), range, ..Default::default() }
}

#[test]
fn triangles_of_all_sizes() {
    let triangles = random_soup(&mut Pcg64::seed_from_u64(3), 5000);
    for resolution in [64, 500] {
        assert_alike(&mut soup(&triangles, Sides::Auto), turned(Vec3::ZERO, 100.0), resolution);
    }
}

#[test]
fn scenes_made_in_code() {
    for scene in [procedural::hall(), procedural::few_large(), procedural::many_small(300)] {
        let mut casters = Casters::new(&gpu().device);
        fill(&mut casters, gpu(), &scene, Sides::Auto).unwrap();
        assert_alike(&mut casters, turned(scene.lights[0].position, 60.0), 512);
    }
}

#[test]
fn casters_with_holes() {
    let mut casters = random_sheets(&mut Pcg64::seed_from_u64(6), Sides::Auto);
    assert_alike(&mut casters, turned(Vec3::ZERO, 100.0), 256);
}
