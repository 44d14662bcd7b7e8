//! Devices that have just enough, and devices that don't.

use crate::common::gpu;
use dual_paraboloid::{
    CasterMesh, CasterPass, Casters, Deformed, Error, Indices, Mask, PointLight, PointShadows, PointShadowsDescriptor,
    RecordOptions, Sides, limits_one_too_low, required_features, required_limits, wgsl,
};
use glam::{Affine3A, Vec3};

/// A device of the tests' adapter, and nothing more than is asked for. Complaints are panics.
fn device(required_limits: wgpu::Limits) -> (wgpu::Device, wgpu::Queue) {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::PRIMARY;
    let instance = wgpu::Instance::new(descriptor);
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    let adapter = adapters.into_iter().find(|adapter| adapter.get_info() == gpu().info).unwrap();
    let required_features = required_features();
    let request =
        wgpu::DeviceDescriptor { required_features, required_limits: required_limits.clone(), ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&request)).unwrap();
    assert_eq!(device.limits(), required_limits);
    (device, queue)
}

#[test]
fn one_too_low_is_refused_by_name() {
    let descriptor = PointShadowsDescriptor { resolution: 32, ..Default::default() };
    let mut wrong = limits_one_too_low();
    let names: Vec<&str> = wrong.iter().map(|(name, _)| *name).collect();
    assert!(names.contains(&"max_storage_buffers_per_shader_stage") && names.len() > 10);
    wrong.push(("max_storage_buffers_per_shader_stage", wgpu::Limits::downlevel_defaults()));
    for (name, limits) in wrong {
        let (device, _) = device(limits);
        for refused in [Casters::new(&device).err(), PointShadows::new(&device, &descriptor).err()] {
            let refused = refused.unwrap_or_else(|| panic!("{name} is low enough"));
            assert!(matches!(refused, Error::LimitTooLow { limit, .. } if limit == name), "{name}: {refused}");
            assert!(refused.to_string().contains("required_limits()"), "{refused}");
        }
    }
}

#[test]
fn what_is_required_is_enough() {
    let (device, queue) = device(required_limits());
    let mut casters = Casters::new(&device).unwrap();
    let descriptor = PointShadowsDescriptor { resolution: 1024, keep_static: true, ..Default::default() };
    let mut shadows = PointShadows::new(&device, &descriptor).unwrap();
    let positions = [[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [0.0, 1.0, 2.0]];
    let plain = CasterMesh {
        positions: &positions,
        indices: Indices::U32(&[0, 1, 2]),
        sides: Sides::Both,
        ..Default::default()
    };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 4, height: 4, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let mask = Mask {
        texture_coordinates: &[[0.0; 2]; 3],
        texture: &texture,
        cutoff: 0.5,
        address_modes: [wgpu::AddressMode::Repeat; 2],
    };
    let meshes =
        [plain, CasterMesh { mask: Some(mask), ..plain }, CasterMesh { deforms: true, mask: Some(mask), ..plain }];
    let instances = meshes.map(|mesh| {
        let mesh = casters.add_mesh(&mesh).unwrap();
        casters.add_instance(mesh, Affine3A::IDENTITY).unwrap()
    });
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 36,
        usage: wgpu::BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let deformed = Deformed { positions: &buffer, offset: 0, stride: 12, min: Vec3::ZERO, max: Vec3::ONE };
    casters.deform(instances[2], &deformed).unwrap();
    casters.set_moving(instances[0], true).unwrap();
    for _ in 0..4 {
        shadows.add(PointLight::default()).unwrap();
    }
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let mut drawn = 0;
    let mut draw = |_: &mut CasterPass| drawn += 1;
    let options = RecordOptions { draw: Some(&mut draw), ..Default::default() };
    assert_eq!(shadows.record_with(&device, &queue, &mut encoder, &mut casters, options), Ok(4));
    queue.submit([encoder.finish()]);
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    assert_eq!(drawn, 8);
    // A pass that looks the shadows up fits too.
    let text = [
        &wgsl::lookup(0, 1),
        "
@group(0) @binding(9) var<storage, read_write> result: f32;
@compute @workgroup_size(1)
fn look() { result = dp_shadow(0u, vec3<f32>(1.0), vec3<f32>(1.0), vec4<f32>(0.0)); }",
    ];
    let _ = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(text.concat().into()),
    });
    let layouts = [Some(shadows.bind_group_layout()), Some(casters.bind_group_layout())];
    let _ = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &layouts,
        ..Default::default()
    });
}
