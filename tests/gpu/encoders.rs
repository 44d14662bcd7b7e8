//! Encoders that are thrown away, wait, or are submitted in another order than they were recorded to.

use crate::common::{descriptor, gpu};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::{
    CasterMesh, Casters, Indices, InstanceId, LightId, Mask, MeshId, PointLight, PointShadows, RecordOptions, Sides,
};
use glam::{Affine3A, Vec3};

const RESOLUTION: u32 = 64;
const PLATE: [[f32; 3]; 4] = [[-0.4, -0.4, 0.0], [0.4, -0.4, 0.0], [0.4, 0.4, 0.0], [-0.4, 0.4, 0.0]];
const INDICES: [u32; 6] = [0, 1, 2, 0, 2, 3];

/// A light in the middle of plates.
struct World {
    casters: Casters,
    plate: MeshId,
    plates: Vec<InstanceId>,
    shadows: PointShadows,
    light: LightId,
}

/// Where a plate is.
fn place(k: usize) -> Affine3A {
    let (row, column) = (k / 10, k % 10);
    Affine3A::from_translation(Vec3::new(column as f32 - 4.6, row as f32 % 8.0 - 3.3, 3.0 + 0.01 * k as f32))
}

impl World {
    fn new() -> Self {
        let mut casters = Casters::new(&gpu().device).unwrap();
        let plate = CasterMesh { positions: &PLATE, indices: Indices::U32(&INDICES), ..Default::default() };
        let plate = casters.add_mesh(&plate).unwrap();
        let mut shadows = PointShadows::new(&gpu().device, &descriptor(RESOLUTION)).unwrap();
        let light = shadows.add(PointLight::default()).unwrap();
        Self { casters, plate, plates: Vec::new(), shadows, light }
    }

    /// Adds plates, more than the first buffers hold.
    fn fill(&mut self) {
        let first = self.plates.len();
        self.plates.extend((first..first + 100).map(|k| self.casters.add_instance(self.plate, place(k)).unwrap()));
    }

    /// Records to an encoder that isn't submitted yet.
    fn record(&mut self) -> (u32, wgpu::CommandEncoder) {
        let mut encoder = gpu().device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let Self { casters, shadows, .. } = self;
        let made = shadows.record(&gpu().device, &gpu().queue, &mut encoder, casters).unwrap();
        (made, encoder)
    }

    /// Records and submits; returns how many maps were made.
    fn frame(&mut self) -> u32 {
        let (made, encoder) = self.record();
        gpu().queue.submit([encoder.finish()]);
        gpu().wait();
        made
    }

    fn bits(&self) -> Vec<u32> {
        gpu().read_texture(self.shadows.maps(), self.light.index())
    }

    /// Whether a point behind the first plate is lit.
    fn arrives(&self) -> f32 {
        let behind = Vec3::new(-4.6, -3.3, 3.0) * 1.2;
        gpu().shadow_values(&self.shadows, &self.casters, self.light, &[(behind, Vec3::Z)])[0]
    }
}

/// Every state of the world as it is made without any accident.
fn undisturbed(changes: &[fn(&mut World)]) -> Vec<Vec<u32>> {
    let mut world = World::new();
    let state = |change: &fn(&mut World)| {
        change(&mut world);
        world.frame();
        world.bits()
    };
    changes.iter().map(state).collect()
}

fn shift(world: &mut World) {
    for (k, &plate) in world.plates.iter().enumerate().step_by(3) {
        let aside = Affine3A::from_translation(Vec3::new(0.3, 0.2, 0.0));
        world.casters.set_transform(plate, aside * place(k)).unwrap();
    }
}

fn thin_out(world: &mut World) {
    for plate in world.plates.drain(20..) {
        world.casters.remove_instance(plate).unwrap();
    }
}

/// A plate with holes.
fn add_grille(world: &mut World) {
    let texture = gpu().device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 2, height: 1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8), rows_per_image: None };
    gpu().queue.write_texture(texture.as_image_copy(), &[0, 0, 0, 0, 0, 0, 0, 255], layout, texture.size());
    let mask = Mask {
        texture_coordinates: &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        texture: &texture,
        cutoff: 0.5,
        address_modes: [wgpu::AddressMode::ClampToEdge; 2],
    };
    let sides = Sides::Both;
    let mask = Some(mask);
    let mesh = CasterMesh { positions: &PLATE, indices: Indices::U32(&INDICES), sides, mask, ..Default::default() };
    let mesh = world.casters.add_mesh(&mesh).unwrap();
    let transform = Affine3A::from_translation(Vec3::new(0.2, 0.1, -1.0));
    world.plates.push(world.casters.add_instance(mesh, transform).unwrap());
}

fn shrink(world: &mut World) {
    world.shadows.set(world.light, PointLight { position: Vec3::new(0.2, 0.0, 1.0), ..Default::default() }).unwrap();
}

