//! The memory that the library says it takes. `tests/device_features` holds that against the driver's own count.

use crate::common::{add_spheres, gpu, soup};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::{Casters, PointLight, PointShadows, PointShadowsDescriptor, Sides};
use glam::Vec3;

fn frame(gpu: &Gpu, shadows: &mut PointShadows, casters: &mut Casters) -> u32 {
    let made = gpu.submit(|encoder| shadows.record(&gpu.device, &gpu.queue, encoder, casters)).unwrap();
    gpu.wait();
    made
}

/// What shadows of 32 texels across take beside the maps, with so many lights, once a triangle was drawn for them.
fn beside_maps(lights: u32) -> u64 {
    let mut casters =
        soup(&[[Vec3::new(-1.0, -1.0, 2.0), Vec3::new(1.0, -1.0, 2.0), Vec3::new(0.0, 1.0, 2.0)]], Sides::Auto);
    let descriptor = PointShadowsDescriptor { capacity: lights, resolution: 32, ..Default::default() };
    let mut shadows = PointShadows::new(&gpu().device, &descriptor).unwrap();
    for _ in 0..lights {
        shadows.add(PointLight::default()).unwrap();
    }
    assert_eq!(frame(gpu(), &mut shadows, &mut casters), lights);
    // Depths and numbers, of four bytes each.
    shadows.memory() - u64::from(lights) * 2 * 32 * 32 * 8
}

#[test]
fn many_lights_take_what_a_batch_needs() {
    // Of a light: 2 x 2 tiles of two hemispheres, each with 256 depths and numbers, two counters and a list of 512; 64
    // records of 64 bytes; 64 jobs; 64 winners.
    let share = 8 * (256 * 8 + 8 + 512 * 4) + 64 * 64 + 64 * 4 + 64 * 4;
    // 32 bytes of counters of a light, eight lights at least, and 38 words for the chunk.
    let state = 8 * 32 + 38 * 4;
    // Of each light 112 bytes of its own and two hemispheres' views for the caller's casters, and as many as a batch more.
    let others = |lights: u64| lights * (112 + 2 * 256) + (lights + 8) * 256;
    assert_eq!(beside_maps(1), share + state + others(1));
    // A quarter more counters and words than are needed.
    let state = |lights: u64| (lights + lights / 4) * 32 + 8 * (38 + 9) * 4;
    assert_eq!(beside_maps(8), 8 * share + state(8) + others(8));
    assert_eq!(beside_maps(64), 8 * share + state(64) + others(64));
}

#[test]
fn ten_thousand_come_and_go() {
    let gpu = Gpu::new(wgpu::Features::empty()).unwrap();
    let mut casters = Casters::new(&gpu.device).unwrap();
    let descriptor = PointShadowsDescriptor { capacity: 1, resolution: 32, ..Default::default() };
    let mut shadows = PointShadows::new(&gpu.device, &descriptor).unwrap();
    shadows.add(PointLight::default()).unwrap();
    frame(&gpu, &mut shadows, &mut casters);
    let empty = casters.memory();
    let mut full = 0;
    for round in 0..3 {
        let (mesh, mut ids) = add_spheres(&mut casters, 10_000);
        // The second finds out that the first is done, and lets the old buffers go.
        for _ in 0..2 {
            frame(&gpu, &mut shadows, &mut casters);
        }
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
        frame(&gpu, &mut shadows, &mut casters);
        casters.remove_mesh(mesh).unwrap();
        assert_eq!(casters.triangle_count(), 0);
        // Rooms of arrays are within a factor of four of what is used, and there are five.
        assert!(casters.memory() < empty + (1 << 20), "round {round}: {} bytes, {empty} at first", casters.memory());
        frame(&gpu, &mut shadows, &mut casters);
    }
}
