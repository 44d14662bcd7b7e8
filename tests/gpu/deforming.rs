//! Casters whose positions the caller writes on the GPU.

use crate::common::{Map, descriptor, gpu, map};
use crate::masked::{Sheet, checkerboard, mask};
use dual_paraboloid::compare::procedural::shapes::cuboid;
use dual_paraboloid::{
    CasterMesh, Casters, Deformed, Error, Indices, InstanceId, LightId, PointLight, PointShadows,
    PointShadowsDescriptor, Sides,
};
use glam::{Affine3A, Quat, Vec3};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

pub fn light() -> PointLight {
    PointLight { position: Vec3::new(0.2, 2.5, -0.1), range: 50.0, ..Default::default() }
}

/// A buffer of positions with something else before and between them.
fn positions_buffer(positions: &[[f32; 3]], offset: u64, stride: u64) -> wgpu::Buffer {
    let mut words = vec![f32::NAN; (offset / 4) as usize];
    for position in positions {
        let next = words.len() + (stride / 4) as usize;
        words.extend(position);
        words.resize(next, f32::NAN);
    }
    gpu().device.create_buffer_init(&BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(&words),
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
    })
}

fn deformed(positions: &wgpu::Buffer) -> Deformed<'_> {
    Deformed { positions, offset: 0, stride: 12, min: Vec3::splat(-3.0), max: Vec3::splat(3.0) }
}

/// A cloth in a wind that blows in gusts.
fn cloth(sheet: &Sheet, gust: f32) -> Vec<[f32; 3]> {
    let wave = |&[x, y, z]: &[f32; 3]| [x, y + 0.3 * (2.0 * x + gust).sin() * (1.5 * z).cos(), z + 0.1 * gust];
    sheet.positions.iter().map(wave).collect()
}

struct Cloth {
    rest: Sheet,
    texture: Option<wgpu::Texture>,
    transform: Affine3A,
    sides: Sides,
}

impl Cloth {
    fn add(&self, casters: &mut Casters, positions: &[[f32; 3]], deforms: bool) -> InstanceId {
        let mask = self.texture.as_ref().map(|texture| mask(texture, &self.rest.coordinates));
        let indices = Indices::U32(&self.rest.indices);
        let mesh = CasterMesh { positions, indices, sides: self.sides, mask, deforms };
        let mesh = casters.add_mesh(&mesh).unwrap();
        casters.add_instance(mesh, self.transform).unwrap()
    }

    /// The map of a mesh that has these positions for good.
    fn map_of(&self, positions: &[[f32; 3]]) -> Map {
        let mut casters = Casters::new(&gpu().device).unwrap();
        self.add(&mut casters, positions, false);
        map(&mut casters, light(), 128)
    }
}

fn cloths() -> [Cloth; 3] {
    let rest = || Sheet::new(Vec3::new(-2.0, 0.0, -2.0), 4.0 * Vec3::Z, 4.0 * Vec3::X, 23);
    let turn = Affine3A::from_scale_rotation_translation(
        Vec3::new(-1.0, 1.2, 0.8),
        Quat::from_rotation_x(0.3),
        Vec3::new(0.1, 0.2, 0.3),
    );
    [
        Cloth { rest: rest(), texture: None, transform: Affine3A::IDENTITY, sides: Sides::Both },
        Cloth { rest: rest(), texture: Some(checkerboard(2)), transform: turn, sides: Sides::Both },
        // Beside the one with holes and not in its place: that one is drawn by another shader, which may round otherwise, so of
        // two such twins either may be the nearer one.
        Cloth {
            rest: rest(),
            texture: None,
            transform: Affine3A::from_translation(0.1 * Vec3::Y) * turn,
            sides: Sides::Front,
        },
    ]
}

/// All cloths in one gust, whole, with holes and one-sided.
pub fn deformed_cloths() -> Casters {
    let mut casters = Casters::new(&gpu().device).unwrap();
    for subject in cloths() {
        let instance = subject.add(&mut casters, &subject.rest.positions, true);
        let buffer = positions_buffer(&cloth(&subject.rest, 1.0), 0, 12);
        casters.deform(instance, &deformed(&buffer)).unwrap();
    }
    casters
}

