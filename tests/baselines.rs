//! The methods that the library is measured against have to be right, and as good as they can be.

use bytemuck::Pod;
use dual_paraboloid::compare::baselines::{
    Baseline, BaselineError, Bias, Budget, CubeCompute, DeviceScene, Lookup, Method, SceneBuffers,
};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::lookup_cost::{Kernel, LightsBench, LightsQuestion, LookupBench, PassStage, Question};
use dual_paraboloid::compare::measure::{Judge, Truth, choose_light};
use dual_paraboloid::compare::procedural::{self, shapes};
use dual_paraboloid::compare::reference::Reference;
use dual_paraboloid::compare::scene::{Material, Scene, SceneInstance, SceneMesh};
use dual_paraboloid::compare::shot::Shot;
use dual_paraboloid::compare::timing::{Rounds, Timer};
use dual_paraboloid::{Coverage, Error, PointLight, Sides, Tuning, Workgroups};
use glam::{Affine3A, Quat, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::f32::consts::TAU;
use std::sync::OnceLock;

/// The device of all tests.
fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::new(wgpu::Features::empty()).unwrap_or_else(|error| panic!("{error}")))
}

/// The cubes that the hardware draws on every device, with texels of four bytes. `tests/device_features` has the others.
fn cubes() -> Vec<Method> {
    let others = [Method::Cube16, Method::CubeMultiview, Method::CubeCompute];
    Method::ALL.into_iter().filter(|method| method.is_cube() && !others.contains(method)).collect()
}

/// Those and the one that is rasterised in compute.
fn all_cubes() -> Vec<Method> {
    [cubes(), vec![Method::CubeCompute]].concat()
}

/// A method's map of a scene, recorded once.
fn recorded(method: Method, resolution: u32, scene: &mut DeviceScene, light: &PointLight) -> Baseline {
    let mut baseline = Baseline::new(&gpu().device, method, resolution).unwrap();
    record(&mut baseline, scene, light);
    baseline
}

fn record(baseline: &mut Baseline, scene: &mut DeviceScene, light: &PointLight) {
    gpu().submit(|encoder| {
        let recorded = baseline.record(&gpu().device, &gpu().queue, encoder, scene, light);
        recorded.unwrap();
    });
}

/// All layers of a method's map, one after the other.
fn depths(method: Method, resolution: u32, scene: &mut DeviceScene, light: &PointLight) -> Vec<f32> {
    layers(recorded(method, resolution, scene, light).map())
}

/// All layers of a texture, one after the other.
fn layers<T: Pod>(texture: &wgpu::Texture) -> Vec<T> {
    (0..texture.depth_or_array_layers()).flat_map(|layer| gpu().read_texture(texture, layer)).collect()
}

fn on_device(scene: &Scene, sides: Sides) -> DeviceScene {
    DeviceScene::new(gpu(), scene, sides).unwrap()
}

fn scene_of(meshes: Vec<SceneMesh>, instances: Vec<(usize, Affine3A)>) -> Scene {
    Scene {
        meshes,
        instances: instances.into_iter().map(|(mesh, transform)| SceneInstance { mesh, transform }).collect(),
        materials: vec![Material::default()],
        ..Scene::default()
    }
}

fn mesh(positions: Vec<Vec3>, indices: Vec<u32>) -> SceneMesh {
    SceneMesh { positions: positions.into_iter().map(|p| p.to_array()).collect(), indices, ..SceneMesh::default() }
}

/// The room between two corners, seen from inside: its faces' fronts are within.
fn room(low: Vec3, high: Vec3) -> Scene {
    let (x, y, z) = (Vec3::X * (high.x - low.x), Vec3::Y * (high.y - low.y), Vec3::Z * (high.z - low.z));
    let sides = [(low, z, x), (high, -x, -z), (low, x, y), (low, y, z), (high, -y, -x), (high, -z, -y)];
    let meshes = sides.map(|(corner, u, v)| shapes::quad(corner, u, v)).to_vec();
    let instances = (0..meshes.len()).map(|side| (side, Affine3A::IDENTITY)).collect();
    scene_of(meshes, instances)
}

/// Direction of a cube's texel, with 1 along the face's axis; written down from the table of the WebGPU standard. The guard
/// band has a little more than half a texel on each side.
fn direction(face: usize, column: usize, row: usize, resolution: u32) -> Vec3 {
    let at = |texel: usize| (2.0 * (texel as f32 + 0.5) - resolution as f32) / (resolution as f32 - 1.031_25);
    let (s, t) = (at(column), at(row));
    match face {
        0 => Vec3::new(1.0, -t, -s),
        1 => Vec3::new(-1.0, -t, s),
        2 => Vec3::new(s, 1.0, t),
        3 => Vec3::new(s, -1.0, -t),
        4 => Vec3::new(s, -t, 1.0),
        _ => Vec3::new(-s, -t, -1.0),
    }
}

