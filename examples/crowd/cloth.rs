//! A banner that waves: a grid that hangs from the x axis, with other positions in each frame.

use bytemuck::cast_slice;
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::scene::{SceneInstance, SceneMesh};
use dual_paraboloid::{CasterMesh, Casters, Deformed, Error, Indices, InstanceId};
use glam::Vec3;

pub const WIDTH: f32 = 6.0;
const HEIGHT: f32 = 2.4;
/// How far the lower edge swings, in metres.
const SWING: f32 = 0.35;
const QUADS: u32 = 40;
const ROW: u32 = QUADS + 1;

/// Where its vertices are after so many seconds.
pub fn positions(seconds: f32) -> Vec<[f32; 3]> {
    let position = |vertex: u32| {
        let [across, down] = [vertex % ROW, vertex / ROW].map(|k| k as f32 / QUADS as f32);
        let wave = (13.0 * across + 2.0 * down - 5.0 * seconds).sin();
        [WIDTH * (across - 0.5), -HEIGHT * down, SWING * down * wave]
    };
    (0..ROW * ROW).map(position).collect()
}

pub fn mesh() -> SceneMesh {
    let quad = |quad: u32| {
        let corner = quad / QUADS * ROW + quad % QUADS;
        let [below, across] = [corner + ROW, corner + 1];
        [corner, below, below + 1, corner, below + 1, across]
    };
    let indices = (0..QUADS * QUADS).flat_map(quad).collect();
    SceneMesh { positions: positions(0.0), indices, ..SceneMesh::default() }
}

/// The banner as a caster that deforms.
pub struct Cloth {
    pub caster: InstanceId,
    positions: wgpu::Buffer,
}

impl Cloth {
    pub fn new(gpu: &Gpu, casters: &mut Casters, mesh: &SceneMesh, instance: &SceneInstance) -> Result<Self, Error> {
        let indices = Indices::U32(&mesh.indices);
        let caster = CasterMesh { positions: &mesh.positions, indices, deforms: true, ..Default::default() };
        let caster = casters.add_mesh(&caster)?;
        let positions = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("crowd::cloth"),
            size: size_of_val(mesh.positions.as_slice()) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Ok(Self { caster: casters.add_instance(caster, instance.transform)?, positions })
    }

    /// Gives the caster the positions that the mesh has now.
    pub fn deform(&self, gpu: &Gpu, casters: &mut Casters, mesh: &SceneMesh) -> Result<(), Error> {
        gpu.queue.write_buffer(&self.positions, 0, cast_slice(&mesh.positions));
        let (min, max) = (Vec3::new(-0.5 * WIDTH, -HEIGHT, -SWING), Vec3::new(0.5 * WIDTH, 0.0, SWING));
        casters.deform(self.caster, &Deformed { positions: &self.positions, offset: 0, stride: 12, min, max })
    }
}