#[test]
fn what_is_thrown_away_is_recorded_again() {
    let changes: [fn(&mut World); 6] = [World::fill, add_grille, World::fill, shift, thin_out, shrink];
    let expected = undisturbed(&changes);
    // Before the first recording, after it, with buffers that grow or shrink, and several times in a row.
    for lost in [&[0][..], &[1], &[2], &[3, 4], &[0, 1, 2, 3, 4], &[5]] {
        let mut world = World::new();
        for (k, (change, expected)) in changes.iter().zip(&expected).enumerate() {
            change(&mut world);
            if lost.contains(&k) {
                assert_eq!(world.record().0, 1);
            } else {
                assert_eq!(world.frame(), 1);
                assert!(world.bits() == *expected, "{lost:?} lost, after {k}");
            }
        }
        // As a finished command buffer, too.
        world.shadows.set(world.light, PointLight { position: Vec3::Z, ..Default::default() }).unwrap();
        drop(world.record().1.finish());
        world
            .shadows
            .set(world.light, PointLight { position: Vec3::new(0.2, 0.0, 1.0), ..Default::default() })
            .unwrap();
        assert_eq!(world.frame(), 1);
        assert!(world.bits() == expected[5], "{lost:?} lost, at the end");
        assert_eq!(world.frame(), 0, "made for ever");
    }
}

#[test]
fn several_wait_and_are_submitted_in_order() {
    let changes: [fn(&mut World); 4] = [World::fill, shift, thin_out, shrink];
    let expected = undisturbed(&changes);
    let mut world = World::new();
    let size = 4 * 2 * u64::from(RESOLUTION * RESOLUTION);
    let mut waiting = Vec::new();
    for change in changes {
        change(&mut world);
        let (made, mut encoder) = world.record();
        assert_eq!(made, 1);
        let copy = gpu().device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * RESOLUTION), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &copy, layout };
        let maps = world.shadows.maps();
        encoder.copy_texture_to_buffer(maps.as_image_copy(), to, maps.size());
        waiting.push((encoder.finish(), copy));
    }
    let (buffers, copies): (Vec<_>, Vec<_>) = waiting.into_iter().unzip();
    gpu().queue.submit(buffers);
    for (k, (copy, expected)) in copies.iter().zip(&expected).enumerate() {
        assert!(gpu().read::<u32>(copy) == *expected, "after {k}");
    }
    assert_eq!(world.frame(), 0);
}

#[test]
fn what_was_built_on_a_lost_one_is_recorded_again() {
    let changes: [fn(&mut World); 3] = [World::fill, shift, thin_out];
    let expected = undisturbed(&changes);
    for in_wrong_order in [false, true] {
        let mut world = World::new();
        World::fill(&mut world);
        let first = world.record().1.finish();
        shift(&mut world);
        assert_eq!(world.frame(), 1);
        if in_wrong_order {
            gpu().queue.submit([first]);
            gpu().wait();
        } else {
            drop(first);
        }
        // Nothing has changed since, but nothing of it can be trusted.
        assert_eq!(world.frame(), 1);
        assert!(world.bits() == expected[1], "in the wrong order: {in_wrong_order}");
        thin_out(&mut world);
        assert_eq!(world.frame(), 1);
        assert!(world.bits() == expected[2], "in the wrong order: {in_wrong_order}, later");
    }
}

#[test]
fn another_ones_lost_casters_are_noticed() {
    let expected = undisturbed(&[World::fill]);
    let (mut world, mut other) = (World::new(), World::new());
    World::fill(&mut world);
    let lost = world.record().1;
    // Casters that were to be brought up to date by the first.
    let made = |world: &mut World, other: &mut World| {
        let Gpu { device, queue, .. } = gpu();
        let made = gpu().submit(|encoder| other.shadows.record(device, queue, encoder, &mut world.casters)).unwrap();
        gpu().wait();
        made
    };
    assert_eq!(made(&mut world, &mut other), 1);
    drop(lost);
    assert_eq!(world.frame(), 1);
    assert!(world.bits() == expected[0]);
    assert_eq!(made(&mut world, &mut other), 1);
    assert!(other.bits() == expected[0]);
    assert_eq!((made(&mut world, &mut other), world.frame()), (0, 0));
}

#[test]
fn a_light_whose_map_was_lost_is_dark_until_it_is_made() {
    let mut world = World::new();
    World::fill(&mut world);
    assert_eq!(world.arrives(), 0.0);
    drop(world.record().1);
    assert_eq!(world.arrives(), 0.0, "the lost recording has told the lookup of a light");
    assert_eq!(world.frame(), 1);
    world.casters.remove_instance(world.plates[0]).unwrap();
    drop(world.record().1);
    assert_eq!(world.arrives(), 0.0, "no map yet without the plate");
    let most = RecordOptions { most: Some(0), draw: None };
    let World { casters, shadows, .. } = &mut world;
    let made =
        gpu().submit(|encoder| shadows.record_with(&gpu().device, &gpu().queue, encoder, casters, most)).unwrap();
    gpu().wait();
    assert_eq!((made, world.arrives()), (0, 0.0));
    assert_eq!((world.frame(), world.arrives()), (1, 1.0));
}
