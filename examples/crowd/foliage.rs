//! Trees with masked leaves: quads that cross each other, under an image of leaves that is drawn here.

use dual_paraboloid::compare::procedural::shapes;
use dual_paraboloid::compare::scene::{Alpha, Material, SceneMesh};
use glam::{Affine3A, Quat, Vec2, Vec3};
use image::{Rgba, RgbaImage};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::f32::consts::TAU;

const CARDS: usize = 7;
/// Metres along a card's edges.
const CARD: f32 = 1.7;
pub const TRUNK_HEIGHT: f32 = 1.6;
/// Texels along the image's edges.
const SIZE: u32 = 128;
const LEAVES: u32 = 32;
/// Half of a leaf's length and width, in shares of the image's.
const LEAF: Vec2 = Vec2::new(0.09, 0.04);

pub fn material(image: usize) -> Material {
    Material {
        base_color_image: Some(image),
        address_modes: [wgpu::AddressMode::ClampToEdge; 2],
        alpha: Alpha::Mask { cutoff: 0.5 },
        double_sided: true,
        ..Material::default()
    }
}

/// Cards around the upper end of a trunk that stands in the origin.
pub fn crown() -> SceneMesh {
    let mut random = Pcg64::seed_from_u64(2);
    let card = shapes::quad(Vec3::new(-0.5 * CARD, -0.5 * CARD, 0.0), CARD * Vec3::X, CARD * Vec3::Y);
    let mut mesh = SceneMesh::default();
    for _ in 0..CARDS {
        let turn = Quat::from_rotation_y(random.random_range(0.0..TAU))
            * Quat::from_rotation_x(random.random_range(-0.9..0.9))
            * Quat::from_rotation_z(random.random_range(0.0..TAU));
        let middle = TRUNK_HEIGHT * Vec3::Y + turn * Vec3::Z * random.random_range(-0.3..0.3);
        shapes::append(&mut mesh, &card, Affine3A::from_rotation_translation(turn, middle));
    }
    mesh.tex_coords = Some([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].repeat(CARDS));
    mesh
}

/// Leaves within a disc, lighter and darker ones.
pub fn leaves() -> RgbaImage {
    let mut random = Pcg64::seed_from_u64(3);
    // Holes are green too, so that filtering brings no other colour in.
    let mut image = RgbaImage::from_pixel(SIZE, SIZE, Rgba([70, 98, 40, 0]));
    for _ in 0..LEAVES {
        let radius = 0.4 * random.random_range(0.0..1.0_f32).sqrt();
        let middle = 0.5 + radius * Vec2::from_angle(random.random_range(0.0..TAU));
        let along = Vec2::from_angle(random.random_range(0.0..TAU));
        let shade: f32 = random.random_range(0.6..1.0);
        let [red, green, blue] = [112.0, 150.0, 62.0].map(|channel: f32| (channel * shade) as u8);
        for (x, y, texel) in image.enumerate_pixels_mut() {
            let from_middle = (Vec2::new(x as f32, y as f32) + 0.5) / SIZE as f32 - middle;
            let at = Vec2::new(from_middle.dot(along), from_middle.perp_dot(along)) / LEAF;
            if at.y.abs() < 1.0 - at.x * at.x {
                *texel = Rgba([red, green, blue, 255]);
            }
        }
    }
    image
}
