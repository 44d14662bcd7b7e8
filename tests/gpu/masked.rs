//! Casters with holes.

use crate::claims::{assert_culling_changes_nothing, assert_holes_are_true};
use crate::common::{Map, box_inside, descriptor, gpu, map, mesh_of};
use dual_paraboloid::compare::scene::{Alpha, Material, Scene, SceneInstance, SceneMesh};
use dual_paraboloid::{
    CasterMesh, Casters, Coverage, Indices, Mask, MeshId, PointLight, PointShadows, PointShadowsDescriptor, Sides,
    paraboloid,
};
use glam::{Affine3A, Quat, Vec2, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use wgpu::util::{DeviceExt, TextureDataOrder};

/// Cells across the checkerboard.
pub const CELLS: u32 = 8;

/// A texture of these alphas.
fn alpha_texture(width: u32, alphas: &[u8]) -> wgpu::Texture {
    let texels: Vec<u8> = alphas.iter().flat_map(|&alpha| [0, 0, 0, alpha]).collect();
    let descriptor = wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height: alphas.len() as u32 / width, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    gpu().device.create_texture_with_data(&gpu().queue, &descriptor, TextureDataOrder::LayerMajor, &texels)
}

/// Every other cell is a hole; the first isn't. A cell is so many texels across.
pub fn checkerboard(texels: u32) -> wgpu::Texture {
    let size = CELLS * texels;
    let solid = |place: u32| (place % size / texels + place / size / texels).is_multiple_of(2);
    alpha_texture(size, &(0..size * size).map(|place| if solid(place) { 255 } else { 0 }).collect::<Vec<u8>>())
}

pub fn mask<'a>(texture: &'a wgpu::Texture, texture_coordinates: &'a [[f32; 2]]) -> Mask<'a> {
    Mask { texture_coordinates, texture, cutoff: 0.5, address_modes: [wgpu::AddressMode::Repeat; 2] }
}

/// A parallelogram of so many quads across, with its texture coordinates.
pub struct Sheet {
    pub positions: Vec<[f32; 3]>,
    pub coordinates: Vec<[f32; 2]>,
    pub indices: Vec<u32>,
}

impl Sheet {
    pub fn new(corner: Vec3, u: Vec3, v: Vec3, quads: u32) -> Self {
        let row = quads + 1;
        let share = |i: u32| Vec2::new((i % row) as f32, (i / row) as f32) / quads as f32;
        let (mut positions, mut coordinates, mut indices) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..row * row {
            positions.push((corner + u * share(i).x + v * share(i).y).to_array());
            coordinates.push(share(i).to_array());
            if i % row < quads && i / row < quads {
                indices.extend([i, i + 1, i + row + 1, i, i + row + 1, i + row]);
            }
        }
        Self { positions, coordinates, indices }
    }

    fn add(&self, casters: &mut Casters, texture: Option<&wgpu::Texture>, sides: Sides) -> MeshId {
        let mask = texture.map(|texture| mask(texture, &self.coordinates));
        let indices = Indices::U32(&self.indices);
        casters.add_mesh(&CasterMesh { positions: &self.positions, indices, sides, mask, deforms: false }).unwrap()
    }
}

/// A checkerboard of holes, 4 across, 1 above a floor.
pub fn board_above_floor(quads: u32, texels: u32) -> Casters {
    let mut casters = Casters::new(&gpu().device).unwrap();
    let board = Sheet::new(Vec3::new(-2.0, 1.0, -2.0), 4.0 * Vec3::X, 4.0 * Vec3::Z, quads);
    let floor = Sheet::new(Vec3::new(-20.0, 0.0, -20.0), 40.0 * Vec3::X, 40.0 * Vec3::Z, 1);
    for mesh in
        [board.add(&mut casters, Some(&checkerboard(texels)), Sides::Auto), floor.add(&mut casters, None, Sides::Auto)]
    {
        casters.add_instance(mesh, Affine3A::IDENTITY).unwrap();
    }
    casters
}

/// Direction from the light of a texel's centre, in the world.
fn direction(p: Vec2, back: bool, orientation: Quat) -> Vec3 {
    orientation * paraboloid::to_hemisphere(paraboloid::unproject(p), back)
}

#[test]
fn a_board_above_a_floor() {
    let light = PointLight {
        position: Vec3::new(0.3, 2.5, -0.2),
        orientation: Quat::from_rotation_x(0.4),
        range: 100.0,
        ..Default::default()
    };
    // Small triangles, and large ones.
    for (quads, texels) in [(64, 1), (64, 4), (1, 1), (1, 4)] {
        let map = map(&mut board_above_floor(quads, texels), light, 256);
        let mut seen = [0, 0];
        for texel in map.discs() {
            let d = direction(texel.p, texel.back, light.orientation);
            let at = light.position + d * ((light.position.y - 1.0) / -d.y);
            let cell = (Vec2::new(at.x, at.z) + 2.0) * (CELLS as f32 / 4.0);
            // On the boundary between cells, and where grazing texels are as large as they, anything goes.
            let margin = (cell - cell.round()).abs().min_element();
            let inside = cell.cmpgt(Vec2::ZERO).all() && cell.cmplt(Vec2::splat(CELLS as f32)).all();
            if d.y > -0.3 || !inside || margin < 0.1 {
                continue;
            }
            let solid = (cell.x as u32 + cell.y as u32).is_multiple_of(2);
            let height = light.position.y - if solid { 1.0 } else { 0.0 };
            let x = paraboloid::unproject(texel.p) * (height / -d.y);
            let expected = paraboloid::depth(x, light.near);
            let error = (texel.depth / expected - 1.0).abs();
            assert!(error < 0.02, "{quads} quads, {texels} texels a cell: {texel:?} is not {expected}");
            seen[usize::from(solid)] += 1;
        }
        assert!(seen[0] > 1000 && seen[1] > 1000, "{seen:?}");
    }
}

fn random_point(rng: &mut Pcg64, size: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)))
}

