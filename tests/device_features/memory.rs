//! The memory that the library says it takes, against the driver's own count.

use crate::common::add_spheres;
use crate::trial;
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::{Casters, PointLight, PointShadows, PointShadowsDescriptor};
use libtest_mimic::Trial;

pub fn trials() -> Vec<Trial> {
    vec![
        trial("memory::stated_is_allocated", stated_is_allocated),
        trial("memory::what_came_and_went_is_given_back", what_came_and_went_is_given_back),
    ]
}

/// A device of its own, so that nobody else's buffers count, and that counts what it allocates.
fn device() -> Result<Gpu, String> {
    let gpu = Gpu::new(wgpu::Features::empty()).unwrap_or_else(|error| panic!("{error}"));
    match gpu.device.generate_allocator_report() {
        Some(_) => Ok(gpu),
        None => Err(format!("{} doesn't count what it allocates", gpu.name())),
    }
}

/// Asserts that the library's buffers and textures take what is stated.
fn assert_allocated(gpu: &Gpu, stated: u64) {
    let report = gpu.device.generate_allocator_report().expect("it did before");
    let own = report.allocations.iter().filter(|allocation| allocation.name.starts_with("dual_paraboloid"));
    let (bytes, count) = own.fold((0, 0), |(bytes, count), allocation| (bytes + allocation.size, count + 1));
    // Drivers round up: buffers to what they may be bound at, textures to their tiles.
    let most = stated + stated / 50 + 1024 * count;
    assert!((stated..=most).contains(&bytes), "{bytes} bytes in {count} allocations, and {stated} stated");
}

fn record(gpu: &Gpu, shadows: &mut PointShadows, casters: &mut Casters) {
    gpu.submit(|encoder| shadows.record(&gpu.device, &gpu.queue, encoder, casters)).unwrap();
    gpu.wait();
}

fn stated_is_allocated() -> Result<(), String> {
    let gpu = device()?;
    let mut casters = Casters::new(&gpu.device).unwrap();
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
            record(&gpu, &mut shadows, &mut casters);
        }
        let maps = 6 * 4 * 2 * 64 * 64 * if keep_static { 2 } else { 1 };
        assert!(shadows.memory() > maps);
    }
    gpu.wait();
    assert_allocated(&gpu, casters.memory());
    Ok(())
}

fn what_came_and_went_is_given_back() -> Result<(), String> {
    let gpu = device()?;
    let mut casters = Casters::new(&gpu.device).unwrap();
    let descriptor = PointShadowsDescriptor { capacity: 1, resolution: 32, ..Default::default() };
    let mut shadows = PointShadows::new(&gpu.device, &descriptor).unwrap();
    shadows.add(PointLight::default()).unwrap();
    for _ in 0..2 {
        let (mesh, instances) = add_spheres(&mut casters, 10_000);
        record(&gpu, &mut shadows, &mut casters);
        assert_allocated(&gpu, casters.memory() + shadows.memory());
        instances.into_iter().for_each(|instance| casters.remove_instance(instance).unwrap());
        casters.remove_mesh(mesh).unwrap();
        let full = casters.memory();
        record(&gpu, &mut shadows, &mut casters);
        assert_allocated(&gpu, casters.memory() + shadows.memory());
        // The buffers that the last one replaced are kept until it is known to be done.
        record(&gpu, &mut shadows, &mut casters);
        assert_allocated(&gpu, casters.memory() + shadows.memory());
        assert!(casters.memory() < full / 50, "{} bytes of {full} are left", casters.memory());
    }
    Ok(())
}
