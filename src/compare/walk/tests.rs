//! Walks against a search through all triangles, and lookups that walk against those that vote.

use super::*;
use crate::PointLight;
use crate::compare::error_figures::ShadowError;
use crate::compare::ideal::{BIAS, Lookup, MapGeometry, NO_TRIANGLE, NORMAL_BIAS, ideal_map};
use crate::compare::measure::{Truth, light_for};
use crate::compare::procedural::shapes::{append, cuboid, icosphere, quad, torus_knot};
use crate::compare::scene::{Scene, SceneInstance, SceneMesh};
use crate::compare::test_shapes::random_direction;
use glam::{Affine3A, DVec3, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

fn scene(meshes: Vec<SceneMesh>) -> Scene {
    let instance = |mesh| SceneInstance { mesh, transform: Affine3A::IDENTITY };
    Scene { instances: (0..meshes.len()).map(instance).collect(), meshes, ..Scene::default() }
}

fn mesh(positions: Vec<Vec3>, indices: Vec<u32>) -> SceneMesh {
    SceneMesh { positions: positions.into_iter().map(Vec3::into).collect(), indices, ..SceneMesh::default() }
}

fn floor() -> SceneMesh {
    quad(Vec3::new(-4.0, -2.0, -4.0), 8.0 * Vec3::Z, 8.0 * Vec3::X)
}

/// Triangles between few points in a box: edges that many share, crossing and coinciding triangles, all windings.
fn soup(seed: u64) -> SceneMesh {
    let mut random = Pcg64::seed_from_u64(seed);
    let positions = (0..40).map(|_| random_direction(&mut random).as_vec3() * Vec3::new(1.5, 0.7, 1.5)).collect();
    let triangle = |_| [0; 3].map(|_: u32| random.random_range(0..40));
    mesh(positions, (0..90).flat_map(triangle).collect())
}

/// Waves over a grid of `n` x `n` squares, whose triangles are made of their corners' numbers.
fn grid(n: u32, triangles: impl Fn(u32, u32, [u32; 4]) -> Vec<[u32; 3]>) -> SceneMesh {
    let at = |k: u32| 3.0 * k as f32 / n as f32 - 1.5;
    let wave = |x: f32, z: f32| 0.2 * (3.0 * x).sin() * (4.0 * z).cos() - 0.5;
    let corners = (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j)));
    let positions = corners.map(|(i, j)| Vec3::new(at(i), wave(at(i), at(j)), at(j))).collect();
    let number = |i, j| j * (n + 1) + i;
    let squares = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    let corners = |i, j| [number(i, j), number(i, j + 1), number(i + 1, j + 1), number(i + 1, j)];
    mesh(positions, squares.flat_map(|(i, j)| triangles(i, j, corners(i, j))).flatten().collect())
}

fn halves([a, b, c, d]: [u32; 4]) -> Vec<[u32; 3]> {
    vec![[a, b, c], [a, c, d]]
}

/// Triangles wound this way and that.
fn flipped_windings(mesh: &SceneMesh) -> SceneMesh {
    let mut random = Pcg64::seed_from_u64(3);
    let mut flipped = mesh.clone();
    for corners in flipped.indices.as_chunks_mut::<3>().0 {
        if random.random() {
            corners.swap(0, 2);
        }
    }
    flipped
}

/// A strip whose squares have twice as many corners on one side as on the other: with and without triangles of no area
/// where they meet.
fn junctions(closed: bool) -> SceneMesh {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for k in 0..12 {
        let x = 0.25 * k as f32 - 1.5;
        let n = positions.len() as u32;
        let points = [(0.0, -1.0), (0.25, -1.0), (0.0, 0.0), (0.125, 0.0), (0.25, 0.0), (0.0, 1.0), (0.25, 1.0)];
        positions.extend(points.map(|(dx, z)| Vec3::new(x + dx, -0.5, z)));
        let triangles = [[0, 2, 4], [0, 4, 1], [2, 5, 3], [3, 5, 6], [3, 6, 4]];
        indices.extend(triangles.as_flattened().iter().map(|corner| n + corner));
        if closed {
            indices.extend([2, 3, 4].map(|corner| n + corner));
        }
    }
    mesh(positions, indices)
}