#[test]
fn cubes_inside_a_box() {
    let (low, high) = (Vec3::new(-3.0, -1.0, -5.0), Vec3::new(2.0, 2.5, 4.0));
    let turns = [Quat::IDENTITY, Quat::from_euler(glam::EulerRot::XYZ, 0.5, -0.9, 2.0)];
    for orientation in turns {
        check_box(low, high, PointLight { position: Vec3::new(0.4, 0.3, -0.2), orientation, ..Default::default() });
    }
}

fn check_box(low: Vec3, high: Vec3, light: PointLight) {
    let resolution = 128;
    for (method, sides) in all_cubes().into_iter().flat_map(|m| [(m, Sides::Both), (m, Sides::Front)]) {
        let mut scene = on_device(&room(low, high), sides);
        let depths = depths(method, resolution, &mut scene, &light);
        let size = resolution as usize;
        for (index, depth) in depths.into_iter().enumerate() {
            let (face, row, column) = (index / (size * size), index / size % size, index % size);
            let d = direction(face, column, row, resolution);
            let d = light.orientation * d;
            let wall = Vec3::select(d.cmpgt(Vec3::ZERO), high, low) - light.position;
            let expected = light.near / (wall / d).min_element();
            // The hardware's rasteriser snaps corners to 1/256 texel.
            let snapping = if method == Method::CubeCompute { 0.0 } else { 0.02 / resolution as f32 };
            let allowed = 1e-5 + snapping;
            assert!(
                (depth / expected - 1.0).abs() < allowed,
                "{method}, {sides:?}, face {face}, texel {column} {row}: {depth}, not {expected}"
            );
        }
    }
}

/// Triangles of all sizes in several meshes that lie where they are.
fn random_scene(count: usize) -> Scene {
    let mut random = Pcg64::seed_from_u64(11);
    let mut point = |size: f32| Vec3::from_array(std::array::from_fn(|_| random.random_range(-size..size)));
    let mut meshes = Vec::new();
    for k in 0..40 {
        let centre = point(10.0);
        let mut positions = Vec::new();
        for i in 0..count / 40 {
            let at = centre + point(1.5);
            let size = if (i + k) % 200 == 0 { 6.0 } else { [0.01, 0.05, 0.3][i % 3] };
            positions.extend([at, at + point(size), at + point(size)]);
        }
        let indices = (0..positions.len() as u32).collect();
        meshes.push(mesh(positions, indices));
    }
    let instances = (0..meshes.len()).map(|k| (k, Affine3A::IDENTITY)).collect();
    scene_of(meshes, instances)
}

/// The same scene with each instance a mesh in world space, so that all methods have the same vertices to the bit.
fn baked(scene: &Scene) -> Scene {
    let meshes = scene.instances.iter().map(|instance| {
        let source = &scene.meshes[instance.mesh];
        let world = |p: &[f32; 3]| instance.transform.transform_point3(Vec3::from(*p));
        mesh(source.positions.iter().map(world).collect(), source.indices.clone())
    });
    let meshes: Vec<SceneMesh> = meshes.collect();
    let instances = (0..meshes.len()).map(|k| (k, Affine3A::IDENTITY)).collect();
    scene_of(meshes, instances)
}

fn wide_light() -> PointLight {
    PointLight { position: Vec3::new(0.3, 0.2, -0.1), range: 200.0, ..Default::default() }
}

/// Number of values that differ by more than the relative `tolerance`.
fn differing(a: &[f32], b: &[f32], tolerance: f32) -> usize {
    assert_eq!(a.len(), b.len());
    let differs = |(a, b): &(&f32, &f32)| (*a - *b).abs() > tolerance * a.max(**b);
    a.iter().zip(b).filter(differs).count()
}

#[test]
fn all_cubes_are_the_same() {
    let scenes = [random_scene(20_000), baked(&procedural::many_small(400))];
    for (scene, sides) in scenes.iter().flat_map(|s| [(s, Sides::Both), (s, Sides::Auto)]) {
        let mut scene = on_device(scene, sides);
        for resolution in [64, 333] {
            let all = depths(Method::CubeUnculled, resolution, &mut scene, &wide_light());
            assert!(all.iter().any(|depth| *depth > 0.0));
            for method in cubes() {
                let other = depths(method, resolution, &mut scene, &wide_light());
                let differing = differing(&all, &other, 0.0);
                assert_eq!(differing, 0, "{method}, {sides:?} at {resolution}");
            }
        }
    }
}

#[test]
fn all_cubes_cull_the_same_back_faces() {
    let mut scene = on_device(&baked(&procedural::many_small(400)), Sides::Front);
    let both = depths(Method::Cube, 200, &mut on_device(&procedural::many_small(400), Sides::Both), &wide_light());
    let all = depths(Method::CubeUnculled, 200, &mut scene, &wide_light());
    // The objects are closed, so only silhouettes tell.
    assert!(differing(&all, &both, 1e-3) < all.len() / 1000);
    for method in cubes() {
        let other = depths(method, 200, &mut scene, &wide_light());
        // The route keeps triangles that the rasteriser might turn over, seen edge-on.
        let allowed = if method == Method::CubeRouted { all.len() / 10_000 } else { 0 };
        assert!(differing(&all, &other, 0.0) <= allowed, "{method}");
    }
}