/// Sheets at random places, every third whole, some of them mirrored and sheared.
pub fn random_sheets(rng: &mut Pcg64, sides: Sides) -> Casters {
    let mut casters = Casters::new(&gpu().device).unwrap();
    let textures = [checkerboard(3), checkerboard(1)];
    for number in 0..12 {
        let [corner, u, v] = [4.0, 3.0, 3.0].map(|size| random_point(rng, size));
        let sheet = Sheet::new(corner, u, v, [1, 4, 40][number % 3]);
        let mesh = sheet.add(&mut casters, textures.get(number % 3), sides);
        for _ in 0..2 {
            let mirror = Vec3::new(if rng.random() { -1.0 } else { 1.0 }, rng.random_range(0.5..2.0), 1.0);
            let turn = Quat::from_scaled_axis(random_point(rng, 3.0));
            let transform = Affine3A::from_scale_rotation_translation(mirror, turn, random_point(rng, 2.0));
            casters.add_instance(mesh, transform).unwrap();
        }
    }
    casters
}

#[test]
fn leaving_triangles_out_changes_nothing() {
    let mut rng = Pcg64::seed_from_u64(1);
    for (sides, resolution) in [(Sides::Auto, 64), (Sides::Front, 128), (Sides::Auto, 300)] {
        let mut casters = random_sheets(&mut rng, sides);
        let orientation = Quat::from_rotation_x(rng.random_range(0.0..3.0));
        assert_culling_changes_nothing(
            &mut casters,
            PointLight { orientation, range: 100.0, ..Default::default() },
            resolution,
            "sheets",
        );
    }
}

