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
    /// The scene's instance that each of `placed` is, and its mesh's box.
    sources: Vec<Source>,
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

/// What an instance is placed from.
#[derive(Debug, Clone, Copy)]
struct Source {
    instance: usize,
    low: Vec3,
    high: Vec3,
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
        let drawn =
            scene.instances.iter().enumerate().filter_map(|(number, instance)| {
                Some((number, instance.mesh, instance.transform, boxes[instance.mesh]?))
            });
        let mut drawn: Vec<(Placed, Source)> = drawn
            .map(|(instance, mesh, transform, (low, high))| {
                (place(mesh, low, high, &transform), Source { instance, low, high })
            })
            .collect();
        drawn.sort_by_key(|(placed, _)| (placed.mirrored, placed.mesh));
        let (placed, sources): (Vec<Placed>, Vec<Source>) = drawn.into_iter().unzip();
        let rows: Vec<[[f32; 4]; 3]> =
            sources.iter().map(|source| rows(&scene.instances[source.instance].transform)).collect();
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let transforms = upload(device, "transforms", &rows, usage)?;
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
            sources,
            back_faces_culled,
        })
    }

    /// Moves all instances, given in the scene's order. None may be mirrored that wasn't, nor the other way round.
    ///
    /// # Panics
    /// If there are fewer transforms than instances.
    pub fn set_transforms(&mut self, queue: &wgpu::Queue, transforms: &[Affine3A]) {
        for (placed, source) in self.placed.iter_mut().zip(&self.sources) {
            placed.bounds = OrientedBox::new(source.low, source.high, &transforms[source.instance]);
        }
        let rows: Vec<[[f32; 4]; 3]> = self.sources.iter().map(|source| rows(&transforms[source.instance])).collect();
        queue.write_buffer(&self.transforms, 0, bytemuck::cast_slice(&rows));
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
