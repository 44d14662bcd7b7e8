//! Casters that the caller draws make the maps of casters that the library holds, within what the hardware's straight edges
//! are off.

use crate::common::{Map, Texel, gpu};
use dual_paraboloid::compare::numbered::NO_NUMBER;
use dual_paraboloid::compare::procedural::shapes;
use dual_paraboloid::paraboloid::double as paraboloid;
use dual_paraboloid::{
    CasterMesh, CasterPass, Casters, Error, Indices, LightId, PointLight, PointShadows, PointShadowsDescriptor,
    RecordOptions, Sides, wgsl,
};
use glam::{Affine3A, Vec3};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

const RESOLUTION: u32 = 48;

/// Number of the group that the hemisphere is bound to, one that isn't the library's own.
const GROUP: u32 = 1;

/// A mesh that the caller draws.
struct Own {
    pipeline: wgpu::RenderPipeline,
    vertices: wgpu::Buffer,
    count: u32,
}

impl Own {
    fn new(shadows: &PointShadows, triangles: &[[f32; 3]]) -> Self {
        let device = &gpu().device;
        let entry_point = "
@vertex
fn own_caster(@location(0) position: vec3<f32>) -> @invariant @builtin(position) vec4<f32> {
    return dp_caster_position(position);
}";
        let text = [&wgsl::caster(GROUP), entry_point].concat();
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("own casters"),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            bind_group_layouts: &[None, Some(shadows.caster_bind_group_layout())],
            ..Default::default()
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("own casters"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("own_caster"),
                compilation_options: Default::default(),
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: 12,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![0 => Float32x3],
                })],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(CasterPass::depth_state()),
            multisample: wgpu::MultisampleState::default(),
            fragment: None,
            multiview_mask: None,
            cache: None,
        });
        let vertices = device.create_buffer_init(&BufferInitDescriptor {
            label: Some("own casters"),
            contents: bytemuck::cast_slice(triangles),
            usage: wgpu::BufferUsages::VERTEX,
        });
        Self { pipeline, vertices, count: triangles.len() as u32 }
    }

    fn draw(&self, pass: &mut CasterPass) {
        pass.bind(GROUP);
        pass.pass.set_pipeline(&self.pipeline);
        pass.pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.pass.draw(0..self.count, 0..1);
    }
}

/// A ball of triangles finer than the angle limit, around the light, and a plate of the library's behind a part of it.
struct Scene {
    casters: Casters,
    ball: Vec<[f32; 3]>,
    light: PointLight,
}

impl Scene {
    fn new(own: bool) -> Self {
        let mut casters = Casters::new(&gpu().device).unwrap();
        let mut add = |positions: &[[f32; 3]]| {
            let indices: Vec<u32> = (0..positions.len() as u32).collect();
            let mesh =
                CasterMesh { positions, indices: Indices::U32(&indices), sides: Sides::Both, ..Default::default() };
            let mesh = casters.add_mesh(&mesh).unwrap();
            casters.add_instance(mesh, Affine3A::IDENTITY).unwrap();
        };
        let sphere = shapes::icosphere(2.0, 5);
        // A half of it, so that the plate is seen.
        let faces = sphere.indices.chunks_exact(3).take(sphere.indices.len() / 6).flatten();
        let ball: Vec<[f32; 3]> = faces.map(|&vertex| sphere.positions[vertex as usize]).collect();
        add(&[[-9.0, -9.0, 1.5], [9.0, -9.0, 1.5], [0.0, 9.0, 1.5]]);
        if !own {
            add(&ball);
        }
        Self { casters, ball, light: PointLight { position: Vec3::new(0.1, 0.0, -0.1), ..Default::default() } }
    }

    fn shadows(&self, keep_static: bool) -> (PointShadows, LightId) {
        let descriptor =
            PointShadowsDescriptor { capacity: 1, resolution: RESOLUTION, keep_static, ..Default::default() };
        let mut shadows = PointShadows::new(&gpu().device, &descriptor).unwrap();
        let light = shadows.add(self.light).unwrap();
        (shadows, light)
    }

    fn record(&mut self, shadows: &mut PointShadows, draw: Option<&mut dyn FnMut(&mut CasterPass)>) -> u32 {
        let options = RecordOptions { draw, ..Default::default() };
        let made = gpu()
            .submit(|encoder| shadows.record_with(&gpu().device, &gpu().queue, encoder, &mut self.casters, options));
        gpu().wait();
        made.unwrap()
    }
}