/// Walls on the edges of a floor of squares.
fn fins() -> SceneMesh {
    let mut mesh = grid(12, |_, _, corners| halves(corners));
    for square in 0..12 {
        let edge = [13 * square + square, 13 * square + square + 1];
        let top = mesh.positions.len() as u32;
        mesh.positions.push((Vec3::from(mesh.positions[edge[0] as usize]) + 0.4 * Vec3::Y).to_array());
        mesh.indices.extend([edge[0], edge[1], top]);
    }
    mesh
}

fn twice(mesh: &SceneMesh, reversed: bool) -> SceneMesh {
    let mut both = mesh.clone();
    let again = mesh.indices.as_chunks::<3>().0.iter();
    both.indices.extend(again.flat_map(|&[a, b, c]| if reversed { [c, b, a] } else { [a, b, c] }));
    both
}

/// Boxes that touch one another with faces and with edges.
fn abutting() -> SceneMesh {
    let mut all = SceneMesh { normals: Some(Vec::new()), ..SceneMesh::default() };
    for (x, z) in [(0, 0), (1, 0), (2, 1), (0, 2), (1, 2)] {
        let low = Vec3::new(0.5 * x as f32 - 0.75, -1.0, 0.5 * z as f32 - 0.75);
        append(&mut all, &cuboid(low, low + Vec3::new(0.5, 0.5, 0.5)), Affine3A::IDENTITY);
    }
    all
}

/// Everything that meshes do to one another, each over a floor.
fn hard_cases() -> Vec<(&'static str, Scene)> {
    let mirrored = SceneInstance {
        mesh: 0,
        transform: Affine3A::from_translation(Vec3::new(1.0, 0.3, 0.0))
            * Affine3A::from_scale(Vec3::new(-0.6, 0.5, 0.4)),
    };
    let mut mirror = scene(vec![torus_knot(0.6, 120, 16), floor()]);
    mirror.instances.push(mirrored);
    let sheet = grid(16, |_, _, corners| halves(corners));
    vec![
        ("soup", scene(vec![soup(1), soup(2), floor()])),
        ("closed shells", scene(vec![icosphere(0.8, 2), icosphere(0.5, 1), floor()])),
        ("dense", scene(vec![torus_knot(0.6, 600, 64), floor()])),
        ("T-junctions", scene(vec![junctions(false), floor()])),
        ("triangles of no area in the way", scene(vec![junctions(true), floor()])),
        ("edges of three", scene(vec![fins(), floor()])),
        ("flipped windings", scene(vec![flipped_windings(&sheet), floor()])),
        ("mirrored instances", mirror),
        ("sheets on one another, back to back", scene(vec![twice(&sheet, true), floor()])),
        ("sheets on one another, wound alike", scene(vec![twice(&sheet, false), floor()])),
        ("abutting boxes", scene(vec![abutting(), floor()])),
    ]
}

fn lamp(scene: &Scene) -> PointLight {
    light_for(scene, Vec3::new(0.31, 1.63, -0.22))
}

/// A scene's lookups on a ray-cast map, by votes, by walks, and by walks whose texels have no numbers.
struct Errors {
    votes: ShadowError,
    walks: ShadowError,
    unnumbered: ShadowError,
    mixed: usize,
}