/// Eleven lights with two jobs each, which takes several batches.
#[test]
fn each_light_has_its_own_map() {
    let mut casters = random_sheets(&mut Pcg64::seed_from_u64(2), Sides::Auto);
    let light = |k: u32| PointLight {
        position: Vec3::new(0.3 * k as f32 - 1.5, 0.1 * k as f32, 0.7 * (k % 3) as f32 - 0.6),
        range: [100.0, 3.0, 1.5][k as usize % 3],
        coverage: if k % 4 == 1 { Coverage::Hemisphere } else { Coverage::Full },
        ..Default::default()
    };
    let lights: [_; 11] = std::array::from_fn(|k| light(k as u32));
    let descriptor = PointShadowsDescriptor { capacity: 11, ..descriptor(128) };
    let mut shadows = PointShadows::new(&gpu().device, &descriptor).unwrap();
    let ids = lights.map(|light| shadows.add(light).unwrap());
    for _ in 0..2 {
        gpu().submit(|encoder| {
            shadows.record(&gpu().device, &gpu().queue, encoder, &mut casters).unwrap();
        });
        gpu().wait();
    }
    for (light, id) in lights.into_iter().zip(ids) {
        let alone = map(&mut casters, light, 128);
        assert!(alone.depth.iter().any(|depth| *depth > 0.0));
        assert!(alone.differences(&Map::read(&shadows, id)).is_empty());
    }
}

/// What was there goes, and its places in the buffers are taken by others.
#[test]
fn meshes_come_and_go() {
    let light = PointLight { position: Vec3::new(0.1, 2.0, 0.3), range: 100.0, ..Default::default() };
    let sheet = Sheet::new(Vec3::new(-2.0, 1.0, -2.0), 4.0 * Vec3::X, 4.0 * Vec3::Z, 5);
    let textures = [checkerboard(1), checkerboard(40), alpha_texture(1, &[0])];
    let maps = [0, 1].map(|number| {
        let mut casters = Casters::new(&gpu().device).unwrap();
        let mesh = sheet.add(&mut casters, Some(&textures[number]), Sides::Auto);
        casters.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        map(&mut casters, light, 64)
    });
    let mut casters = Casters::new(&gpu().device).unwrap();
    let [first, second, empty] = [0, 1, 2].map(|number| sheet.add(&mut casters, Some(&textures[number]), Sides::Auto));
    let shared = sheet.add(&mut casters, Some(&textures[0]), Sides::Auto);
    casters.remove_mesh(first).unwrap();
    let show = |casters: &mut Casters, mesh| {
        let instance = casters.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        let map = map(casters, light, 64);
        casters.remove_instance(instance).unwrap();
        map
    };
    assert!(show(&mut casters, empty).depth.iter().all(|depth| *depth == 0.0), "nothing but a hole");
    assert!(show(&mut casters, shared).differences(&maps[0]).is_empty());
    assert!(show(&mut casters, second).differences(&maps[1]).is_empty());
    let memory = casters.memory();
    for mesh in [empty, second, shared] {
        casters.remove_mesh(mesh).unwrap();
    }
    // The second finds out that the first is done, and lets the old buffers go.
    for _ in 0..2 {
        assert!(map(&mut casters, light, 64).depth.iter().all(|depth| *depth == 0.0));
    }
    assert!(casters.memory() < memory, "room of a large mask isn't given back");
    let again = sheet.add(&mut casters, Some(&textures[1]), Sides::Auto);
    assert!(show(&mut casters, again).differences(&maps[1]).is_empty());
    // One copy takes a hundred thousand bytes.
    for _ in 0..20 {
        let more = sheet.add(&mut casters, Some(&textures[1]), Sides::Auto);
        assert!(show(&mut casters, more).differences(&maps[1]).is_empty());
    }
    assert!(casters.memory() < 1_000_000, "{} bytes for one texture", casters.memory());
}

