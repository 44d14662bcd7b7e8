//! The scene: a plaza with lamps over it, a tree beside each, a banner, and figures that walk in circles.

use crate::{cloth, foliage};
use dual_paraboloid::PointLight;
use dual_paraboloid::compare::procedural::shapes;
use dual_paraboloid::compare::scene::{Camera, Material, Scene, SceneInstance, SceneMesh};
use glam::{Affine3A, DVec3, Quat, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::f32::consts::TAU;
use std::f64::consts::PI;

/// Metres between neighbouring lamps.
const SPACING: f32 = 8.0;
const LAMP_HEIGHT: f32 = 4.5;
/// Of the banner's upper edge.
const BANNER_HEIGHT: f32 = 3.6;
/// Square metres a figure has at least; with many of them the plaza is larger than its lamps reach.
const ROOM: f32 = 2.0;
const STONE: [f32; 3] = [0.52, 0.47, 0.42];
const BARK: [f32; 3] = [0.20, 0.14, 0.09];
const CANVAS: [f32; 3] = [0.74, 0.58, 0.36];
const CLOTHES: [[f32; 3]; 4] = [[0.66, 0.26, 0.15], [0.10, 0.38, 0.40], [0.70, 0.50, 0.16], [0.35, 0.33, 0.40]];

/// Where a figure walks.
struct Walk {
    centre: Vec3,
    radius: f32,
    phase: f32,
    /// Radians a second; 0 for one that stands.
    speed: f32,
}

pub struct Plaza {
    pub scene: Scene,
    pub lights: Vec<PointLight>,
    /// The banner among the scene's instances.
    pub cloth: usize,
    walks: Vec<Walk>,
    /// The first figure among the scene's instances.
    first: usize,
    half_width: f32,
}

impl Plaza {
    /// With lights that reach `range` metres; the first `walking` of the `figures` walk.
    pub fn new(lights: u32, range: f32, figures: u32, walking: u32) -> Self {
        let side = f64::from(lights).sqrt().ceil() as u32;
        let half_width = (0.5 * SPACING * side as f32).max(0.5 * (ROOM * figures as f32).sqrt());
        let mut scene = Scene { name: "plaza".to_owned(), ..Scene::default() };
        let low = Vec3::new(-half_width, -0.5, -half_width);
        add(&mut scene, shapes::cuboid(low, Vec3::new(half_width, 0.0, half_width)), STONE, Affine3A::IDENTITY);
        let post = shapes::cylinder(0.08, LAMP_HEIGHT, 12);
        let at = |k: u32, height| {
            let cell = |k: u32| SPACING * (k as f32 - 0.5 * (side - 1) as f32);
            Vec3::new(cell(k % side), height, cell(k / side))
        };
        add(&mut scene, post, STONE, Affine3A::from_translation(at(0, 0.0) + Vec3::X));
        let mesh = scene.meshes.len() - 1;
        let posts = (1..lights).map(|k| Affine3A::from_translation(at(k, 0.0) + Vec3::X));
        scene.instances.extend(posts.map(|transform| SceneInstance { mesh, transform }));
        let light = |k| PointLight { position: at(k, LAMP_HEIGHT), range, ..Default::default() };
        plant(&mut scene, (0..lights).map(|k| at(k, 0.0) + Vec3::new(2.2, 0.0, -1.4)));
        let cloth = hang(&mut scene, mesh);
        let lights = (0..lights).map(light).collect();
        let first = scene.instances.len();
        let mut plaza = Self { scene, lights, cloth, walks: Vec::new(), first, half_width };
        plaza.people(figures, walking);
        plaza
    }

    fn people(&mut self, figures: u32, walking: u32) {
        let mut random = Pcg64::seed_from_u64(1);
        let first_mesh = self.scene.meshes.len();
        for (k, color) in CLOTHES.into_iter().enumerate() {
            self.scene.materials.push(material(color));
            let material = self.scene.materials.len() - 1;
            self.scene.meshes.push(SceneMesh { material, ..figure(0.9 + 0.1 * k as f64) });
        }
        let half = self.half_width;
        for k in 0..figures {
            let centre = Vec3::new(random.random_range(-half..half), 0.0, random.random_range(-half..half));
            let radius = random.random_range(0.3..2.0);
            let speed = if k < walking { 1.3 / radius } else { 0.0 };
            self.walks.push(Walk { centre, radius, phase: random.random_range(0.0..TAU), speed });
            let mesh = first_mesh + k as usize % CLOTHES.len();
            self.scene.instances.push(SceneInstance { mesh, transform: Affine3A::IDENTITY });
        }
        self.go(0.0);
    }

    /// Puts the figures and the banner where they are after so many seconds.
    pub fn go(&mut self, seconds: f32) {
        let banner = self.scene.instances[self.cloth].mesh;
        self.scene.meshes[banner].positions = cloth::positions(seconds);
        for (walk, instance) in self.walks.iter().zip(&mut self.scene.instances[self.first..]) {
            let angle = walk.phase + walk.speed * seconds;
            let at = walk.centre + walk.radius * Vec3::new(angle.cos(), 0.0, -angle.sin());
            let bob = 0.03 * (7.0 * walk.speed * seconds).sin().abs();
            instance.transform = Affine3A::from_rotation_translation(Quat::from_rotation_y(angle), at + bob * Vec3::Y);
        }
    }

    /// The figures that move: numbers of the scene's instances.
    pub fn walking(&self) -> impl Iterator<Item = usize> {
        (self.first..).zip(&self.walks).filter(|(_, walk)| walk.speed != 0.0).map(|(instance, _)| instance)
    }

    /// The banner as it is now.
    pub fn cloth_mesh(&self) -> &SceneMesh {
        &self.scene.meshes[self.scene.instances[self.cloth].mesh]
    }

    pub fn camera(&self) -> Camera {
        let eye = self.half_width.min(24.0) * Vec3::new(0.55, 0.4, 0.9);
        Camera { eye, target: Vec3::new(0.0, 0.5, 0.0), fov_y: 0.9 }
    }
}

/// Adds trees, no two of which are turned alike.
fn plant(scene: &mut Scene, places: impl Iterator<Item = Vec3>) {
    scene.images.push(foliage::leaves());
    scene.materials.extend([material(BARK), foliage::material(scene.images.len() - 1)]);
    let (bark, leaves) = (scene.materials.len() - 2, scene.materials.len() - 1);
    let trunk = shapes::cylinder(0.06, foliage::TRUNK_HEIGHT, 12);
    let parts = [SceneMesh { material: bark, ..trunk }, SceneMesh { material: leaves, ..foliage::crown() }];
    scene.meshes.extend(parts);
    let (trunk, crown) = (scene.meshes.len() - 2, scene.meshes.len() - 1);
    for (k, place) in places.enumerate() {
        let transform = Affine3A::from_rotation_translation(Quat::from_rotation_y(k as f32), place);
        scene.instances.extend([trunk, crown].map(|mesh| SceneInstance { mesh, transform }));
    }
}

/// Hangs the banner between two posts, in the middle. Returns its instance's number.
fn hang(scene: &mut Scene, post: usize) -> usize {
    let middle = 0.6 * Vec3::Z;
    for side in [-0.5, 0.5] {
        let transform = Affine3A::from_translation(middle + side * cloth::WIDTH * Vec3::X);
        scene.instances.push(SceneInstance { mesh: post, transform });
    }
    add(scene, cloth::mesh(), CANVAS, Affine3A::from_translation(middle + BANNER_HEIGHT * Vec3::Y));
    if let Some(canvas) = scene.materials.last_mut() {
        canvas.double_sided = true;
    }
    scene.instances.len() - 1
}

/// Adds a mesh with an instance of it.
fn add(scene: &mut Scene, mesh: SceneMesh, color: [f32; 3], transform: Affine3A) {
    scene.materials.push(material(color));
    scene.meshes.push(SceneMesh { material: scene.materials.len() - 1, ..mesh });
    scene.instances.push(SceneInstance { mesh: scene.meshes.len() - 1, transform });
}

fn material([red, green, blue]: [f32; 3]) -> Material {
    Material { base_color: [red, green, blue, 1.0], ..Material::default() }
}

/// Somebody of 990 triangles, as a turner would make them: a body and a head.
fn figure(girth: f64) -> SceneMesh {
    shapes::displaced_sphere(33, 16, |direction| {
        let height = 1.0 - direction.y.clamp(-1.0, 1.0).acos() / PI;
        let body = 0.3 * girth * (height / 0.06).min(1.0) * (1.0 - 0.9 * height);
        let head = 0.14 * (PI * (height - 0.78) / 0.22).sin();
        let radius = if height > 0.8 { head } else { body };
        DVec3::new(direction.x, 0.0, direction.z).normalize_or_zero() * radius + DVec3::Y * (1.75 * height)
    })
}