#[test]
fn instances_may_be_turned_and_mirrored() {
    let blob = shapes::displaced_sphere(24, 12, |at| at * (1.0 + 0.2 * (5.0 * at.x).sin()));
    let mut random = Pcg64::seed_from_u64(5);
    let instances: Vec<(usize, Affine3A)> = (0..60)
        .map(|k| {
            let scale = Vec3::new(if k % 2 == 0 { 1.0 } else { -1.0 }, 1.5, 0.5);
            let turn = Quat::from_rotation_y(k as f32) * Quat::from_rotation_x(0.7 * k as f32);
            let at = Vec3::from_array(std::array::from_fn(|_| random.random_range(-9.0..9.0)));
            let at = if at.length() < 3.0 { at + 6.0 } else { at };
            (k % 2, Affine3A::from_scale_rotation_translation(scale, turn, at))
        })
        .collect();
    let scene = scene_of(vec![blob.clone(), blob], instances);
    for sides in [Sides::Both, Sides::Front] {
        let mut scene = on_device(&scene, sides);
        let all = depths(Method::CubeUnculled, 256, &mut scene, &wide_light());
        for method in cubes() {
            let other = depths(method, 256, &mut scene, &wide_light());
            // The routed cube's vertices were transformed by another shader: an edge may fall to the other side of
            // a texel's centre.
            let allowed = if method == Method::CubeRouted { all.len() / 2000 } else { 0 };
            let tolerance = if method == Method::CubeRouted { 1e-5 } else { 0.0 };
            let differing = differing(&all, &other, tolerance);
            assert!(differing <= allowed, "{method}, {sides:?}: {differing} differ");
        }
    }
    let both = depths(Method::Cube, 256, &mut on_device(&scene, Sides::Both), &wide_light());
    let front = depths(Method::Cube, 256, &mut on_device(&scene, Sides::Front), &wide_light());
    assert!(differing(&both, &front, 1e-3) < both.len() / 1000);
}

/// What rays through the texels' centres meet, as depth.
fn ray_cast(scene: &Scene, light: &PointLight, resolution: u32) -> Vec<f64> {
    let reference = Reference::new(&scene.world_triangles().corners, None, light.position.as_dvec3());
    let size = resolution as usize;
    let depth = |index: usize| {
        let (face, row, column) = (index / (size * size), index / size % size, index % size);
        let d = light.orientation.as_dquat() * direction(face, column, row, resolution).as_dvec3();
        let hit = reference.nearest(d.normalize(), f64::from(light.near) * d.length());
        hit.map_or(0.0, |hit| f64::from(light.near) * d.length() / hit.t)
    };
    (0..6 * size * size).map(depth).collect()
}

/// Ways to share triangles out between what is drawn at once and what the tiles draw.
fn tunings() -> Vec<Tuning> {
    let own = Tuning::of(&gpu().device);
    let other = if own.workgroups == Workgroups::Gpu { Workgroups::Software } else { Workgroups::Gpu };
    vec![
        own,
        Tuning { small: Some(100_000), ..own },
        Tuning { small: Some(0), ..own },
        Tuning { small: Some(0), records: Some(1), ..own },
        Tuning { small: Some(0), room: 1, ..own },
        Tuning { reject: false, ..own },
        Tuning { workgroups: other, ..own },
        Tuning { workgroups: other, small: Some(0), ..own },
    ]
}

#[test]
fn the_computed_cube_is_what_rays_meet() {
    let orientation = Quat::from_euler(glam::EulerRot::XYZ, 0.5, -0.9, 2.0);
    let lights = [wide_light(), PointLight { orientation, coverage: Coverage::Hemisphere, ..wide_light() }];
    for (scene, light) in [random_scene(4000), procedural::many_small(300)].iter().flat_map(|s| lights.map(|l| (s, l)))
    {
        let resolution = 100;
        let expected = ray_cast(scene, &light, resolution);
        let mut casters = on_device(scene, Sides::Auto).chunked;
        let mut first: Option<(Vec<f32>, Vec<u32>)> = None;
        for tuning in tunings() {
            let mut cube = CubeCompute::tuned(&gpu().device, resolution, &tuning).unwrap();
            let recorded = gpu().submit(|to| cube.record(&gpu().device, &gpu().queue, to, &mut casters, &light));
            recorded.unwrap();
            let (depths, numbers) = (layers::<f32>(cube.map()), layers::<u32>(cube.numbers()));
            let is_wrong =
                |(depth, expected): &(&f32, &f64)| (f64::from(**depth) - **expected).abs() > 1e-5 * **expected;
            let wrong = depths.iter().zip(&expected).filter(is_wrong).count();
            // Rounding decides on the edges.
            assert!(wrong <= 3, "{tuning:?}: {wrong} of {} texels", depths.len());
            assert!(depths.iter().zip(&numbers).all(|(depth, number)| (*depth > 0.0) == (*number != u32::MAX)));
            let (first_depths, first_numbers) = first.get_or_insert_with(|| (depths.clone(), numbers.clone()));
            assert_eq!(differing(&depths, first_depths, 1e-5), 0, "{tuning:?}");
            // On a shared edge rounding decides.
            let renumbered = numbers.iter().zip(first_numbers).filter(|(a, b)| a != b).count();
            assert!(renumbered <= 5, "{tuning:?}: {renumbered} of {} texels", numbers.len());
        }
    }
}

