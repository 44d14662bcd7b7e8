//! A scene's casters as engines hold them: meshes in their own space, and a transform for each instance.

use std::ops::Range;

use super::culling::OrientedBox;
use crate::Error;
use crate::compare::scene::{Scene, SceneMesh};
use crate::gpu::{self, Binding};
use glam::{Affine3A, Vec3};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// The vertices, indices and instances of a scene, for the baselines that draw instances. Instances are in order of
/// their meshes, so that neighbours in that order are drawn by one call.
#[derive(Debug)]
pub struct SceneBuffers {
    positions: wgpu::Buffer,
    indices: wgpu::Buffer,
    transforms: wgpu::Buffer,
    group: wgpu::BindGroup,
    meshes: Vec<MeshRange>,
    placed: Vec<Placed>,
    bounds: (Vec3, Vec3),
    back_faces_culled: bool,
}

/// Where a mesh lies in the buffers.
#[derive(Debug, Clone)]
struct MeshRange {
    indices: Range<u32>,
    base_vertex: i32,
}

/// An instance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    mesh: usize,
    /// Its transform turns the winding around.
    pub(super) mirrored: bool,
    pub(super) bounds: OrientedBox,
}

impl Placed {
    /// Whether one call can draw both.
    pub(super) fn joins(&self, other: &Self) -> bool {
        self.mesh == other.mesh && self.mirrored == other.mirrored
    }
}

impl SceneBuffers {
    /// Uploads a scene. With `back_faces_culled`, triangles cast only on their front sides, as with
    /// [`Sides::Front`](crate::Sides::Front); else on both.
    ///
    /// # Errors
    /// [`Error::CastersTooLarge`] if the device has no buffer that large.
    pub fn new(device: &wgpu::Device, scene: &Scene, back_faces_culled: bool) -> Result<Self, Error> {
        let (positions, indices, meshes) = join_meshes(&scene.meshes);
        let boxes: Vec<_> = scene.meshes.iter().map(mesh_bounds).collect();
        // Meshes without triangles have no box and are left out.
        let drawn = scene
            .instances
            .iter()
            .filter_map(|instance| Some((instance.mesh, instance.transform, boxes[instance.mesh]?)));
        let mut placed: Vec<(Placed, Affine3A)> =
            drawn.map(|(mesh, transform, (low, high))| (place(mesh, low, high, &transform), transform)).collect();
        placed.sort_by_key(|(placed, _)| (placed.mirrored, placed.mesh));
        let rows: Vec<[[f32; 4]; 3]> = placed.iter().map(|(_, transform)| rows(transform)).collect();
        let placed: Vec<Placed> = placed.into_iter().map(|(placed, _)| placed).collect();
        let transforms = upload(device, "transforms", &rows, wgpu::BufferUsages::STORAGE)?;
        let layout = Self::layout(device);
        let group = gpu::bind_group(device, "compare::scene", &layout, &[transforms.as_entire_binding()]);
        let bounds = placed.iter().map(|placed| placed.bounds.world_bounds());
        Ok(Self {
            positions: upload(device, "positions", &positions, wgpu::BufferUsages::VERTEX)?,
            indices: upload(device, "indices", &indices, wgpu::BufferUsages::INDEX)?,
            transforms,
            group,
            meshes,
            bounds: bounds.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or_default(),
            placed,
            back_faces_culled,
        })
    }

    /// Layout of the group that holds the transforms.
    pub(super) fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
        gpu::layout(device, "compare::scene", wgpu::ShaderStages::VERTEX, &[Binding::Read])
    }

    /// Whether triangles cast on their front sides only.
    #[must_use]
    pub fn back_faces_culled(&self) -> bool {
        self.back_faces_culled
    }

    /// Number of instances.
    #[must_use]
    pub fn instance_count(&self) -> usize {
        self.placed.len()
    }

    /// Lowest and highest corner, in world space, of a box around all instances.
    #[must_use]
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    /// Bytes on the GPU.
    #[must_use]
    pub fn memory(&self) -> u64 {
        self.positions.size() + self.indices.size() + self.transforms.size()
    }

    /// The instances, in the order in which they are drawn.
    pub(super) fn placed(&self) -> &[Placed] {
        &self.placed
    }

    /// Binds what all draws read.
    pub(super) fn bind(&self, pass: &mut wgpu::RenderPass) {
        pass.set_vertex_buffer(0, self.positions.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.set_bind_group(1, &self.group, &[]);
    }

    /// Draws the mesh of an instance once for each of `instances`, places in the bound list of instances.
    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass, like: &Placed, instances: Range<u32>) {
        let mesh = &self.meshes[like.mesh];
        pass.draw_indexed(mesh.indices.clone(), mesh.base_vertex, instances);
    }
}

/// All meshes' vertices and indices one after the other.
fn join_meshes(meshes: &[SceneMesh]) -> (Vec<[f32; 3]>, Vec<u32>, Vec<MeshRange>) {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    let ranges = meshes
        .iter()
        .map(|mesh| {
            let first = indices.len() as u32;
            let base_vertex = positions.len() as i32;
            positions.extend_from_slice(&mesh.positions);
            indices.extend_from_slice(&mesh.indices);
            MeshRange { indices: first..indices.len() as u32, base_vertex }
        })
        .collect();
    (positions, indices, ranges)
}

/// Bounds in mesh space of what is drawn, if anything is.
fn mesh_bounds(mesh: &SceneMesh) -> Option<(Vec3, Vec3)> {
    let corners = mesh.indices.iter().map(|&v| Vec3::from(mesh.positions[v as usize]));
    corners.map(|corner| (corner, corner)).reduce(|(low, high), (corner, _)| (low.min(corner), high.max(corner)))
}

fn place(mesh: usize, low: Vec3, high: Vec3, transform: &Affine3A) -> Placed {
    Placed { mesh, mirrored: transform.matrix3.determinant() < 0.0, bounds: OrientedBox::new(low, high, transform) }
}

/// Rows of the matrix, as the shader multiplies.
fn rows(transform: &Affine3A) -> [[f32; 4]; 3] {
    let (m, t) = (transform.matrix3, transform.translation);
    [0, 1, 2].map(|row| [m.x_axis[row], m.y_axis[row], m.z_axis[row], t[row]])
}

/// A buffer with contents, of at least one element: empty ones can't be bound.
fn upload<T: bytemuck::Pod>(
    device: &wgpu::Device,
    what: &'static str,
    elements: &[T],
    usage: wgpu::BufferUsages,
) -> Result<wgpu::Buffer, Error> {
    let nothing = [T::zeroed()];
    let elements = if elements.is_empty() { &nothing } else { elements };
    let (needed, limits) = (size_of_val(elements) as u64, device.limits());
    let is_bound = usage.contains(wgpu::BufferUsages::STORAGE);
    let limit = if is_bound { limits.max_storage_buffer_binding_size } else { u64::MAX }.min(limits.max_buffer_size);
    if needed > limit {
        return Err(Error::CastersTooLarge { what, needed, limit });
    }
    Ok(device.create_buffer_init(&BufferInitDescriptor {
        label: Some(&format!("dual_paraboloid::compare::scene::{what}")),
        contents: bytemuck::cast_slice(elements),
        usage,
    }))
}
