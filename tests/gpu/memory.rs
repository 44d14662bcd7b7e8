//! What the GPU's memory is said to hold is what it holds.

use crate::common::gpu;
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::procedural::shapes;
use dual_paraboloid::{
    CasterMesh, Casters, Indices, InstanceId, MeshId, PointLight, PointShadows, PointShadowsDescriptor, Sides,
};
use glam::{Affine3A, Vec3};

/// Bytes of the library's buffers and textures by the driver's own count, and how many there are. None where the
/// backend doesn't count.
fn allocated(gpu: &Gpu) -> Option<(u64, u64)> {
    let report = gpu.device.generate_allocator_report()?;
    let own = report.allocations.iter().filter(|allocation| allocation.name.starts_with("dual_paraboloid"));
    Some(own.fold((0, 0), |(bytes, count), allocation| (bytes + allocation.size, count + 1)))
}

fn assert_allocated(gpu: &Gpu, stated: u64) {
    let Some((bytes, count)) = allocated(gpu) else {
        eprintln!("this backend doesn't count allocations: what is stated isn't held against them");
        return;
    };
    // Drivers round up: buffers to what they may be bound at, textures to their tiles.
    let most = stated + stated / 50 + 1024 * count;
    assert!((stated..=most).contains(&bytes), "{bytes} bytes in {count} allocations, and {stated} stated");
}

fn frame(gpu: &Gpu, shadows: &mut PointShadows, casters: &mut Casters) -> u32 {
    let made = gpu.submit(|encoder| shadows.record(&gpu.device, &gpu.queue, encoder, casters)).unwrap();
    gpu.wait();
    made
}

/// So many spheres of 320 triangles in rows.
fn add_spheres(casters: &mut Casters, count: usize) -> (MeshId, Vec<InstanceId>) {
    let sphere = shapes::icosphere(0.3, 2);
    let mesh = CasterMesh {
        positions: &sphere.positions,
        indices: Indices::U32(&sphere.indices),
        sides: Sides::Both,
        ..Default::default()
    };
    let mesh = casters.add_mesh(&mesh).unwrap();
    let place = |k: usize| Vec3::new((k % 100) as f32, (k / 100) as f32, 2.0);
    let add = |k| casters.add_instance(mesh, Affine3A::from_translation(place(k))).unwrap();
    (mesh, (0..count).map(add).collect())
}

#[test]
fn stated_is_allocated() {
    let gpu = Gpu::new(wgpu::Features::empty()).unwrap();
    let mut casters = Casters::new(&gpu.device);
    assert_allocated(&gpu, casters.memory());
    add_spheres(&mut casters, 200);
    for keep_static in [false, true] {
        let descriptor = PointShadowsDescriptor { capacity: 6, resolution: 64, keep_static, ..Default::default() };
        let mut shadows = PointShadows::new(&gpu.device, &descriptor).unwrap();
        for _ in 0..6 {
            shadows.add(PointLight::default()).unwrap();
        }
        for _ in 0..2 {
            assert_allocated(&gpu, casters.memory() + shadows.memory());
            frame(&gpu, &mut shadows, &mut casters);
        }
        let maps = 6 * 4 * 2 * 64 * 64 * if keep_static { 2 } else { 1 };
        assert!(shadows.memory() > maps);
    }
    gpu.wait();
    assert_allocated(&gpu, casters.memory());
}

#[test]
fn many_lights_take_what_a_batch_needs() {
    let memory = |lights: u32| {
        let mut casters = Casters::new(&gpu().device);
        add_spheres(&mut casters, 100);
        let descriptor = PointShadowsDescriptor { capacity: lights, resolution: 32, ..Default::default() };
        let mut shadows = PointShadows::new(&gpu().device, &descriptor).unwrap();
        for number in 0..lights {
            let range = if number == 0 { 200.0 } else { 0.1 };
            shadows.add(PointLight { range, ..Default::default() }).unwrap();
        }
        assert_eq!(frame(gpu(), &mut shadows, &mut casters), lights);
        shadows.memory() - u64::from(lights) * 4 * 2 * 32 * 32
    };
    let (one, batch, many) = (memory(1), memory(8), memory(64));
    assert!(batch <= 8 * one, "{one} bytes beside the map of one light, {batch} beside those of 8");
    assert!(many <= batch + 56 * 2048, "{batch} bytes beside the maps of 8 lights, {many} beside those of 64");
}

#[test]
fn ten_thousand_come_and_go() {
    let gpu = Gpu::new(wgpu::Features::empty()).unwrap();
    let mut casters = Casters::new(&gpu.device);
    let descriptor = PointShadowsDescriptor { capacity: 1, resolution: 32, ..Default::default() };
    let mut shadows = PointShadows::new(&gpu.device, &descriptor).unwrap();
    shadows.add(PointLight::default()).unwrap();
    frame(&gpu, &mut shadows, &mut casters);
    let empty = casters.memory();
    let mut full = 0;
    for round in 0..3 {
        let (mesh, mut ids) = add_spheres(&mut casters, 10_000);
        frame(&gpu, &mut shadows, &mut casters);
        assert!(full == 0 || casters.memory() == full, "round {round}: {} bytes, before {full}", casters.memory());
        full = casters.memory();
        // Every other one first, so that what is left is full of holes.
        let (mut turn, mut half) = (0, Vec::new());
        ids.retain(|&id| {
            turn += 1;
            if turn % 2 == 0 {
                half.push(id);
            }
            turn % 2 == 1
        });
        for part in [half, ids] {
            part.into_iter().for_each(|id| casters.remove_instance(id).unwrap());
            frame(&gpu, &mut shadows, &mut casters);
        }
        casters.remove_mesh(mesh).unwrap();
        assert_eq!(casters.triangle_count(), 0);
        // Rooms of arrays are within a factor of four of what is used, and there are five.
        assert!(casters.memory() < empty + (1 << 20), "round {round}: {} bytes, {empty} at first", casters.memory());
        frame(&gpu, &mut shadows, &mut casters);
        assert_allocated(&gpu, casters.memory() + shadows.memory());
    }
}
