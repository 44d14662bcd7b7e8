//! The walk on the device against its twin in single precision, on the library's own maps and casters.

use crate::common::gpu;
use dual_paraboloid::compare::fill;
use dual_paraboloid::compare::ideal::{MapGeometry, NO_TRIANGLE, NORMAL_BIAS};
use dual_paraboloid::compare::measure::{Made, Truth, light_for};
use dual_paraboloid::compare::procedural::shapes::{append, cuboid, icosphere, quad, torus_knot};
use dual_paraboloid::compare::procedural::{few_large, many_small};
use dual_paraboloid::compare::scene::{Alpha, Material, Scene, SceneInstance, SceneMesh};
use dual_paraboloid::compare::walk::{IdealWalks, STEPS, Surface, single};
use dual_paraboloid::{Casters, LightId, PointLight, PointShadows, PointShadowsDescriptor, RecordOptions, Sides};
use glam::{Affine3A, Quat, Vec3};
use std::collections::HashMap;

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

/// A light's maps as the library made them, and the casters as lookups find them.
struct Recorded {
    geometry: MapGeometry,
    depths: Vec<f32>,
    numbers: Vec<u32>,
    surface: Surface,
}

impl Recorded {
    fn new(shadows: &PointShadows, light: LightId, casters: &Casters, geometry: MapGeometry) -> Self {
        let (depths, numbers) = (gpu().read_map(shadows, light), gpu().read_texture(shadows.numbers(), 0));
        Self { geometry, depths, numbers, surface: Surface::read(gpu(), casters) }
    }

    fn of(made: &Made) -> Self {
        Self::new(&made.shadows, made.light, &made.casters, made.geometry())
    }

    /// The lookup's twin over them, of casters without holes that haven't changed since.
    fn twin(&self, truth: &Truth) -> single::Exact<'_> {
        single::Exact {
            view: truth.view,
            geometry: self.geometry,
            normal_bias: NORMAL_BIAS,
            receiver_offset: 0.0,
            made: Surface::FIRST,
            depths: &self.depths,
            numbers: &self.numbers,
            surface: &self.surface,
            is_hole: &|_, _| false,
            steps: STEPS,
        }
    }
}

/// Asserts that the device decides as the twin does, but for rounding, with many receivers left to their triangles.
fn assert_agree(on_device: &[f32], twin: &single::Exact, inputs: &[(Vec3, Vec3)]) {
    let mixed = inputs.iter().filter(|&&(position, normal)| twin.is_mixed(position, normal)).count();
    assert!(mixed > inputs.len() / 200, "{mixed} of {} are mixed", inputs.len());
    let differ = differing(on_device, twin, inputs);
    assert!(differ <= inputs.len() / 20_000, "{differ} of {} differ", inputs.len());
}

fn differing(on_device: &[f32], twin: &single::Exact, inputs: &[(Vec3, Vec3)]) -> usize {
    let in_rust = inputs.iter().map(|&(position, normal)| twin.walk_shadow(position, normal));
    on_device.iter().zip(in_rust).filter(|(a, b)| (**a >= 0.5) != (*b >= 0.5)).count()
}

fn descriptor(resolution: u32) -> PointShadowsDescriptor {
    PointShadowsDescriptor { capacity: 1, resolution, ..Default::default() }
}

fn compare(scene: &Scene, light: PointLight, resolution: u32) {
    let made = Made::new(gpu(), scene, light, &descriptor(resolution)).unwrap();
    let truth = Truth::new(scene, &light, RECEIVERS, 5);
    let inputs = truth.inputs();
    let on_device = gpu().shadow_values(&made.shadows, &made.casters, made.light, &inputs);
    let recorded = Recorded::of(&made);
    let triangles = triangles_by_corners(scene);
    let is_hole = |number, ray: Vec3| {
        let corners = recorded.surface.triangle(number).corners.map(|vertex| recorded.surface.vertex(vertex));
        scene.has_holes() && truth.reference.is_hole(triangles[&key(corners)], ray.as_dvec3())
    };
    assert_agree(&on_device, &single::Exact { is_hole: &is_hole, ..recorded.twin(&truth) }, &inputs);
    let votes = truth.judge(&gpu().vote_values(&made.shadows, made.light, &inputs));
    let walks = truth.judge(&on_device);
    let (ideal, _) = truth.ideal(made.geometry());
    let floor = truth.judge(&IdealWalks::new(scene).shadows(&truth, &ideal, STEPS)).wrong_ppm;
    println!(
        "R {resolution}: wrong {:.0} by walks, {:.0} by votes, {floor:.0} at best",
        walks.wrong_ppm, votes.wrong_ppm
    );
    assert!(walks.wrong_ppm <= floor + 60.0 && walks.wrong_ppm < 0.5 * votes.wrong_ppm, "{walks:?} {votes:?} {floor}");
}

/// A triangle's corners in any order.
fn key(corners: [Vec3; 3]) -> [[u32; 3]; 3] {
    let mut key = corners.map(|corner| corner.to_array().map(|x| (x + 0.0).to_bits()));
    key.sort_unstable();
    key
}

/// The scene's triangles by their corners, where no transform rounds.
fn triangles_by_corners(scene: &Scene) -> HashMap<[[u32; 3]; 3], u32> {
    let corners = scene.world_triangles().corners;
    corners
        .into_iter()
        .zip(0..)
        .map(|(corners, triangle)| (key(corners.map(|corner| corner.as_vec3())), triangle))
        .collect()
}