#[test]
fn the_computed_cube_is_the_hardware_s() {
    for scene in [random_scene(20_000), baked(&procedural::many_small(400))] {
        let mut scene = on_device(&scene, Sides::Both);
        let drawn = depths(Method::Cube, 333, &mut scene, &wide_light());
        let computed = depths(Method::CubeCompute, 333, &mut scene, &wide_light());
        // The hardware snaps corners, so that an edge may fall to the other side of a texel's centre.
        let differing = differing(&drawn, &computed, 1e-2);
        assert!(differing < drawn.len() / 500, "{differing} of {} texels", drawn.len());
    }
}

#[test]
fn casters_out_of_range_are_culled() {
    let mut far = on_device(&room(Vec3::splat(-9.0), Vec3::splat(9.0)), Sides::Both);
    let light = PointLight { range: 5.0, ..Default::default() };
    for method in all_cubes() {
        let is_empty = depths(method, 32, &mut far, &light).iter().all(|depth| *depth == 0.0);
        assert_eq!(is_empty, method != Method::CubeUnculled, "{method}");
    }
}

#[test]
fn nothing_to_draw() {
    let mut scene = on_device(&Scene::default(), Sides::Both);
    for method in all_cubes().into_iter().chain([Method::VertexWarp, Method::DepthView]) {
        let depths = depths(method, 16, &mut scene, &PointLight::default());
        assert!(depths.iter().all(|depth| *depth == 0.0), "{method}");
    }
}

/// A floor of small quads and a ball between it and the light.
fn floor_and_ball() -> (Scene, PointLight) {
    let (count, size) = (80u32, 20.0);
    let at = |k: u32| size * (k as f32 / count as f32 - 0.5);
    let rows = (0..=count).flat_map(|z| (0..=count).map(move |x| Vec3::new(at(x), 0.0, at(z))));
    let corner = |x, z| z * (count + 1) + x;
    let quad = |x, z| {
        let [a, b, c, d] = [corner(x, z), corner(x, z + 1), corner(x + 1, z + 1), corner(x + 1, z)];
        [a, b, c, a, c, d]
    };
    let indices = (0..count).flat_map(|z| (0..count).flat_map(move |x| quad(x, z)));
    let floor = mesh(rows.collect(), indices.collect());
    let instances = vec![(0, Affine3A::IDENTITY), (1, Affine3A::from_translation(Vec3::Y * 2.0))];
    let light = PointLight {
        position: Vec3::Y * 4.0,
        orientation: Quat::from_rotation_x(0.4),
        range: 30.0,
        ..Default::default()
    };
    (scene_of(vec![floor, shapes::icosphere(0.5, 3)], instances), light)
}

#[test]
fn lookups_know_light_from_shadow() {
    let (scene, light) = floor_and_ball();
    let mut random = Pcg64::seed_from_u64(3);
    // The ball's shadow is a disc of radius 1.03.
    let mut ring = |low: f32, high: f32, count: usize| -> Vec<(Vec3, Vec3)> {
        let mut point = || {
            let turn = Quat::from_rotation_y(random.random_range(0.0..TAU));
            let normal = Vec3::Y * [1.0, -1.0, 3.0, -0.2][random.random_range(0..4)];
            (turn * Vec3::X * random.random_range(low..high), normal)
        };
        (0..count).map(|_| point()).collect()
    };
    let (dark, mut lit) = (ring(0.0, 0.85, 500), ring(1.4, 9.0, 3000));
    // Behind the ball, but out of range.
    lit.push((Vec3::Y * -27.0, Vec3::Y));
    let methods = all_cubes().into_iter().chain([Method::VertexWarp, Method::Paraboloid]);
    for (method, sides) in methods.flat_map(|m| [(m, Sides::Both), (m, Sides::Front)]) {
        let mut scene = on_device(&scene, sides);
        let mut baseline = Baseline::new(&gpu().device, method, 512).unwrap();
        if method == Method::VertexWarp {
            // Far out a texel spans 0.2 of the floor, and one reference has to do for four.
            baseline.set_bias(&gpu().queue, Lookup::VertexWarp, Bias { depth: 0.5, ..Bias::default() });
        }
        record(&mut baseline, &mut scene, &light);
        assert!(!method.lookups().is_empty());
        for &lookup in method.lookups() {
            let values = |receivers: &[(Vec3, Vec3)]| baseline.shadow_values(gpu(), lookup, receivers).unwrap();
            // The weights' sum is 1 but for rounding.
            let wrong = |values: Vec<f32>, right: f32| values.into_iter().filter(|v| (v - right).abs() > 1e-6).count();
            assert_eq!(wrong(values(&dark), 0.0), 0, "{method}, {}: dark", lookup.name());
            assert_eq!(wrong(values(&lit), 1.0), 0, "{method}, {}: lit", lookup.name());
        }
    }
}