/// An instance that mirrors its mesh shows what a mesh of the mirrored positions does.
#[test]
fn mirrored_instances() {
    let texture = checkerboard(2);
    let sheet = Sheet::new(Vec3::new(-0.5, 1.0, -1.0), 2.0 * Vec3::X, Vec3::new(0.0, 0.7, 3.0), 6);
    let mut mirrored = Sheet::new(Vec3::ZERO, Vec3::X, Vec3::Z, 6);
    mirrored.positions = sheet.positions.iter().map(|&[x, y, z]| [-x, y, z]).collect();
    let light = PointLight { position: Vec3::new(0.2, 0.1, 0.3), range: 100.0, ..Default::default() };
    for sides in [Sides::Auto, Sides::Front] {
        let maps = [(&sheet, -1.0), (&mirrored, 1.0)].map(|(sheet, scale)| {
            let mut casters = Casters::new(&gpu().device).unwrap();
            let mesh = sheet.add(&mut casters, Some(&texture), sides);
            casters.add_instance(mesh, Affine3A::from_scale(Vec3::new(scale, 1.0, 1.0))).unwrap();
            map(&mut casters, light, 128)
        });
        let shown = maps[0].discs().filter(|texel| texel.depth > 0.0).count();
        assert!(shown > 1000, "{sides:?}: {shown} texels");
        // The alpha of a texel's centre may round to either side of the cutoff.
        let differ = maps[0].depth.iter().zip(&maps[1].depth).filter(|(a, b)| (*a - *b).abs() > 1e-6 * a.max(**b));
        let differ = differ.count();
        assert!(differ <= shown / 1000, "{sides:?}: {differ} of {shown} texels");
        mirrored.indices.as_chunks_mut::<3>().0.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
}

/// A room with sheets of all sizes and address modes, with textures of odd sizes and soft alphas.
pub fn masked_room() -> Scene {
    let mut rng = Pcg64::seed_from_u64(4);
    let mut scene = Scene { name: "masked room".to_owned(), materials: vec![Material::default()], ..Scene::default() };
    let walls = box_inside(Vec3::splat(-4.0), Vec3::splat(4.0));
    scene.meshes.push(mesh_of(&walls));
    let modes = [wgpu::AddressMode::Repeat, wgpu::AddressMode::MirrorRepeat, wgpu::AddressMode::ClampToEdge];
    for number in 0..9 {
        let (width, height) = (rng.random_range(1..9), rng.random_range(1..9));
        scene.images.push(image::RgbaImage::from_fn(width, height, |_, _| image::Rgba([0, 0, 0, rng.random()])));
        scene.materials.push(Material {
            base_color: [1.0, 1.0, 1.0, 0.9],
            base_color_image: Some(number),
            address_modes: [modes[number % 3], modes[number / 3]],
            alpha: Alpha::Mask { cutoff: rng.random_range(0.2..0.7) },
            ..Material::default()
        });
        let centre = random_point(&mut rng, 1.0).normalize() * 2.5;
        let [u, v] = [0, 1].map(|_| random_point(&mut rng, 2.0));
        let sheet = Sheet::new(centre - 0.5 * (u + v), u, v, [1, 3, 20][number % 3]);
        // Each triangle has a part of the texture of its own, so that no two share texture coordinates at a vertex.
        let parts: Vec<Vec3> = sheet.indices.iter().step_by(3).map(|_| random_point(&mut rng, 1.0)).collect();
        let corners = || sheet.indices.iter().enumerate().map(|(at, &vertex)| (parts[at / 3], vertex as usize));
        let coordinates = |(part, vertex): (Vec3, usize)| {
            let [x, y] = sheet.coordinates[vertex];
            [4.0 * x - 2.0 + part.x, 3.0 * y - 1.0 + part.y]
        };
        scene.meshes.push(SceneMesh {
            positions: corners().map(|(_, vertex)| sheet.positions[vertex]).collect(),
            tex_coords: Some(corners().map(coordinates).collect()),
            indices: (0..sheet.indices.len() as u32).collect(),
            material: number + 1,
            ..SceneMesh::default()
        });
    }
    let place = |mesh| SceneInstance { mesh, transform: Affine3A::IDENTITY };
    scene.instances = (0..scene.meshes.len()).map(place).collect();
    scene
}

#[test]
fn a_room_is_as_true_as_resolution_allows() {
    for resolution in [128, 256] {
        assert_holes_are_true(&masked_room(), Vec3::new(0.1, 0.2, -0.1), resolution, 50_000);
    }
}
