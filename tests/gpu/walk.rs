//! The walk on the device against its twin in single precision, on the library's own maps and casters.

use crate::common::gpu;
use dual_paraboloid::compare::ideal::{MapGeometry, NO_TRIANGLE, NORMAL_BIAS};
use dual_paraboloid::compare::measure::{Made, Truth, light_for};
use dual_paraboloid::compare::procedural::shapes::{append, cuboid, icosphere, quad, torus_knot};
use dual_paraboloid::compare::procedural::{few_large, many_small};
use dual_paraboloid::compare::scene::{Scene, SceneInstance, SceneMesh};
use dual_paraboloid::compare::walk::{STEPS, Surface, single};
use dual_paraboloid::{PointLight, PointShadowsDescriptor};
use glam::{Affine3A, Quat, Vec3};

const RECEIVERS: usize = 50_000;

/// Knots, balls and boxes, mirrored and sheared, over a floor.
fn assorted() -> Scene {
    let mut boxes = SceneMesh { normals: Some(Vec::new()), ..SceneMesh::default() };
    for (x, z) in [(0, 0), (1, 0), (2, 1)] {
        let low = Vec3::new(0.5 * x as f32, -1.5, 0.5 * z as f32);
        append(&mut boxes, &cuboid(low, low + 0.5), Affine3A::IDENTITY);
    }
    let floor = quad(Vec3::new(-4.0, -2.0, -4.0), 8.0 * Vec3::Z, 8.0 * Vec3::X);
    let at = |x: f32, y: f32, z: f32, scale: Vec3| {
        Affine3A::from_scale_rotation_translation(scale, Quat::from_rotation_y(x), Vec3::new(x, y, z))
    };
    let places = [
        (0, at(1.0, -0.8, 0.3, Vec3::splat(0.5))),
        (0, at(-1.2, -0.9, 0.9, Vec3::new(-0.6, 0.3, 0.5))),
        (1, at(0.1, -1.0, -1.3, Vec3::splat(0.6))),
        (1, at(-1.5, 0.2, -1.0, Vec3::new(0.3, -0.3, 0.2))),
        (2, Affine3A::IDENTITY),
        (3, Affine3A::IDENTITY),
    ];
    let instances = places.into_iter().map(|(mesh, transform)| SceneInstance { mesh, transform }).collect();
    Scene { meshes: vec![torus_knot(0.6, 400, 24), icosphere(0.8, 3), boxes, floor], instances, ..Scene::default() }
}

fn compare(scene: &Scene, light: PointLight, resolution: u32) {
    let descriptor = PointShadowsDescriptor { capacity: 1, resolution, ..Default::default() };
    let made = Made::new(gpu(), scene, light, &descriptor).unwrap();
    let truth = Truth::new(scene, &light, RECEIVERS, 5);
    let on_device = gpu().shadow_values(&made.shadows, &made.casters, made.light, &truth.inputs());

    let surface = Surface::read(gpu(), &made.casters);
    let (depths, numbers) = (gpu().read_map(&made.shadows, made.light), gpu().read_texture(made.shadows.numbers(), 0));
    let exact = single::Exact {
        view: truth.view,
        geometry: made.geometry(),
        normal_bias: NORMAL_BIAS,
        depths: &depths,
        numbers: &numbers,
        surface: &surface,
        is_hole: &|_, _| false,
        steps: STEPS,
    };
    let inputs = truth.inputs();
    let in_rust: Vec<f32> = inputs.iter().map(|&(position, normal)| exact.walk_shadow(position, normal)).collect();
    let mixed = inputs.iter().filter(|&&(position, normal)| exact.is_mixed(position, normal)).count();
    assert!(mixed > RECEIVERS / 200, "{mixed} of {} are mixed", inputs.len());
    let differ = on_device.iter().zip(&in_rust).filter(|(a, b)| (**a >= 0.5) != (**b >= 0.5)).count();
    assert!(differ <= inputs.len() / 20_000, "{differ} of {} differ", inputs.len());
    let votes = truth.judge(&gpu().vote_values(&made.shadows, made.light, &inputs));
    let walks = truth.judge(&on_device);
    let (ideal, _) = truth.ideal(made.geometry());
    let floor = dual_paraboloid::compare::walk::IdealWalks::new(scene).shadows(&truth, &ideal, STEPS);
    let floor = truth.judge(&floor).wrong_ppm;
    println!(
        "R {resolution}: mixed {mixed}, differ {differ}, wrong {:.0} by walks, {:.0} by votes, {floor:.0} at best",
        walks.wrong_ppm, votes.wrong_ppm
    );
    assert!(walks.wrong_ppm <= floor + 60.0 && walks.wrong_ppm < 0.5 * votes.wrong_ppm, "{walks:?} {votes:?} {floor}");
}

#[test]
fn walks_agree_with_their_twin() {
    let scene = assorted();
    for resolution in [64, 256, 1024] {
        compare(&scene, light_for(&scene, Vec3::new(0.3, 1.6, -0.2)), resolution);
    }
    for scene in [few_large(), many_small(200)] {
        let light = scene.lights.first().map_or_else(|| scene.suggest_light(), |light| light.position);
        compare(&scene, light_for(&scene, light), 256);
    }
}

/// Every texel with a depth has the number of a triangle whose plane has that depth there.
#[test]
fn numbers_are_those_of_the_depths() {
    let scene = assorted();
    let light = light_for(&scene, Vec3::new(0.3, 1.6, -0.2));
    let descriptor = PointShadowsDescriptor { capacity: 1, resolution: 256, ..Default::default() };
    let made = Made::new(gpu(), &scene, light, &descriptor).unwrap();
    let surface = Surface::read(gpu(), &made.casters);
    let depths = gpu().read_map(&made.shadows, made.light);
    let numbers: Vec<u32> = gpu().read_texture(made.shadows.numbers(), 0);
    let truth = Truth::new(&scene, &light, 1, 1);
    let geometry: MapGeometry = made.geometry();
    let mut checked = 0;
    for (texel, (&depth, &number)) in depths.iter().zip(&numbers).enumerate() {
        let (back, i, j) = geometry.texel_at(texel);
        if !geometry.in_disc(geometry.centre(i, j)) {
            continue;
        }
        assert_eq!(depth > 0.0, number != NO_TRIANGLE, "texel {texel}");
        if number == NO_TRIANGLE {
            continue;
        }
        let direction = dual_paraboloid::paraboloid::double::unproject(geometry.centre(i, j));
        let ray = truth.view.to_world(direction, back);
        let corners = surface.triangle(number).corners.map(|vertex| surface.vertex(vertex).as_dvec3());
        let [a, b, c] = corners.map(|corner| corner - truth.view.position);
        let normal = (b - a).cross(c - a);
        let distance = normal.dot(a) / normal.dot(ray);
        let expected = dual_paraboloid::paraboloid::double::depth(direction * distance, truth.view.near);
        assert!((f64::from(depth) / expected - 1.0).abs() < 1e-3, "texel {texel}: {depth} and {expected}");
        checked += 1;
    }
    assert!(checked > 10_000);
}