/// On a floor seen at a grazing angle, where a constant bias has most to do.
#[test]
fn the_plane_lookup_has_no_acne() {
    let (low, high) = (Vec3::new(-8.0, -1.0, -8.0), Vec3::new(8.0, 3.0, 8.0));
    let mut scene = on_device(&room(low, high), Sides::Both);
    let light = PointLight { position: Vec3::new(0.7, -0.6, 0.2), range: 50.0, ..Default::default() };
    let cube = recorded(Method::Cube, 256, &mut scene, &light);
    let mut random = Pcg64::seed_from_u64(9);
    let mut floor = || Vec3::new(random.random_range(-5.0..5.0), low.y, random.random_range(-5.0..5.0));
    let receivers: Vec<(Vec3, Vec3)> = (0..5000).map(|_| (floor(), Vec3::Y)).collect();
    let values = cube.shadow_values(gpu(), Lookup::CubePlane, &receivers).unwrap();
    assert_eq!(values.iter().filter(|value| **value < 1.0 - 1e-6).count(), 0);
    assert!(cube.shadow_values(gpu(), Lookup::Paraboloid, &receivers).is_none());
}

/// The walk that this library has in the pair, in a cube: as right as there, and far more so than the votes at their best.
#[test]
fn walks_in_a_cube_are_as_right_as_in_the_pair() {
    for scene in [procedural::few_large(), procedural::many_small(200)] {
        let (light, _) = choose_light(&scene, None, None);
        let light = PointLight { orientation: Quat::from_euler(glam::EulerRot::XYZ, 0.5, -0.9, 2.0), ..light };
        let truth = Truth::new(&scene, &light, 50_000, 1);
        let mut casters = on_device(&scene, Sides::Auto);
        let mut judge = Judge::new(gpu(), light, &truth);
        for pair in [128, 512] {
            let mut wrong = |method: Method, lookup| {
                let side = method.side(pair, Budget::EqualTexels);
                let mut baseline = Baseline::new(&gpu().device, method, side).unwrap();
                let answers = judge.answers(&mut baseline, lookup, &mut casters).unwrap().unwrap();
                truth.wrong_ppm(&answers.values)
            };
            let walks = wrong(Method::CubeCompute, Lookup::CubeWalk);
            let votes = wrong(Method::CubeCompute, Lookup::CubePlane);
            let own = wrong(Method::Paraboloid, Lookup::Paraboloid);
            assert!(walks < 0.4 * votes && walks < 2.0 * own + 60.0, "{pair}: {walks}, votes {votes}, pair {own}");
        }
    }
}

#[test]
fn warped_and_plain_views_hold_something() {
    let mut scene = on_device(&procedural::many_small(300), Sides::Both);
    let light = wide_light();
    let warped = depths(Method::VertexWarp, 128, &mut scene, &light);
    let view = depths(Method::DepthView, 128, &mut scene, &light);
    for (method, map) in [(Method::VertexWarp, warped), (Method::DepthView, view)] {
        let drawn = map.iter().filter(|depth| **depth > 0.0).count();
        assert!(drawn > map.len() / 3, "{method}: {drawn} of {} texels", map.len());
        assert!(map.iter().all(|depth| (0.0..=1.0).contains(depth)), "{method}");
    }
}

#[test]
fn every_recording_starts_anew() {
    let (scene, light) = floor_and_ball();
    let mut scene = on_device(&scene, Sides::Both);
    let elsewhere = PointLight { position: light.position + Vec3::X, ..light };
    for method in all_cubes().into_iter().chain([Method::VertexWarp, Method::Paraboloid]) {
        let mut baseline = Baseline::new(&gpu().device, method, 64).unwrap();
        let mut map = |light: &PointLight| -> Vec<f32> {
            record(&mut baseline, &mut scene, light);
            gpu().read_texture(baseline.map(), 0)
        };
        let [first, other, again] = [&light, &elsewhere, &light].map(&mut map);
        assert!(first != other && first == again, "{method}");
    }
}

#[test]
fn a_turned_light_over_a_turned_scene_makes_the_same_map() {
    let scene = procedural::many_small(300);
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.4, 1.1, -0.7);
    let mut turned = scene.clone();
    for instance in &mut turned.instances {
        instance.transform = Affine3A::from_quat(turn) * instance.transform;
    }
    let light = PointLight { position: Vec3::new(0.3, 1.2, -0.4), range: 40.0, ..Default::default() };
    let turned_light = PointLight { position: turn * light.position, orientation: turn, ..light };
    let (mut scene, mut turned) = (on_device(&scene, Sides::Both), on_device(&turned, Sides::Both));
    for method in all_cubes() {
        let as_it_was = depths(method, 128, &mut scene, &light);
        let both = depths(method, 128, &mut turned, &turned_light);
        // Corners are rounded elsewhere, so that an edge may fall to the other side of a texel's centre.
        let differing_texels = differing(&as_it_was, &both, 1e-3);
        assert!(differing_texels < as_it_was.len() / 200, "{method}: {differing_texels} differ");
        let scene_alone = depths(method, 128, &mut turned, &PointLight { orientation: Quat::IDENTITY, ..turned_light });
        assert!(differing(&as_it_was, &scene_alone, 1e-3) > as_it_was.len() / 4, "{method}");
    }
}