/// How far the depth of casters that keep to the angle limit is off along their normal, in texel footprints: half of the
/// tenth of a texel by which their edges are.
const CHORD: f64 = 0.05;

/// Holds a map with the caller's own casters against that of casters that the library holds, `expected`, in which those that
/// the caller draws here have no number of `plate`. Returns how many texels of theirs were compared.
fn compare(map: &Map, expected: &Map, plate: &[u32]) -> usize {
    let is_plate = |texel: &Texel| plate.contains(&texel.number);
    let (mut compared, held_texels) = (0, expected.texels().collect::<Vec<Texel>>());
    for (index, (texel, held)) in map.texels().zip(&held_texels).enumerate() {
        if held.p.length() > 1.0 {
            continue;
        }
        // Its neighbours in the disc tell whether an outline is near.
        let row = 2 * RESOLUTION as usize;
        let around =
            [index - row, index, index + row].into_iter().flat_map(|middle| &held_texels[middle - 1..=middle + 1]);
        let own = around.filter(|texel| texel.depth > 0.0 && !is_plate(texel)).count();
        if own == 0 {
            assert_eq!((texel.depth.to_bits(), is_plate(&texel)), (held.depth.to_bits(), is_plate(held)), "{texel:?}");
        } else if own == 9 {
            assert_eq!(texel.number, NO_NUMBER, "{texel:?}");
            let footprint = paraboloid::texel_angle(texel.p.as_dvec2(), f64::from(map.texel()));
            // The ball is seen nearly straight on, from its middle.
            let off = f64::from(texel.depth / held.depth - 1.0).abs() / footprint;
            assert!(off <= CHORD, "{texel:?} is off by {off} footprints from {held:?}");
            compared += 1;
        }
    }
    compared
}

#[test]
fn the_callers_own_are_those_held_within_the_chords() {
    let mut held = Scene::new(false);
    let (mut shadows, light) = held.shadows(false);
    assert_eq!(held.record(&mut shadows, None), 1);
    for corners in held.ball.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|k| Vec3::from(corners[k]) - held.light.position);
        let longest = a.angle_between(b).max(b.angle_between(c)).max(c.angle_between(a));
        assert!(longest <= shadows.caster_angle_limit(), "{longest}");
    }
    let expected = Map::read(&shadows, light);
    // The first mesh's chunk.
    let plate: Vec<u32> = gpu().numbered_triangles(&held.casters).into_keys().filter(|number| *number < 256).collect();
    assert_eq!(plate.len(), 1);
    for keep_static in [false, true] {
        let mut scene = Scene::new(true);
        let (mut shadows, light) = scene.shadows(keep_static);
        let own = Own::new(&shadows, &scene.ball);
        let mut seen = Vec::new();
        let mut draw = |pass: &mut CasterPass| {
            seen.push((pass.back, pass.light));
            own.draw(pass);
        };
        // Later the ones kept are drawn over.
        for _ in 0..2 {
            assert_eq!(scene.record(&mut shadows, Some(&mut draw)), 1);
            let compared = compare(&Map::read(&shadows, light), &expected, &plate);
            assert!(compared > 200, "keep_static {keep_static}: {compared}");
            assert_eq!(scene.record(&mut shadows, Some(&mut draw)), 0, "nothing has changed");
            scene.casters.touch(Vec3::splat(30.0), Vec3::splat(40.0)).unwrap();
            assert_eq!(scene.record(&mut shadows, Some(&mut draw)), 0, "nothing has changed within range");
            scene.casters.touch(Vec3::splat(-2.0), Vec3::splat(2.0)).unwrap();
        }
        assert_eq!(seen, [(false, scene.light), (true, scene.light)].repeat(2));
        assert_eq!(scene.record(&mut shadows, None), 1);
        assert!(!expected.differences(&Map::read(&shadows, light)).is_empty(), "what isn't drawn is in the map");
    }
}

#[test]
fn boxes_the_wrong_way_round() {
    let mut casters = Casters::new(&gpu().device).unwrap();
    for (min, max) in [(Vec3::ONE, Vec3::ZERO), (Vec3::NAN, Vec3::ONE), (Vec3::ZERO, Vec3::new(1.0, f32::NAN, 1.0))] {
        assert!(matches!(casters.touch(min, max), Err(Error::InvalidBox { .. })), "{min} {max}");
    }
    assert_eq!(casters.touch(Vec3::NEG_INFINITY, Vec3::INFINITY), Ok(()));
}