fn errors(scene: &Scene, steps: u32) -> Errors {
    let truth = Truth::new(scene, &lamp(scene), 30_000, 1);
    let geometry = MapGeometry { resolution: 128, guard: 0.05 };
    let map = ideal_map(&truth.reference, &truth.view, geometry);
    let lookup = Lookup { view: truth.view, geometry, bias: BIAS, normal_bias: NORMAL_BIAS };
    let ideal = IdealWalks::new(scene);
    let walks = ideal.shadows(&truth, &map, steps);
    let unnumbered = double::Exact {
        view: truth.view,
        geometry,
        normal_bias: NORMAL_BIAS,
        receiver_offset: 0.0,
        made: Surface::FIRST,
        depths: &map.depths,
        numbers: &vec![NO_TRIANGLE; geometry.texels()],
        surface: &ideal.surface,
        is_hole: &|_, _| false,
        steps,
    };
    let inputs = || truth.receivers.iter().map(|r| (r.position.as_dvec3(), r.normal.as_dvec3()));
    let mixed = inputs().filter(|&(p, n)| unnumbered.is_mixed(p, n)).count();
    let votes: Vec<f32> = inputs().map(|(p, n)| lookup.shadow(|texel| map.depths[texel], p, n) as f32).collect();
    let unnumbered: Vec<f32> = inputs().map(|(p, n)| unnumbered.walk_shadow(p, n) as f32).collect();
    let [votes, walks, unnumbered] = [votes, walks, unnumbered].map(|values| truth.judge(&values));
    Errors { votes, walks, unnumbered, mixed }
}

#[test]
fn walks_leak_no_more_than_votes() {
    for (name, scene) in hard_cases() {
        for steps in [0, 1, 4, STEPS, 256] {
            let Errors { votes, walks, unnumbered, mixed } = errors(&scene, steps);
            assert!(mixed > 100, "{name}: {mixed}");
            let figures = format!("{name}, {steps} steps: {walks:?} {votes:?}");
            assert!(walks.leak_ppm <= votes.leak_ppm && walks.wrong_ppm <= votes.wrong_ppm, "{figures}");
            assert!(unnumbered.leak_ppm <= votes.leak_ppm, "{name}: {unnumbered:?} {votes:?}");
        }
    }
}

/// What a walk finds is there: the triangle has the ray inside it, at that distance.
#[test]
fn what_covers_the_ray_covers_it() {
    let mut random = Pcg64::seed_from_u64(5);
    for (name, scene) in hard_cases() {
        let (surface, numbers) = Surface::new(&scene);
        let numbers: Vec<u32> = numbers.into_iter().filter(|number| *number != NO_TRIANGLE).collect();
        let light = lamp(&scene).position;
        let mut found = [0; 2];
        for _ in 0..20_000 {
            let ray = random_direction(&mut random);
            let start = numbers[random.random_range(0..numbers.len())];
            let frame = double::walk_frame(light.as_dvec3(), ray);
            if let double::Walk::Covers { distance, triangle } =
                double::walk_from(&surface, start, Surface::FIRST, &frame, 1000)
            {
                check_cover(&surface, triangle, light, ray * distance, 1e-12);
                found[0] += 1;
            }
            let ray = ray.as_vec3().normalize();
            let frame = single::walk_frame(light, ray);
            if let single::Walk::Covers { distance, triangle } =
                single::walk_from(&surface, start, Surface::FIRST, &frame, 1000)
            {
                check_cover(&surface, triangle, light, ray.as_dvec3() * f64::from(distance), 2e-6);
                found[1] += 1;
            }
        }
        assert!(found.iter().all(|found| *found > 20), "{name}: {found:?}");
    }
}

/// Whether a point relative to the light is one of a triangle, but for `rounding` of its coordinates.
fn check_cover(surface: &Surface, number: u32, light: Vec3, point: DVec3, rounding: f64) {
    let corners = surface.triangle(number).corners;
    let [a, b, c] = corners.map(|vertex| surface.vertex(vertex).as_dvec3() - light.as_dvec3());
    let normal = (b - a).cross(c - a).normalize();
    let reach = rounding * point.length().max(a.length());
    // Nearly edge-on the distance is uncertain, but on the ray.
    let grazing = 1.0 / normal.dot(point.normalize()).abs().max(1e-9);
    assert!(normal.dot(point - a).abs() <= 4.0 * reach, "{point} off the plane of {number}");
    for (from, to) in [(a, b), (b, c), (c, a)] {
        let inward = normal.cross(to - from).normalize();
        assert!(inward.dot(point - from) >= -4.0 * reach * grazing, "{point} outside of {number}");
    }
}