#[test]
fn a_deformed_mesh_is_the_mesh_of_its_positions() {
    for (cloth_number, subject) in cloths().iter().enumerate() {
        // Folded up, nothing of it is there.
        let folded = vec![[0.0; 3]; subject.rest.positions.len()];
        for (offset, stride, at_rest) in
            [(0, 12, &subject.rest.positions), (260, 16, &folded), (1024, 32, &subject.rest.positions)]
        {
            let mut casters = Casters::new(&gpu().device).unwrap();
            let instance = subject.add(&mut casters, at_rest, true);
            let rest = map(&mut casters, light(), 128);
            let expected = subject.map_of(at_rest);
            assert!(rest.differences(&expected).is_empty(), "cloth {cloth_number} at rest");
            for gust in [0.0, 1.0] {
                let positions = cloth(&subject.rest, gust);
                let buffer = positions_buffer(&positions, offset, stride);
                casters.deform(instance, &Deformed { offset, stride, ..deformed(&buffer) }).unwrap();
                let expected = subject.map_of(&positions);
                let differences = map(&mut casters, light(), 128).differences(&expected);
                assert!(differences.is_empty(), "cloth {cloth_number} in {gust}: {} texels", differences.len());
                assert!(expected.differences(&rest).len() > 1000, "cloth {cloth_number} didn't deform");
            }
        }
    }
}

fn record(shadows: &mut PointShadows, casters: &mut Casters, before: impl FnOnce(&mut wgpu::CommandEncoder)) -> u32 {
    let mut count = 0;
    gpu().submit(|encoder| {
        before(encoder);
        count = shadows.record(&gpu().device, &gpu().queue, encoder, casters).unwrap();
    });
    gpu().wait();
    count
}

/// The pass that writes the positions may be in the same encoder; a move reads them again.
#[test]
fn positions_are_read_in_the_callers_encoder() {
    let [subject, ..] = cloths();
    let mut casters = Casters::new(&gpu().device).unwrap();
    let instance = subject.add(&mut casters, &subject.rest.positions, true);
    let buffer = positions_buffer(&cloth(&subject.rest, 0.5), 0, 12);
    let mut shadows = PointShadows::new(&gpu().device, &descriptor(128)).unwrap();
    let id = shadows.add(light()).unwrap();
    record(&mut shadows, &mut casters, |_| ());
    casters.deform(instance, &deformed(&buffer)).unwrap();
    let written = cloth(&subject.rest, 1.5);
    let newer = positions_buffer(&written, 0, 12);
    let write = |encoder: &mut wgpu::CommandEncoder| {
        encoder.copy_buffer_to_buffer(&newer, 0, &buffer, 0, newer.size());
    };
    assert_eq!(record(&mut shadows, &mut casters, write), 1);
    assert!(Map::read(&shadows, id).differences(&subject.map_of(&written)).is_empty());
    let moved = Cloth { transform: Affine3A::from_translation(Vec3::new(0.0, 0.5, 0.0)), ..subject };
    casters.set_transform(instance, moved.transform).unwrap();
    assert_eq!(record(&mut shadows, &mut casters, |_| ()), 1);
    assert!(Map::read(&shadows, id).differences(&moved.map_of(&written)).is_empty());
}

/// Lights that the bounds don't reach, before or after, keep their maps.
#[test]
fn bounds_say_which_lights_see_it() {
    let [subject, ..] = cloths();
    let mut casters = Casters::new(&gpu().device).unwrap();
    let instance = subject.add(&mut casters, &subject.rest.positions, true);
    let far = PointLight { position: Vec3::new(100.0, 0.0, 0.0), range: 50.0, ..light() };
    let descriptor = PointShadowsDescriptor { capacity: 2, ..descriptor(32) };
    let mut shadows = PointShadows::new(&gpu().device, &descriptor).unwrap();
    let ids: Vec<LightId> = [light(), far].map(|light| shadows.add(light).unwrap()).into();
    assert_eq!(ids.len() as u32, record(&mut shadows, &mut casters, |_| ()));
    let buffer = positions_buffer(&cloth(&subject.rest, 1.0), 0, 12);
    let near = deformed(&buffer);
    let away = Deformed { min: Vec3::new(90.0, 0.0, 0.0), max: Vec3::new(91.0, 1.0, 1.0), ..near };
    for (bounds, lights) in [(near, 1), (away, 2), (near, 2), (away, 2), (away, 1)] {
        casters.deform(instance, &bounds).unwrap();
        assert_eq!(record(&mut shadows, &mut casters, |_| ()), lights, "{bounds:?}");
    }
    casters.set_transform(instance, Affine3A::from_translation(Vec3::new(0.0, 0.1, 0.0))).unwrap();
    assert_eq!(record(&mut shadows, &mut casters, |_| ()), 1);
    assert_eq!(record(&mut shadows, &mut casters, |_| ()), 0, "nothing has changed");
}

