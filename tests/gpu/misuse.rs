//! Wrong input is refused by name, and what was there stays.

use crate::common::{box_inside, descriptor, gpu, record, soup};
use dual_paraboloid::{
    CasterMesh, Casters, Error, Indices, Mask, PointLight, PointShadows, PointShadowsDescriptor, Sides,
};
use glam::{Affine3A, Quat, Vec3};

const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];

fn mesh<'a>(positions: &'a [[f32; 3]], indices: &'a [u32]) -> CasterMesh<'a> {
    CasterMesh { positions, indices: Indices::U32(indices), ..Default::default() }
}

#[test]
fn meshes() {
    let mut casters = Casters::new(&gpu().device).unwrap();
    let mut add = |positions: &[[f32; 3]], indices: &[u32]| casters.add_mesh(&mesh(positions, indices));
    assert_eq!(add(&[], &[]), Err(Error::EmptyMesh { positions: 0, indices: 0 }));
    assert_eq!(add(&TRIANGLE, &[]), Err(Error::EmptyMesh { positions: 3, indices: 0 }));
    assert_eq!(add(&TRIANGLE, &[0, 1, 2, 0]), Err(Error::IndexCount { count: 4 }));
    assert_eq!(add(&TRIANGLE, &[0, 1, 3]), Err(Error::IndexOutOfRange { index: 3, place: 2, positions: 3 }));
    let broken = [[0.0, f32::NAN, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    assert!(matches!(add(&broken, &[0, 1, 2]), Err(Error::PositionNotFinite { vertex: 0, .. })));
    let broken = [[0.0, 0.0, 1.0], [1.0, f32::INFINITY, 1.0], [0.0, 1.0, 1.0]];
    assert!(matches!(add(&broken, &[0, 1, 2]), Err(Error::PositionNotFinite { vertex: 1, .. })));
    assert_eq!(casters.triangle_count(), 0);
    let short: [u16; 3] = [0, 1, 2];
    let sixteen = CasterMesh { positions: &TRIANGLE, indices: Indices::U16(&short), ..Default::default() };
    assert!(casters.add_mesh(&sixteen).is_ok());
}

#[test]
fn handles_and_transforms() {
    let mut casters = Casters::new(&gpu().device).unwrap();
    let id = casters.add_mesh(&mesh(&TRIANGLE, &[0, 1, 2])).unwrap();
    let instance = casters.add_instance(id, Affine3A::IDENTITY).unwrap();
    assert_eq!(casters.triangle_count(), 1);
    let broken = Affine3A::from_scale(Vec3::splat(f32::NAN));
    assert!(matches!(casters.set_transform(instance, broken), Err(Error::TransformNotFinite { .. })));
    let huge = Affine3A::from_scale(Vec3::splat(3e38)) * Affine3A::from_translation(Vec3::splat(3.0));
    assert!(matches!(casters.set_transform(instance, huge), Err(Error::TransformNotFinite { .. })));
    assert_eq!(casters.remove_mesh(id), Err(Error::MeshInUse { instances: 1 }));
    let mut other = Casters::new(&gpu().device).unwrap();
    assert!(matches!(other.add_instance(id, Affine3A::IDENTITY), Err(Error::StaleHandle { what: "mesh", .. })));
    casters.remove_instance(instance).unwrap();
    let stale = casters.remove_instance(instance).unwrap_err();
    assert!(matches!(stale, Error::StaleHandle { what: "instance", .. }), "{stale}");
    assert_eq!(casters.set_moving(instance, true), Err(stale));
    let again = casters.add_instance(id, Affine3A::IDENTITY).unwrap();
    assert!(casters.set_transform(instance, Affine3A::IDENTITY).is_err(), "an old handle came alive again");
    casters.remove_instance(again).unwrap();
    casters.remove_mesh(id).unwrap();
    assert!(casters.add_instance(id, Affine3A::IDENTITY).is_err());
    assert_eq!(casters.triangle_count(), 0);
}

#[test]
fn lights() {
    let walls = box_inside(Vec3::splat(-2.0), Vec3::splat(2.0));
    let mut casters = soup(&walls, Sides::Auto);
    let shadows = PointShadows::new(&gpu().device, &descriptor(32)).unwrap();
    let good = PointLight::default();
    let (mut shadows, id) = record(shadows, &mut casters, good);
    let wrong = [
        ("position", PointLight { position: Vec3::new(0.0, f32::NAN, 0.0), ..good }),
        ("orientation", PointLight { orientation: Quat::from_xyzw(1.0, 1.0, 0.0, 0.0), ..good }),
        ("range", PointLight { range: 0.0, ..good }),
        ("range", PointLight { range: -1.0, ..good }),
        ("range", PointLight { range: f32::INFINITY, ..good }),
        ("near distance", PointLight { near: 0.0, ..good }),
        ("near distance", PointLight { near: f32::NAN, ..good }),
        ("near distance", PointLight { near: 20.0, ..good }),
    ];
    for (name, light) in wrong {
        match shadows.set(id, light) {
            Err(Error::InvalidLight { what, .. }) => assert_eq!(what, name),
            other => panic!("{name}: {other:?}"),
        }
    }
    assert_eq!(shadows.add(good), Err(Error::CapacityExceeded { capacity: 1 }));
    let count = |shadows: &mut PointShadows, casters: &mut Casters| {
        gpu().submit(|encoder| shadows.record(&gpu().device, &gpu().queue, encoder, casters)).unwrap()
    };
    assert_eq!(count(&mut shadows, &mut casters), 0, "refused values made the light stale");
    for priority in [0.0, f32::NAN] {
        let refused = shadows.set_priority(id, priority);
        assert!(matches!(refused, Err(Error::InvalidLight { what: "priority", .. })), "{refused:?}");
    }
    shadows.set_priority(id, 2.0).unwrap();
    shadows.set(id, good).unwrap();
    assert_eq!(count(&mut shadows, &mut casters), 0, "the same values made the light stale");
    shadows.remove(id).unwrap();
    assert!(matches!(shadows.set(id, good), Err(Error::StaleHandle { what: "light", .. })));
    assert!(matches!(shadows.set_priority(id, 1.0), Err(Error::StaleHandle { what: "light", .. })));
    assert_eq!(gpu().shadow_values(&shadows, &casters, id, &[(Vec3::X, Vec3::X)]), [1.0], "not recorded yet");
    assert_eq!(count(&mut shadows, &mut casters), 0);
    assert_eq!(
        gpu().shadow_values(&shadows, &casters, id, &[(Vec3::X, Vec3::X)]),
        [0.0],
        "a light that is gone lights nothing"
    );
}

#[test]
fn no_light_is_dark_wherever_it_is_asked() {
    let walls = box_inside(Vec3::splat(-2.0), Vec3::splat(2.0));
    let mut casters = soup(&walls, Sides::Auto);
    let four = PointShadowsDescriptor { capacity: 4, ..descriptor(32) };
    let near = PointLight { range: 5.0, ..Default::default() };
    let (mut shadows, gone) = record(PointShadows::new(&gpu().device, &four).unwrap(), &mut casters, near);
    // An index that no light of these ever had.
    let mut others = PointShadows::new(&gpu().device, &four).unwrap();
    let unused = [0; 4].map(|_| others.add(near).unwrap())[3];
    let distances = [0.0, 1e-30, 0.5, 4.9, 5.1, 1e3, 1e18, 1e30];
    let receivers = distances.map(|distance| (distance * Vec3::new(0.6, -0.64, 0.48), Vec3::X));
    let far = |shadows: &PointShadows, id| gpu().shadow_values(shadows, &casters, id, &receivers[4..]);
    assert_eq!(far(&shadows, gone), [1.0; 4], "a light that is there doesn't end beyond its range");
    shadows.remove(gone).unwrap();
    let made = gpu().submit(|encoder| shadows.record(&gpu().device, &gpu().queue, encoder, &mut casters)).unwrap();
    assert_eq!(made, 0);
    for id in [gone, unused] {
        assert_eq!(gpu().shadow_values(&shadows, &casters, id, &receivers), [0.0; 8], "index {}", id.index());
        assert_eq!(gpu().filtered_values(&shadows, &casters, id, &receivers), [0.0; 8], "index {}", id.index());
        assert_eq!(gpu().vote_values(&shadows, id, &receivers), [0.0; 8], "index {}", id.index());
    }
}

#[test]
fn descriptors() {
    let good = descriptor(64);
    let widest = gpu().device.limits().max_texture_dimension_2d;
    let wrong = [
        ("capacity", PointShadowsDescriptor { capacity: 0, ..good }),
        ("capacity", PointShadowsDescriptor { capacity: 100_000, ..good }),
        ("resolution", PointShadowsDescriptor { resolution: 0, ..good }),
        ("resolution", PointShadowsDescriptor { resolution: widest, ..good }),
        ("guard", PointShadowsDescriptor { guard: -1.0, ..good }),
    ];
    for (name, descriptor) in wrong {
        match PointShadows::new(&gpu().device, &descriptor) {
            Err(Error::InvalidDescriptor { what, .. }) => assert_eq!(what, name),
            other => panic!("{name}: {:?}", other.map(|_| ())),
        }
    }
}

fn texture(descriptor: wgpu::TextureDescriptor) -> wgpu::Texture {
    gpu().device.create_texture(&descriptor)
}

#[test]
fn masks() {
    let good = wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 4, height: 4, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let mut casters = Casters::new(&gpu().device).unwrap();
    let suitable = texture(good.clone());
    let coordinates = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let mask = Mask {
        texture_coordinates: &coordinates,
        texture: &suitable,
        cutoff: 0.5,
        address_modes: [wgpu::AddressMode::Repeat; 2],
    };
    let before = (casters.memory(), casters.triangle_count());
    let mut add = |mask| casters.add_mesh(&CasterMesh { mask: Some(mask), ..mesh(&TRIANGLE, &[0, 1, 2]) });
    let few = Mask { texture_coordinates: &coordinates[..2], ..mask };
    assert_eq!(add(few), Err(Error::TextureCoordinateCount { coordinates: 2, positions: 3 }));
    let broken = [[0.0, 0.0], [f32::NAN, 0.0], [0.0, 1.0]];
    let broken = add(Mask { texture_coordinates: &broken, ..mask });
    assert!(matches!(broken, Err(Error::TextureCoordinateNotFinite { vertex: 1, .. })));
    let mut refused = |mask, name: &str| match add(mask) {
        Err(Error::InvalidMask { what, .. }) => assert_eq!(what, name),
        other => panic!("{name}: {other:?}"),
    };
    for cutoff in [-0.1, 1.1, f32::NAN, f32::INFINITY] {
        refused(Mask { cutoff, ..mask }, "cutoff");
    }
    let border = [wgpu::AddressMode::Repeat, wgpu::AddressMode::ClampToBorder];
    refused(Mask { address_modes: border, ..mask }, "address mode");
    let deep = wgpu::Extent3d { depth_or_array_layers: 6, ..good.size };
    let samples = wgpu::TextureDescriptor { sample_count: 4, ..good.clone() };
    let samples = wgpu::TextureDescriptor { usage: samples.usage | wgpu::TextureUsages::RENDER_ATTACHMENT, ..samples };
    let format = |format| wgpu::TextureDescriptor { format, ..good.clone() };
    let unsuitable = [
        ("texture", wgpu::TextureDescriptor { size: deep, ..good.clone() }),
        ("texture", wgpu::TextureDescriptor { dimension: wgpu::TextureDimension::D3, ..good.clone() }),
        ("texture", samples),
        ("texture's format", format(wgpu::TextureFormat::Rgba8Uint)),
        ("texture's format", format(wgpu::TextureFormat::R8Unorm)),
        ("texture's format", format(wgpu::TextureFormat::Depth32Float)),
        ("texture's usage", wgpu::TextureDescriptor { usage: wgpu::TextureUsages::COPY_DST, ..good.clone() }),
    ];
    let unsuitable = unsuitable.map(|(name, descriptor)| (name, texture(descriptor)));
    for (name, texture) in &unsuitable {
        refused(Mask { texture, ..mask }, name);
    }
    assert_eq!((casters.memory(), casters.triangle_count()), before);
    let mesh = CasterMesh { mask: Some(mask), ..mesh(&TRIANGLE, &[0, 1, 2]) };
    assert!(casters.add_mesh(&mesh).is_ok());
}