/// The same surfaces by depth of two bytes, of which the near plane lies before the nearest one.
#[test]
fn depth_of_two_bytes_is_that_of_four_rounded() {
    let (scene, light) = floor_and_ball();
    let mut scene = on_device(&scene, Sides::Both);
    let (resolution, nearest) = (200u32, 1.45);
    let float = depths(Method::Cube, resolution, &mut scene, &light);
    let mut cube = Baseline::new(&gpu().device, Method::Cube16, resolution).unwrap();
    cube.set_nearest(nearest);
    record(&mut cube, &mut scene, &light);
    let unorm: Vec<u16> = (0..6).flat_map(|layer| gpu().read_texture(cube.map(), layer)).collect();
    let half_width = resolution as f32 / (resolution as f32 - 1.031_25);
    let near = 0.999 * nearest / (1.0 + 2.0 * half_width * half_width).sqrt();
    assert!(unorm.iter().any(|depth| *depth > 0) && unorm.len() == float.len());
    for (float, unorm) in float.into_iter().zip(unorm) {
        // 1 at the near plane, 0 at the range, even in 1 / z.
        let z = light.near / float;
        let expected = (near * (light.range - z) / (z * (light.range - near))).max(0.0);
        let stored = f32::from(unorm) / 65535.0;
        assert!((stored - expected).abs() < 1.0 / 65535.0, "{stored}, not {expected}");
    }
}

#[test]
fn biases_need_no_recording() {
    let (scene, light) = floor_and_ball();
    let mut scene = on_device(&scene, Sides::Both);
    let mut random = Pcg64::seed_from_u64(3);
    let mut floor = || Vec3::new(random.random_range(-9.0..9.0), 0.0, random.random_range(-9.0..9.0));
    let receivers: Vec<(Vec3, Vec3)> = (0..2000).map(|_| (floor(), Vec3::Y)).collect();
    for (method, lookup) in [
        (Method::VertexWarp, Lookup::VertexWarp),
        (Method::Cube, Lookup::CubeHardware),
        (Method::Cube, Lookup::CubePlane),
        (Method::Cube16, Lookup::CubeHardware),
    ] {
        let mut baseline = recorded(method, 100, &mut scene, &light);
        let lit = |baseline: &Baseline, lookup| -> f32 {
            baseline.shadow_values(gpu(), lookup, &receivers).unwrap().iter().sum()
        };
        let shipped = *method.lookups().last().unwrap();
        let shipped_before = lit(&baseline, shipped);
        let default = lit(&baseline, lookup);
        // Nothing is before a receiver that is moved all the way.
        let away = Bias { depth: 3.9, ray: 100.0, normal: 0.0 };
        baseline.set_bias(&gpu().queue, lookup, away);
        assert!(lit(&baseline, lookup) > 1999.0 && default < 1990.0, "{method}: {default}");
        baseline.set_bias(&gpu().queue, lookup, lookup.default_bias().unwrap());
        assert_eq!(lit(&baseline, lookup), default, "{method}");
        // The shipped bias is what it is.
        baseline.set_bias(&gpu().queue, shipped, away);
        assert_eq!(lit(&baseline, shipped), shipped_before, "{method}");
    }
}

#[test]
fn the_best_bias_is_no_worse_than_the_default() {
    let scene = procedural::few_large();
    let (light, _) = choose_light(&scene, None, None);
    let truth = Truth::new(&scene, &light, 20_000, 1);
    let mut scene = on_device(&scene, Sides::Auto);
    let mut judge = Judge::new(gpu(), light, &truth);
    for (method, lookup) in [
        (Method::VertexWarp, Lookup::VertexWarp),
        (Method::Cube, Lookup::CubeHardware),
        (Method::Cube, Lookup::CubePlane),
        (Method::Cube16, Lookup::CubeHardware),
    ] {
        let mut baseline = Baseline::new(&gpu().device, method, 148).unwrap();
        let found = judge.answers(&mut baseline, lookup, &mut scene).unwrap().unwrap();
        assert!(found.bias.is_some_and(|bias| bias.depth >= 0.0 && bias.ray >= 0.0 && bias.normal >= 0.0));
        // The baseline keeps it.
        assert_eq!(baseline.shadow_values(gpu(), lookup, &truth.inputs()).unwrap(), found.values, "{method}");
        baseline.set_bias(&gpu().queue, lookup, lookup.default_bias().unwrap());
        let default = baseline.shadow_values(gpu(), lookup, &truth.inputs()).unwrap();
        assert!(truth.wrong_ppm(&found.values) <= truth.wrong_ppm(&default), "{method}");
        let shipped = *method.lookups().last().unwrap();
        let shipped = judge.answers(&mut baseline, shipped, &mut scene).unwrap().unwrap();
        assert!(shipped.bias.is_none() || lookup == Lookup::CubePlane, "{method}");
    }
    let mut pair = Baseline::new(&gpu().device, Method::Paraboloid, 64).unwrap();
    assert!(judge.answers(&mut pair, Lookup::CubePlane, &mut scene).unwrap().is_none());
}