/// From within a closed shell that is seen whole, a walk gets from everywhere to everywhere.
#[test]
fn walks_inside_a_ball_arrive() {
    let scene = scene(vec![icosphere(1.0, 3)]);
    let (surface, numbers) = Surface::new(&scene);
    let light = Vec3::new(0.1, 0.2, -0.15);
    let truth = Truth::new(&scene, &light_for(&scene, light), 10, 1);
    let mut random = Pcg64::seed_from_u64(6);
    for _ in 0..2000 {
        let ray = random_direction(&mut random);
        let start = numbers[random.random_range(0..numbers.len())];
        let hit = truth.reference.nearest(ray, 0.0).expect("a shell all around");
        let frame = double::walk_frame(light.as_dvec3(), ray);
        match double::walk_from(&surface, start, Surface::FIRST, &frame, 1000) {
            double::Walk::Covers { distance, .. } => assert!((distance / hit.t - 1.0).abs() < 1e-9, "{ray}"),
            end => panic!("{end:?} from {start} towards {ray}"),
        }
    }
}

/// A ball from outside: the rays that miss it are beyond its silhouette, and a walk says so where it gets there.
#[test]
fn walks_end_at_silhouettes() {
    let scene = scene(vec![icosphere(1.0, 4)]);
    let (surface, numbers) = Surface::new(&scene);
    let light = DVec3::new(0.4, 3.0, -0.3);
    let mut random = Pcg64::seed_from_u64(7);
    for _ in 0..2000 {
        let start = numbers[random.random_range(0..numbers.len())];
        let [a, b, c] = surface.triangle(start).corners.map(|vertex| surface.vertex(vertex).as_dvec3());
        if (b - a).cross(c - a).dot(a - light) > 0.0 {
            continue;
        }
        let ray = (random_direction(&mut random) * 1.3 - light).normalize();
        let frame = double::walk_frame(light, ray);
        let beside = ray.cross(light).length();
        if (0.99..1.0).contains(&beside) {
            continue;
        }
        let misses = beside >= 1.0;
        let end = double::walk_from(&surface, start, Surface::FIRST, &frame, 200);
        assert_eq!(end == double::Walk::Off, misses, "{end:?} from {start} towards {ray}");
    }
}

#[test]
fn windings_do_not_matter() {
    let sheet = grid(24, |_, _, corners| halves(corners));
    let scenes = [flipped_windings(&sheet), sheet].map(|sheet| scene(vec![sheet]));
    let surfaces = scenes.each_ref().map(Surface::new);
    let light = lamp(&scenes[0]).position.as_dvec3();
    let mut random = Pcg64::seed_from_u64(8);
    let mut covered = 0;
    for _ in 0..2000 {
        let triangle = random.random_range(0..scenes[0].triangle_count());
        let ray = (random_direction(&mut random) * DVec3::new(1.8, 0.1, 1.8) - light - 0.5 * DVec3::Y).normalize();
        let frame = double::walk_frame(light, ray);
        let [flipped, plain] = surfaces.each_ref().map(|(surface, numbers)| {
            match double::walk_from(surface, numbers[triangle], Surface::FIRST, &frame, 100) {
                double::Walk::Covers { distance, .. } => Some(distance),
                double::Walk::Off => None,
                double::Walk::Lost => panic!("lost from {triangle} towards {ray}"),
            }
        });
        assert_eq!(flipped.is_some(), plain.is_some(), "from {triangle} towards {ray}");
        covered += usize::from(plain.is_some());
        assert!((flipped.unwrap_or(1.0) / plain.unwrap_or(1.0) - 1.0).abs() < 1e-12);
    }
    assert!((500..1900).contains(&covered), "{covered}");
}
