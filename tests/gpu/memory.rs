//! The memory that the library says it takes. `tests/device_features` holds that against the driver's own count.

use crate::common::{add_spheres, gpu};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::{Casters, PointLight, PointShadows, PointShadowsDescriptor};

fn frame(gpu: &Gpu, shadows: &mut PointShadows, casters: &mut Casters) -> u32 {
    let made = gpu.submit(|encoder| shadows.record(&gpu.device, &gpu.queue, encoder, casters)).unwrap();
    gpu.wait();
    made
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
    }
}