/// By hand: uniform slots of 256 bytes, room for 256 instances of 4 bytes, descriptions of a light of 96 and 64 bytes.
#[test]
fn bytes_of_each_method() {
    let mut scene = on_device(&procedural::few_large(), Sides::Both);
    let resolution = 16;
    for (method, per_light, workspace) in [
        (Method::VertexWarp, 2 * 256 * 4, Some(2 * 256 + 1024 + 64)),
        (Method::Cube, 6 * 256 * 4, Some(6 * 256 + 1024 + 96)),
        (Method::Cube16, 6 * 256 * 2, Some(6 * 256 + 1024 + 96)),
        (Method::DepthView, 2 * 256 * 4, Some(256 + 1024)),
        (Method::Paraboloid, 2 * 256 * 8, None),
        (Method::CubeCompute, 6 * 256 * 8, None),
        (Method::CubeRouted, 6 * 256 * 4, None),
    ] {
        let baseline = recorded(method, resolution, &mut scene, &wide_light());
        assert_eq!(baseline.bytes_per_light(), per_light, "{method}");
        let reads_casters = matches!(method, Method::Paraboloid | Method::CubeRouted | Method::CubeCompute);
        let own_scene = if reads_casters { scene.chunked.memory() } else { 0 };
        assert_eq!(baseline.bytes_scene(&scene), own_scene, "{method}");
        if let Some(workspace) = workspace {
            assert_eq!(baseline.bytes_workspace(), workspace, "{method}");
        }
        let shadows = baseline.shadows().map_or(baseline.memory(), |shadows| shadows.memory());
        assert_eq!(baseline.memory(), shadows, "{method}");
    }
}

#[test]
fn what_is_left_out_says_why() {
    assert!(!Method::CubeMultiview.is_available(gpu()) && Method::Cube.left_out(gpu()).is_none());
    let error = Baseline::new(&gpu().device, Method::CubeMultiview, 64).unwrap_err().to_string();
    let reason = "it needs a device with multiview over six layers, requested with wgpu::Features::MULTIVIEW";
    assert_eq!(error, format!("cube-multiview is left out: {reason}"));
    assert_eq!(Method::CubeMultiview.left_out(gpu()), Some(reason));
}

#[test]
fn names_round_trip() {
    for method in Method::ALL {
        assert_eq!(method.name().parse::<Method>(), Ok(method));
        assert_eq!(method.to_string(), method.name());
    }
    let error = "sphere".parse::<Method>().unwrap_err().to_string();
    assert!(error.contains("\"sphere\"") && error.contains("cube-routed"), "{error}");
}

#[test]
fn budgets_are_kept() {
    assert_eq!(Method::Cube.side(1024, Budget::EqualSide), 1024);
    for method in Method::ALL {
        let side = method.side(896, Budget::EqualTexels);
        let texels = u64::from(method.squares()) * u64::from(side) * u64::from(side);
        let share = texels as f64 / f64::from(2 * 896 * 896);
        assert!((share - 1.0).abs() < 0.003, "{method}: {share}");
        match Baseline::new(&gpu().device, method, side) {
            Ok(baseline) => {
                assert_eq!(baseline.texels(), texels, "{method}");
                assert_eq!(baseline.bytes_per_light(), method.bytes_per_texel() * texels, "{method}");
            }
            Err(error) => assert!(matches!(error, BaselineError::Unsupported { .. }), "{error}"),
        }
    }
}

#[test]
fn wrong_resolutions_are_refused() {
    for resolution in [0, u32::MAX] {
        let error = Baseline::new(&gpu().device, Method::Cube, resolution).unwrap_err();
        assert!(matches!(error, BaselineError::Resolution { .. }), "{error}");
    }
}

#[test]
fn timing_takes_turns() {
    let mut order = Vec::new();
    let rounds = Rounds { warm_up: 1, measured: 3 };
    let times = Timer::new(gpu()).interleaved(3, rounds, |way, _| order.push(way));
    assert_eq!(order, [0, 1, 2, 1, 2, 0, 2, 0, 1, 0, 1, 2]);
    assert_eq!(times.len(), 3);
    for time in times {
        assert!(time.gpu.min <= time.gpu.median && time.gpu.median <= time.gpu.max);
        assert!(time.cpu.min <= time.cpu.median && time.cpu.median <= time.cpu.max);
    }
}