/// A sheet full of holes in waves, a knot and a floor.
fn with_holes() -> Scene {
    let (n, mut sheet) = (24, SceneMesh { material: 1, ..SceneMesh::default() });
    let mut tex_coords = Vec::new();
    for k in 0..(n + 1) * (n + 1) {
        let (u, v) = ((k % (n + 1)) as f32 / n as f32, (k / (n + 1)) as f32 / n as f32);
        sheet.positions.push([4.0 * u - 2.0, 0.2 * (7.0 * u).sin() * (9.0 * v).cos() - 0.3, 4.0 * v - 2.0]);
        tex_coords.push([2.3 * u, 2.3 * v]);
        if u < 1.0 && v < 1.0 {
            sheet.indices.extend([k, k + n + 1, k + n + 2, k, k + n + 2, k + 1]);
        }
    }
    sheet.tex_coords = Some(tex_coords);
    let alpha = |column: u32, row: u32| if (column / 8 + row / 8).is_multiple_of(2) { 255 } else { 0 };
    let image = image::RgbaImage::from_fn(64, 64, |column, row| image::Rgba([0, 0, 0, alpha(column, row)]));
    let mask = Material { base_color_image: Some(0), alpha: Alpha::Mask { cutoff: 0.5 }, ..Material::default() };
    let floor = quad(Vec3::new(-4.0, -2.0, -4.0), 8.0 * Vec3::Z, 8.0 * Vec3::X);
    Scene {
        meshes: vec![sheet, torus_knot(0.4, 200, 16), floor],
        instances: (0..3).map(|mesh| SceneInstance { mesh, transform: Affine3A::IDENTITY }).collect(),
        materials: vec![Material::default(), mask],
        images: vec![image],
        ..Scene::default()
    }
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

#[test]
fn walks_agree_with_their_twin_about_holes() {
    let scene = with_holes();
    assert!(scene.has_holes());
    for resolution in [128, 512] {
        compare(&scene, light_for(&scene, Vec3::new(0.3, 1.6, -0.2)), resolution);
    }
}

/// Receivers that lie in front of or behind their surface, as proxies and displacement put them, aren't their own shadow.
#[test]
fn receivers_off_the_surface_are_not_in_its_shadow() {
    const OFF: f32 = 0.02;
    let scene = assorted();
    let light = light_for(&scene, Vec3::new(0.3, 1.6, -0.2));
    let truth = Truth::new(&scene, &light, RECEIVERS, 5);
    let off = |k: usize| OFF * [-0.9, -0.4, 0.4, 0.9][k % 4];
    let inputs: Vec<(Vec3, Vec3)> = truth
        .inputs()
        .iter()
        .enumerate()
        .map(|(k, &(position, normal))| (position + off(k) * normal, normal))
        .collect();
    let wrong = [0.0, OFF].map(|receiver_offset| {
        let light = PointLight { receiver_offset, ..light };
        let made = Made::new(gpu(), &scene, light, &descriptor(512)).unwrap();
        let on_device = gpu().shadow_values(&made.shadows, &made.casters, made.light, &inputs);
        let recorded = Recorded::of(&made);
        let twin = single::Exact { receiver_offset: receiver_offset.into(), ..recorded.twin(&truth) };
        assert_agree(&on_device, &twin, &inputs);
        truth.judge(&on_device).false_shadow_ppm
    });
    assert!(wrong[1] < 0.02 * wrong[0] && wrong[0] > 1e5, "{wrong:?}");
}

/// Where casters have moved since the map was made, lookups that walk would follow triangles that it doesn't show.
#[test]
fn walks_over_casters_that_have_changed_are_lost() {
    let scene = assorted();
    let light = light_for(&scene, Vec3::new(0.3, 1.6, -0.2));
    let truth = Truth::new(&scene, &light, RECEIVERS, 5);
    let gpu = gpu();
    let mut casters = Casters::new(&gpu.device).unwrap();
    let instances = fill(&mut casters, gpu, &scene, Sides::Auto).unwrap();
    let mut shadows = PointShadows::new(&gpu.device, &descriptor(256)).unwrap();
    let id = shadows.add(light).unwrap();
    let record = |shadows: &mut PointShadows, casters: &mut Casters, most| {
        let options = RecordOptions { most, ..Default::default() };
        gpu.submit(|encoder| shadows.record_with(&gpu.device, &gpu.queue, encoder, casters, options)).unwrap()
    };
    assert_eq!(record(&mut shadows, &mut casters, None), 1);
    for &moved in &instances[..2] {
        casters.set_transform(moved, Affine3A::from_translation(Vec3::new(0.0, -0.3, 0.0))).unwrap();
    }
    casters.remove_instance(instances[2]).unwrap();
    assert_eq!(record(&mut shadows, &mut casters, Some(0)), 0);
    let inputs = truth.inputs();
    let on_device = gpu.shadow_values(&shadows, &casters, id, &inputs);
    let guard = f64::from(shadows.half_width()) - 1.0;
    let recorded = Recorded::new(&shadows, id, &casters, MapGeometry { resolution: 256, guard });
    let twin = recorded.twin(&truth);
    assert_agree(&on_device, &twin, &inputs);
    let follows = single::Exact { made: Surface::FIRST + 1, ..twin };
    assert!(differing(&on_device, &follows, &inputs) > 50, "what has moved makes no difference");
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
