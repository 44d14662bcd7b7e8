//! With the device lost nothing panics or hangs: recording is an error, and everything made anew works.

use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::{
    CasterMesh, Casters, Error, Indices, LightId, MeshId, PointLight, PointShadows, PointShadowsDescriptor, Sides,
};
use glam::{Affine3A, Vec3};

const TRIANGLE: [[f32; 3]; 3] = [[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [0.0, 1.0, 1.0]];

struct Setup {
    gpu: Gpu,
    casters: Casters,
    mesh: MeshId,
    shadows: PointShadows,
    light: LightId,
}

fn descriptor() -> PointShadowsDescriptor {
    PointShadowsDescriptor { capacity: 2, resolution: 32, keep_static: true, ..Default::default() }
}

impl Setup {
    fn new() -> Self {
        let gpu = Gpu::new(wgpu::Features::empty()).unwrap();
        let mut casters = Casters::new(&gpu.device).unwrap();
        let mesh = CasterMesh {
            positions: &TRIANGLE,
            indices: Indices::U32(&[0, 1, 2]),
            sides: Sides::Auto,
            ..Default::default()
        };
        let mesh = casters.add_mesh(&mesh).unwrap();
        casters.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        let mut shadows = PointShadows::new(&gpu.device, &descriptor()).unwrap();
        let light = shadows.add(PointLight::default()).unwrap();
        Self { gpu, casters, mesh, shadows, light }
    }

    fn record(&mut self) -> Result<u32, Error> {
        let Gpu { device, queue, .. } = &self.gpu;
        self.gpu.submit(|encoder| self.shadows.record(device, queue, encoder, &mut self.casters))
    }
}

/// Everything that a renderer may call, with what waits for the device changed each time.
fn use_lost(setup: &mut Setup) {
    let lost = Err(Error::DeviceLost);
    assert_eq!(setup.record(), lost);
    let moved = Affine3A::from_translation(Vec3::X);
    // More than there is room for.
    let instances: Vec<_> = (0..1000).map(|_| setup.casters.add_instance(setup.mesh, moved).unwrap()).collect();
    assert_eq!(setup.record(), lost);
    setup.casters.set_transform(instances[0], Affine3A::IDENTITY).unwrap();
    setup.casters.set_moving(instances[1], true).unwrap();
    setup.casters.remove_instance(instances[2]).unwrap();
    setup.shadows.set(setup.light, PointLight { range: 3.0, ..Default::default() }).unwrap();
    let other = setup.shadows.add(PointLight::default()).unwrap();
    assert_eq!(setup.record(), lost);
    setup.shadows.remove(other).unwrap();
    let _ = (setup.shadows.memory(), setup.casters.memory(), setup.shadows.bind_group());
    assert_eq!(setup.record(), lost);
    let mut casters = Casters::new(&setup.gpu.device).unwrap();
    assert_eq!(PointShadows::new(&setup.gpu.device, &descriptor()).err(), lost.err());
    let result =
        setup.gpu.submit(|encoder| setup.shadows.record(&setup.gpu.device, &setup.gpu.queue, encoder, &mut casters));
    assert_eq!(result, Err(Error::DeviceLost));
}

#[test]
fn before_the_first_recording() {
    let mut setup = Setup::new();
    setup.gpu.device.destroy();
    use_lost(&mut setup);
}

#[test]
fn with_work_under_way_and_after_it() {
    let mut setup = Setup::new();
    assert_eq!(setup.record(), Ok(1));
    setup.gpu.device.destroy();
    assert_eq!(setup.record(), Err(Error::DeviceLost));
    // Now the readback of the counters is done, and the device's resources are gone.
    setup.gpu.wait();
    use_lost(&mut setup);
    setup.gpu.wait();
    use_lost(&mut setup);
    let mut fresh = Setup::new();
    assert_eq!(fresh.record(), Ok(1));
    fresh.gpu.wait();
    assert!(fresh.gpu.read_map(&fresh.shadows, fresh.light).iter().any(|depth| *depth > 0.0));
}