#[test]
fn screen_passes_answer_as_the_lookups_do() {
    let scene = procedural::few_large();
    let light = PointLight { position: Vec3::new(0.0, 4.0, 0.0), range: 40.0, ..Default::default() };
    let shot = Shot::take(&scene, &scene.suggest_camera(light.position), 96, 54);
    let bench = LookupBench::new(gpu(), &scene, &light, &shot, 128).unwrap();
    let own = bench.answers(Question::Lookup(Lookup::Votes), PassStage::Fragment);
    assert!(own.contains(&0.0) && own.contains(&1.0));
    // The same four texels, loaded one by one: weights and references differ by rounding.
    let loaded = bench.answers(Question::Texels(2), PassStage::Fragment);
    assert!(own.iter().zip(&loaded).filter(|(a, b)| (*a - *b).abs() > 1e-3).count() <= own.len() / 1000);
    let differing = |other: Question| {
        let other = bench.answers(other, PassStage::Fragment);
        assert!(other.iter().all(|share| (0.0..=1.0 + 1e-6).contains(share)));
        own.iter().zip(&other).filter(|(a, b)| (**a >= 0.5) != (**b >= 0.5)).count()
    };
    // Filters of other widths agree but near boundaries, and so does the cube.
    let of_pair = [Question::Texels(1), Question::Texels(3), Question::Point, Question::Lookup(Lookup::Paraboloid)];
    let of_cubes = [Lookup::CubePlane, Lookup::CubeWalk].map(Question::Lookup);
    for question in of_pair.into_iter().chain(of_cubes) {
        assert!(differing(question) < own.len() / 10, "{}", question.name());
    }
    for kernel in [Kernel::Square3, Kernel::Square5, Kernel::Disc, Kernel::Soft] {
        for question in [Question::Filter(kernel), Question::CubeFilter(kernel)] {
            assert!(differing(question) < own.len() / 5, "{}: {}", question.name(), differing(question));
        }
    }
    // Both kinds of pass say the same; compilers may round differently.
    for question in Question::all() {
        let [compute, fragment] = [PassStage::Compute, PassStage::Fragment].map(|stage| bench.answers(question, stage));
        let differing = compute.iter().zip(&fragment).filter(|(a, b)| (*a - *b).abs() > 1e-3).count();
        assert!(differing <= own.len() / 500, "{}: {differing} pixels", question.name());
    }
}

/// What a pass over several lights writes is the sum of what passes over each of them do.
#[test]
fn lights_are_asked_one_by_one() {
    let scene = procedural::few_large();
    let at = |x| PointLight { position: Vec3::new(x, 4.0, 0.0), range: 40.0, ..Default::default() };
    let lights = [at(0.0), at(2.5)];
    let shot = Shot::take(&scene, &scene.suggest_camera(lights[0].position), 96, 54);
    let bench = |lights: &[PointLight]| LightsBench::new(gpu(), &scene, lights, &shot, &[128, 32]).unwrap();
    let (both, each) = (bench(&lights), lights.map(|light| bench(&[light])));
    let single = LookupBench::new(gpu(), &scene, &lights[0], &shot, 128).unwrap();
    for (question, same) in [
        (LightsQuestion::HardwareCube, Some(Lookup::CubeHardware)),
        (LightsQuestion::Exact(128), Some(Lookup::Paraboloid)),
        (LightsQuestion::Votes(128), Some(Lookup::Votes)),
        (LightsQuestion::CubeWalk(128), Some(Lookup::CubeWalk)),
        (LightsQuestion::Points(32), None),
        (LightsQuestion::Mixed(32), None),
    ] {
        for stage in PassStage::ALL {
            let answers = |bench: &LightsBench| bench.answers(question, stage).unwrap();
            let [first, second] = each.each_ref().map(answers);
            let differing = |a: &[f32], b: &[f32]| a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 1e-3).count();
            let sum: Vec<f32> = first.iter().zip(&second).map(|(a, b)| a + b).collect();
            assert!(differing(&first, &second) > 50, "{}", question.name());
            assert!(differing(&answers(&both), &sum) <= sum.len() / 500, "{}", question.name());
            if let Some(lookup) = same {
                let alone = single.answers(Question::Lookup(lookup), stage);
                assert!(differing(&first, &alone) <= sum.len() / 500, "{}", question.name());
            }
        }
    }
}

#[test]
fn what_the_device_refuses_is_an_error() {
    let empty = |width| {
        gpu().attempt(|| {
            gpu().device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width, height: 4, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Depth32Float,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        })
    };
    assert!(empty(0).is_err() && empty(4).is_ok());
    let required_limits = wgpu::Limits { max_buffer_size: 1 << 15, ..Default::default() };
    let (small, _) = wgpu::Device::noop(&wgpu::DeviceDescriptor { required_limits, ..Default::default() });
    let refused = SceneBuffers::new(&small, &procedural::dense(10_000), false).map(|_| ()).unwrap_err();
    assert!(matches!(refused, Error::CastersTooLarge { limit: 32_768, .. }), "{refused}");
    assert!(SceneBuffers::new(&small, &procedural::few_large(), false).is_ok());
}
