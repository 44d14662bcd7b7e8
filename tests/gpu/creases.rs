//! Where lit faces meet: nothing shadows the edge of a floor and a wall.

use crate::common::{descriptor, gpu};
use crate::hard_cases::scene;
use dual_paraboloid::PointLight;
use dual_paraboloid::compare::error_figures::CreaseError;
use dual_paraboloid::compare::measure::{Made, Truth, light_for};
use dual_paraboloid::compare::procedural::shapes::quad;
use glam::{Quat, Vec3};

/// What is answered along the edge of a floor and a wall that a light stands before, at a distance and a height.
fn floor_and_wall(distance: f32, height: f32) -> CreaseError {
    let floor = quad(Vec3::new(0.0, 0.0, -4.0), Vec3::Z * 8.0, Vec3::X * 6.0);
    let wall = quad(Vec3::new(0.0, 0.0, -4.0), Vec3::Y * 6.0, Vec3::Z * 8.0);
    let scene = scene([floor, wall]);
    let orientation = Quat::from_rotation_y(0.3) * Quat::from_rotation_x(0.2);
    let light = PointLight { orientation, ..light_for(&scene, Vec3::new(distance, height, 0.0)) };
    let truth = Truth::new(&scene, &light, 400_000, 1);
    assert!(truth.lit.iter().all(|lit| *lit), "nothing throws a shadow");
    let made = Made::new(gpu(), &scene, light, &descriptor(1024)).unwrap();
    let values = gpu().shadow_values(&made.shadows, &made.casters, made.light, &truth.inputs());
    let error = truth.crease_error(&values).expect("receivers in the crease");
    println!("distance {distance}, height {height}: {error:?}");
    error
}

#[test]
fn the_edge_of_floor_and_wall_is_lit() {
    for (distance, height) in [(2.0, 2.0), (3.0, 0.3)] {
        let error = floor_and_wall(distance, height);
        assert!(error.samples > 100, "{error:?}");
        assert_eq!(error.below_ppm, 0.0, "{error:?}");
    }
}