#[test]
fn wrong_positions_are_refused() {
    let [subject, ..] = cloths();
    let mut casters = Casters::new(&gpu().device).unwrap();
    let instance = subject.add(&mut casters, &subject.rest.positions, true);
    let stiff = subject.add(&mut casters, &subject.rest.positions, false);
    let mut shadows = PointShadows::new(&gpu().device, &descriptor(32)).unwrap();
    shadows.add(light()).unwrap();
    record(&mut shadows, &mut casters, |_| ());
    let buffer = positions_buffer(&subject.rest.positions, 0, 12);
    let usage = wgpu::BufferUsages::VERTEX;
    let unbindable = wgpu::BufferDescriptor { label: None, size: buffer.size(), usage, mapped_at_creation: false };
    let unbindable = gpu().device.create_buffer(&unbindable);
    let good = deformed(&buffer);
    let wrong = [
        ("stride", Deformed { stride: 8, ..good }),
        ("stride", Deformed { stride: 14, ..good }),
        ("offset", Deformed { offset: 2, ..good }),
        ("buffer", Deformed { offset: 4, ..good }),
        ("buffer", Deformed { stride: 16, ..good }),
        ("buffer", Deformed { offset: u64::MAX - 3, ..good }),
        ("usage", Deformed { positions: &unbindable, ..good }),
        ("bounds", Deformed { min: Vec3::splat(f32::NAN), ..good }),
        ("bounds", Deformed { min: Vec3::splat(4.0), ..good }),
        ("bounds", Deformed { max: Vec3::splat(f32::INFINITY), ..good }),
    ];
    for (name, deformed) in wrong {
        match casters.deform(instance, &deformed) {
            Err(Error::InvalidDeformed { what, .. }) => assert_eq!(what, name, "{deformed:?}"),
            other => panic!("{deformed:?}: {other:?}"),
        }
    }
    assert!(matches!(casters.deform(stiff, &good), Err(Error::InvalidDeformed { what: "mesh", .. })));
    assert_eq!(record(&mut shadows, &mut casters, |_| ()), 0, "what was refused changed something");
    casters.remove_instance(instance).unwrap();
    assert!(matches!(casters.deform(instance, &good), Err(Error::StaleHandle { .. })));
}

#[test]
fn closed_bodies_may_be_turned_inside_out() {
    let body = cuboid(Vec3::splat(-0.5), Vec3::splat(0.5));
    let add = |casters: &mut Casters, positions: &[[f32; 3]], sides, deforms| {
        let mesh = CasterMesh { positions, indices: Indices::U32(&body.indices), sides, deforms, ..Default::default() };
        let mesh = casters.add_mesh(&mesh).unwrap();
        casters.add_instance(mesh, Affine3A::IDENTITY).unwrap()
    };
    // The same box, of which the backs are outside now.
    let mirrored: Vec<[f32; 3]> = body.positions.iter().map(|&[x, y, z]| [-x, y, z]).collect();
    let mut casters = Casters::new(&gpu().device).unwrap();
    let instance = add(&mut casters, &body.positions, Sides::Auto, true);
    casters.deform(instance, &deformed(&positions_buffer(&mirrored, 0, 12))).unwrap();
    let mut expected = Casters::new(&gpu().device).unwrap();
    add(&mut expected, &mirrored, Sides::Both, false);
    let expected = map(&mut expected, light(), 128);
    assert!(expected.depth.iter().filter(|depth| **depth > 0.0).count() > 100);
    assert!(map(&mut casters, light(), 128).differences(&expected).is_empty());
}
