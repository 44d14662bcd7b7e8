//! The shadow casters: every triangle that may throw a shadow, in world space on the GPU.
//!
//! A mesh is cut into chunks once, when it is added. An instance of it owns a copy of the chunks' vertices in
//! world space; when it moves, its vertices and bounds are computed anew on the GPU, and only its own.

use crate::Error;
use crate::arena::{Arena, Written};
use crate::batch::Share;
use crate::chunks::{self, Bounds, Chunk, Culling, Vertex};
use crate::cone::Cone;
use crate::deform::{Deformed, Positions};
use crate::limits;
use crate::lookup::SurfaceGroup;
use crate::mask::{Mask, MaskedMesh, Masks};
use crate::mesh_records::MeshRecords;
use crate::ranges::Ranges;
use crate::recordings::{Recording, Recordings};
use crate::slots::{Handle, Slots};
use crate::transform::{Moved, Transform};
use crate::workspace;
use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use std::collections::VecDeque;

/// A list of triangles' corners.
#[derive(Debug, Clone, Copy)]
pub enum Indices<'a> {
    /// 16 bits an index.
    U16(&'a [u16]),
    /// 32 bits an index.
    U32(&'a [u32]),
}

impl Default for Indices<'_> {
    fn default() -> Self {
        Self::U32(&[])
    }
}

impl Indices<'_> {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::U16(list) => list.len(),
            Self::U32(list) => list.len(),
        }
    }

    pub(crate) fn get(&self, place: usize) -> u32 {
        match self {
            Self::U16(list) => u32::from(list[place]),
            Self::U32(list) => list[place],
        }
    }
}

/// Which sides of a mesh's triangles throw shadows. A front face is counter-clockwise as seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sides {
    /// Both. Closed connected pieces are found, and their back faces left out where that can't change the map:
    /// a front face is nearer to a light outside. Where a piece crosses itself they are kept.
    #[default]
    Auto,
    /// Both, without looking for closed pieces: adding the mesh takes less time.
    Both,
    /// Front faces only, as engines cull for single-sided materials. Back faces never throw shadows.
    Front,
}

/// A mesh to cast shadows, in its own space.
#[derive(Debug, Clone, Copy, Default)]
pub struct CasterMesh<'a> {
    /// Vertices; finite.
    pub positions: &'a [[f32; 3]],
    /// Triangle list: a multiple of three indices into `positions`.
    pub indices: Indices<'a>,
    /// Which sides cast.
    pub sides: Sides,
    /// Where it has holes, if it has any.
    pub mask: Option<Mask<'a>>,
    /// Whether instances take positions that the caller writes on the GPU, see [`Casters::deform`]; until they are
    /// given some, they have those above. With [`Sides::Auto`] no closed pieces are looked for then.
    pub deforms: bool,
}

/// Handle of a mesh in the [`Casters`] that gave it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct MeshId(Handle);

/// Handle of an instance in the [`Casters`] that gave it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct InstanceId(Handle);

#[derive(Debug)]
struct Mesh {
    first_vertex: u32,
    vertex_count: u32,
    first_triangle: u32,
    triangle_count: u32,
    /// The first of its triangles among the mesh records.
    first_record: u32,
    chunks: Vec<Chunk>,
    bounds: Bounds,
    instances: usize,
    mask: Option<MaskedMesh>,
    /// Of meshes that deform: how many positions a deformed instance has.
    positions: Option<u64>,
}

impl Mesh {
    /// Kind of the chunks of an instance that is marked as moving or not.
    fn kind(&self, moving: bool) -> u32 {
        u32::from(moving) * KIND_MOVING + u32::from(self.mask.is_some()) * KIND_MASKED
    }
}

#[derive(Debug)]
struct Instance {
    mesh: Handle,
    first_vertex: u32,
    first_chunk: u32,
    transform: Affine3A,
    bounds: Bounds,
    /// Once it is deformed, its own bounds in the mesh's space.
    deformed: Option<(Positions, Bounds)>,
    /// Its vertices in world space aren't up to date.
    moved: bool,
    /// Marked by [`Casters::set_moving`].
    moving: bool,
}

/// A chunk of an instance as the shaders read it: where its data lies.
/// Twin of `ChunkSource` in `shaders/casters.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct ChunkSource {
    /// First vertex of the chunk in the mesh's own space.
    pub(crate) local_vertex: u32,
    /// First vertex in world space.
    pub(crate) vertex: u32,
    pub(crate) triangle: u32,
    /// Vertices in bits 0-8, triangles in bits 9-17, culling in bits 18-19, kind in bits 20-21.
    pub(crate) counts: u32,
    pub(crate) pieces_min: Vec3,
    /// The first of its triangles among the mesh records.
    pub(crate) record: u32,
    pub(crate) pieces_max: Vec3,
    pub(crate) normals: Cone,
}

/// Bit of a chunk's kind, by which jobs leave chunks out: its instance is marked as moving.
const KIND_MOVING: u32 = 1;

/// The same: its mesh has holes.
const KIND_MASKED: u32 = 2;

/// Chunks that there are numbers for: a triangle's number, with one added, has 29 bits beside that of its map
/// (`SQUARE_SHIFT` in `shaders/view.wgsl`), and 8 of them are its place in the chunk.
const MOST_CHUNKS: u64 = (1 << 21) - 1;

/// What moved, came or went.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Change {
    /// Bounds before and after, empty where there was nothing.
    before: Bounds,
    after: Bounds,
    /// Around both.
    around: Bounds,
    /// Of a caster that is marked as moving.
    pub(crate) moving: bool,
}

impl Change {
    fn new(before: Bounds, after: Bounds, moving: bool) -> Self {
        Self { before, after, around: before.union(after), moving }
    }

    /// Whether it may be seen within `radius` of `centre`.
    pub(crate) fn touches_sphere(&self, centre: Vec3, radius: f32) -> bool {
        // What moves goes a little way in a frame, so that one test does for most.
        self.around.touches_sphere(centre, radius)
            && (self.before.touches_sphere(centre, radius) || self.after.touches_sphere(centre, radius))
    }
}

/// What an update did: all that it takes to do it again.
#[derive(Debug)]
struct Update {
    /// Of the arenas, in the order of [`Casters::arenas_mut`].
    written: [Written; 6],
    textures: Vec<wgpu::Texture>,
    moved: Vec<Handle>,
}

/// Changes remembered for lights that haven't seen them yet; past that, every light counts as touched.
const REMEMBERED_CHANGES: usize = 1 << 16;

/// Bytes of a vertex, in the mesh's space or the world's; the first twelve are the position.
pub(crate) const VERTEX_SIZE: u64 = size_of::<Vertex>() as u64;

/// Bytes of `ChunkBounds` in `shaders/casters.wgsl`.
const CHUNK_BOUNDS_SIZE: u64 = 96;

/// The shadow casters of a scene. Shared by any number of [`PointShadows`](crate::PointShadows).
///
/// Adding, moving and removing only notes what to do; the next
/// [`PointShadows::record`](crate::PointShadows::record) does it on the GPU.
#[derive(Debug)]
pub struct Casters {
    meshes: Slots<Mesh>,
    instances: Slots<Instance>,
    local_ranges: Ranges,
    triangle_ranges: Ranges,
    vertex_ranges: Ranges,
    chunk_ranges: Ranges,
    /// Triangles of all instances, by the kind of their chunks.
    triangles_by_kind: [u64; 4],
    moved: Vec<Handle>,
    changes: VecDeque<Change>,
    first_change: u64,
    pub(crate) local_vertices: Arena,
    pub(crate) triangles: Arena,
    pub(crate) records: MeshRecords,
    pub(crate) vertices: Arena,
    pub(crate) chunk_sources: Arena,
    pub(crate) chunk_bounds: Arena,
    masks: Masks,
    transform: Transform,
    /// Counts the updates from 1 on. Each chunk has the number of the one that brought or moved it, 0 once it is gone.
    updates: u32,
    /// Updates that may have to be done again.
    recordings: Recordings<Update>,
    surface: SurfaceGroup,
    limits: wgpu::Limits,
}

impl Casters {
    /// Creates an empty store. Its buffers grow as casters come and shrink as they go.
    ///
    /// # Errors
    /// [`Error::LimitTooLow`] if the device has less than [`required_limits`](crate::required_limits).
    pub fn new(device: &wgpu::Device) -> Result<Self, Error> {
        limits::check(&device.limits())?;
        let storage = wgpu::BufferUsages::STORAGE;
        let arena = |what, stride, extra| Arena::new(device, what, stride, storage | extra);
        let records = MeshRecords::new(device);
        let vertices = arena("vertices", VERTEX_SIZE, wgpu::BufferUsages::VERTEX);
        let chunk_bounds = arena("chunk bounds", CHUNK_BOUNDS_SIZE, wgpu::BufferUsages::empty());
        let surface = SurfaceGroup::new(device, [&chunk_bounds, records.arena(), &vertices]);
        Ok(Self {
            meshes: Slots::new("mesh", "Casters"),
            instances: Slots::new("instance", "Casters"),
            local_ranges: Ranges::default(),
            triangle_ranges: Ranges::default(),
            vertex_ranges: Ranges::default(),
            chunk_ranges: Ranges::default(),
            triangles_by_kind: [0; 4],
            moved: Vec::new(),
            changes: VecDeque::new(),
            first_change: 0,
            local_vertices: arena("mesh vertices", VERTEX_SIZE, wgpu::BufferUsages::empty()),
            triangles: arena("triangles", 4, wgpu::BufferUsages::empty()),
            records,
            vertices,
            chunk_sources: arena("chunks", size_of::<ChunkSource>() as u64, wgpu::BufferUsages::empty()),
            chunk_bounds,
            masks: Masks::default(),
            transform: Transform::new(device),
            updates: 0,
            recordings: Recordings::default(),
            surface,
            limits: device.limits(),
        })
    }

    /// Triangles of all instances together, without those of no area.
    #[must_use]
    pub fn triangle_count(&self) -> u64 {
        self.triangles_by_kind.iter().sum()
    }

    /// Triangles of the kinds of chunks that `kinds` has the bits of.
    pub(crate) fn triangles_of(&self, kinds: u32) -> u64 {
        let of = |kind: usize| if kinds & (1 << kind) == 0 { 0 } else { self.triangles_by_kind[kind] };
        (0..self.triangles_by_kind.len()).map(of).sum()
    }

    /// Bytes that the casters take on the GPU. A buffer that has grown or shrunk counts twice until it is known that the
    /// recording that replaced it was submitted and is done, which the next one finds out.
    #[must_use]
    pub fn memory(&self) -> u64 {
        let replaced = self.recordings.unconfirmed().flat_map(|update| &update.written).map(Written::replaced_size);
        self.arenas().map(Arena::size).into_iter().sum::<u64>() + replaced.sum::<u64>()
    }

    fn arenas(&self) -> [&Arena; 6] {
        let Self { local_vertices, triangles, records, vertices, chunk_sources, chunk_bounds, .. } = self;
        [local_vertices, triangles, records.arena(), vertices, chunk_sources, chunk_bounds]
    }

    fn arenas_mut(&mut self) -> [&mut Arena; 6] {
        let Self { local_vertices, triangles, records, vertices, chunk_sources, chunk_bounds, .. } = self;
        [local_vertices, triangles, records.arena_mut(), vertices, chunk_sources, chunk_bounds]
    }

    /// Layout of [`Self::bind_group`], for the pipeline layouts of passes that look shadows up. Three storage buffers. The
    /// layouts of all stores of a device are alike.
    #[must_use]
    pub fn bind_group_layout(&self) -> &wgpu::BindGroupLayout {
        self.surface.layout()
    }

    /// The triangles, as the text of [`wgsl::lookup`](crate::wgsl::lookup) reads them, for all
    /// [`PointShadows`](crate::PointShadows) that show them. To be asked for after each
    /// [`PointShadows::record`](crate::PointShadows::record): it is another one when the store has grown or shrunk.
    #[must_use]
    pub fn bind_group(&self) -> &wgpu::BindGroup {
        self.surface.bind_group()
    }

    /// Adds a mesh; it casts once it has instances. Takes time in proportion to its triangles: they are welded by
    /// exact position, with a mask by texture coordinates too, and cut into chunks, and with [`Sides::Auto`] closed
    /// pieces are looked for. Triangles of no area are left out. A mesh that deforms keeps all its vertices.
    ///
    /// # Errors
    /// [`Error::EmptyMesh`], [`Error::IndexCount`], [`Error::IndexOutOfRange`] or [`Error::PositionNotFinite`] for
    /// wrong input, [`Error::TextureCoordinateCount`], [`Error::TextureCoordinateNotFinite`] or [`Error::InvalidMask`]
    /// for a wrong mask, [`Error::CastersTooLarge`] if the device can't bind that much.
    pub fn add_mesh(&mut self, mesh: &CasterMesh) -> Result<MeshId, Error> {
        validate(mesh)?;
        let mut cut = chunks::cut(mesh);
        let (vertices, triangles) = (cut.vertices.len() as u32, cut.triangles.len() as u32);
        self.local_vertices.check(self.local_ranges.end_after(vertices))?;
        self.triangles.check(self.triangle_ranges.end_after(triangles))?;
        let masked = mesh.mask.as_ref().map_or(0, |mask| self.masks.records(mask, vertices));
        self.records.check(u64::from(triangles) + masked)?;
        let first_record = self.records.add(&cut.records);
        let mask = mesh.mask.as_ref();
        let mask =
            mask.map(|mask| self.masks.add(&mut self.records, mask, &cut.texture_coordinates, &mut cut.vertices));
        let first_vertex = self.local_ranges.allocate(vertices);
        let first_triangle = self.triangle_ranges.allocate(triangles);
        self.local_vertices.write(first_vertex, bytemuck::cast_slice(&cut.vertices));
        self.triangles.write(first_triangle, bytemuck::cast_slice(&cut.triangles));
        let mesh = Mesh {
            first_vertex,
            vertex_count: vertices,
            first_triangle,
            triangle_count: triangles,
            first_record,
            chunks: cut.chunks,
            bounds: cut.bounds,
            instances: 0,
            mask,
            positions: mesh.deforms.then_some(mesh.positions.len() as u64),
        };
        Ok(MeshId(self.meshes.insert(mesh)))
    }

    /// Removes a mesh that no instance uses any more.
    ///
    /// # Errors
    /// [`Error::StaleHandle`], or [`Error::MeshInUse`] while it has instances.
    pub fn remove_mesh(&mut self, id: MeshId) -> Result<(), Error> {
        let mesh = self.meshes.get_mut(id.0)?;
        if mesh.instances > 0 {
            return Err(Error::MeshInUse { instances: mesh.instances });
        }
        self.local_ranges.release(mesh.first_vertex, mesh.vertex_count);
        self.triangle_ranges.release(mesh.first_triangle, mesh.triangle_count);
        self.records.release(mesh.first_record, mesh.triangle_count);
        if let Some(mask) = &mesh.mask {
            self.masks.remove(&mut self.records, mask);
        }
        self.meshes.remove(id.0)?;
        Ok(())
    }

    /// Adds an instance of a mesh; `transform` takes the mesh's space to world space and may mirror, shear and
    /// scale differently by axis.
    ///
    /// # Errors
    /// [`Error::StaleHandle`], [`Error::TransformNotFinite`], [`Error::CastersTooLarge`] if the device can't
    /// bind that much, or [`Error::TooManyChunks`].
    pub fn add_instance(&mut self, mesh: MeshId, transform: Affine3A) -> Result<InstanceId, Error> {
        let entry = self.meshes.get_mut(mesh.0)?;
        let bounds = transformed(&entry.bounds, &transform)?;
        let chunk_count = entry.chunks.len() as u32;
        self.vertices.check(self.vertex_ranges.end_after(entry.vertex_count))?;
        self.chunk_bounds.check(self.chunk_ranges.end_after(chunk_count))?;
        check_chunks(self.chunk_ranges.end_after(chunk_count), &self.limits)?;
        entry.instances += 1;
        let first_vertex = self.vertex_ranges.allocate(entry.vertex_count);
        let first_chunk = self.chunk_ranges.allocate(chunk_count);
        self.triangles_by_kind[entry.kind(false) as usize] += u64::from(entry.triangle_count);
        let instance = Instance {
            mesh: mesh.0,
            first_vertex,
            first_chunk,
            transform,
            bounds,
            deformed: None,
            moved: true,
            moving: false,
        };
        let handle = self.instances.insert(instance);
        self.write_chunk_sources(handle)?;
        self.moved.push(handle);
        self.note(Change::new(Bounds::EMPTY, bounds, false));
        Ok(InstanceId(handle))
    }

    /// Says whether an instance moves often. It makes no difference to the maps: with
    /// [`keep_static`](crate::PointShadowsDescriptor::keep_static), what is not marked as moving is drawn once and
    /// kept, so that a marked caster that moves costs little, and another one that moves all that is near. Instances
    /// aren't marked when they are added.
    ///
    /// # Errors
    /// [`Error::StaleHandle`].
    pub fn set_moving(&mut self, id: InstanceId, moving: bool) -> Result<(), Error> {
        let instance = self.instances.get_mut(id.0)?;
        if std::mem::replace(&mut instance.moving, moving) == moving {
            return Ok(());
        }
        let bounds = instance.bounds;
        let mesh = self.meshes.get(instance.mesh)?;
        let triangles = u64::from(mesh.triangle_count);
        self.triangles_by_kind[mesh.kind(!moving) as usize] -= triangles;
        self.triangles_by_kind[mesh.kind(moving) as usize] += triangles;
        self.write_chunk_sources(id.0)?;
        self.note(Change::new(bounds, bounds, false));
        Ok(())
    }

    /// Says that casters that the caller draws, see [`CasterPass`](crate::CasterPass), have changed somewhere within a box
    /// of world space, so that the lights that reach it are made anew. They count as moving ones. The box may be infinite.
    ///
    /// # Errors
    /// [`Error::InvalidBox`] unless `min` is at most `max` on every axis.
    pub fn touch(&mut self, min: Vec3, max: Vec3) -> Result<(), Error> {
        if !min.cmple(max).all() {
            return Err(Error::InvalidBox { min: min.to_array(), max: max.to_array() });
        }
        self.note(Change::new(Bounds::EMPTY, Bounds { min, max }, true));
        Ok(())
    }

    /// Writes where the chunks of an instance have their data.
    fn write_chunk_sources(&mut self, id: Handle) -> Result<(), Error> {
        let instance = self.instances.get(id)?;
        let mesh = self.meshes.get(instance.mesh)?;
        let sources: Vec<ChunkSource> = mesh.chunks.iter().map(|chunk| chunk_source(mesh, chunk, instance)).collect();
        self.chunk_sources.write(instance.first_chunk, bytemuck::cast_slice(&sources));
        Ok(())
    }

    /// Moves an instance.
    ///
    /// # Errors
    /// [`Error::StaleHandle`] or [`Error::TransformNotFinite`].
    pub fn set_transform(&mut self, id: InstanceId, transform: Affine3A) -> Result<(), Error> {
        let instance = self.instances.get_mut(id.0)?;
        let mesh = self.meshes.get_mut(instance.mesh)?;
        let local = instance.deformed.as_ref().map_or(&mesh.bounds, |(_, bounds)| bounds);
        let bounds = transformed(local, &transform)?;
        instance.transform = transform;
        self.moved(id, bounds)
    }

    /// Says that an instance of a mesh that [`deforms`](CasterMesh::deforms) has other positions: to be called whenever
    /// they have changed. They are read in the next [`PointShadows::record`](crate::PointShadows::record), in its
    /// encoder, so a pass that writes them has to be recorded or submitted before.
    ///
    /// # Errors
    /// [`Error::StaleHandle`], [`Error::InvalidDeformed`], [`Error::TransformNotFinite`] if the instance's transform
    /// takes the bounds out of the range of `f32`, [`Error::CastersTooLarge`] if the device can't bind that much.
    pub fn deform(&mut self, id: InstanceId, deformed: &Deformed) -> Result<(), Error> {
        let instance = self.instances.get_mut(id.0)?;
        let Some(count) = self.meshes.get(instance.mesh)?.positions else {
            let remedy = "add the mesh with `deforms`".to_owned();
            return Err(Error::InvalidDeformed { what: "mesh", value: "one that doesn't deform".to_owned(), remedy });
        };
        deformed.validate(count, &self.limits)?;
        let bounds = transformed(&deformed.bounds(), &instance.transform)?;
        instance.deformed = Some((Positions::new(deformed, count), deformed.bounds()));
        self.moved(id, bounds)
    }

    /// Notes that an instance is where it wasn't.
    fn moved(&mut self, id: InstanceId, bounds: Bounds) -> Result<(), Error> {
        let instance = self.instances.get_mut(id.0)?;
        let before = std::mem::replace(&mut instance.bounds, bounds);
        let moving = instance.moving;
        if !std::mem::replace(&mut instance.moved, true) {
            self.moved.push(id.0);
        }
        self.note(Change::new(before, bounds, moving));
        Ok(())
    }

    /// Removes an instance.
    ///
    /// # Errors
    /// [`Error::StaleHandle`].
    pub fn remove_instance(&mut self, id: InstanceId) -> Result<(), Error> {
        let instance = self.instances.get_mut(id.0)?;
        let Instance { first_vertex, first_chunk, bounds, moving, .. } = *instance;
        let mesh = self.meshes.get_mut(instance.mesh)?;
        let chunk_count = mesh.chunks.len() as u32;
        mesh.instances -= 1;
        self.triangles_by_kind[mesh.kind(moving) as usize] -= u64::from(mesh.triangle_count);
        self.vertex_ranges.release(first_vertex, mesh.vertex_count);
        self.chunk_ranges.release(first_chunk, chunk_count);
        let none: ChunkSource = bytemuck::Zeroable::zeroed();
        self.chunk_sources.write(first_chunk, bytemuck::cast_slice(&vec![none; chunk_count as usize]));
        // Maps that still show them have to find them gone.
        self.chunk_bounds.write(first_chunk, &vec![0; (CHUNK_BOUNDS_SIZE * u64::from(chunk_count)) as usize]);
        self.instances.remove(id.0)?;
        self.note(Change::new(bounds, Bounds::EMPTY, moving));
        Ok(())
    }

    fn note(&mut self, change: Change) {
        if self.changes.len() == REMEMBERED_CHANGES {
            self.first_change += 1;
            self.changes.pop_front();
        }
        self.changes.push_back(change);
    }

    /// Number of changes since the store was made.
    pub(crate) fn change_count(&self) -> u64 {
        self.first_change + self.changes.len() as u64
    }

    /// The changes after the first `seen`, or `None` if they aren't remembered any more.
    pub(crate) fn changes_since(&self, seen: u64) -> Option<impl Iterator<Item = &Change>> {
        let skip = seen.checked_sub(self.first_change)?;
        Some(self.changes.range(usize::try_from(skip).ok()?..))
    }

    /// Identifies this store among all.
    pub(crate) fn owner(&self) -> u32 {
        self.instances.owner()
    }

    /// Chunks in the store, unused ones between used ones included.
    pub(crate) fn chunk_count(&self) -> u32 {
        self.chunk_ranges.end()
    }

    /// Changes whenever a buffer was replaced, so that bind groups have to be made anew.
    pub(crate) fn generation(&self) -> u64 {
        self.arenas().map(Arena::generation).into_iter().sum()
    }

    /// Number of the last update, by which chunks say when they changed.
    pub(crate) fn updates(&self) -> u32 {
        self.updates
    }

    /// Brings the GPU's copy up to date: grows or shrinks buffers, writes what was added, transforms what moved. Does again
    /// what never happened, since its encoder was thrown away.
    pub(crate) fn update(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Recording {
        self.redo_lost();
        self.updates = self.updates.saturating_add(1);
        let (local, triangles) = (self.local_ranges.end(), self.triangle_ranges.end());
        let (vertices, chunks) = (self.vertex_ranges.end(), self.chunk_ranges.end());
        let written = [
            self.local_vertices.update(device, queue, encoder, local),
            self.triangles.update(device, queue, encoder, triangles),
            self.records.update(device, queue, encoder),
            self.vertices.update(device, queue, encoder, vertices),
            self.chunk_sources.update(device, queue, encoder, chunks),
            self.chunk_bounds.update(device, queue, encoder, chunks),
        ];
        let textures = self.masks.update(device, encoder, &self.records);
        self.surface.update(device, [&self.chunk_bounds, self.records.arena(), &self.vertices]);
        let handles = std::mem::take(&mut self.moved);
        let (moved, deformed) = self.gather(&handles);
        let arenas = [&self.local_vertices, &self.vertices, &self.chunk_sources, &self.chunk_bounds];
        let buffers = arenas.map(Arena::buffer);
        if moved.count() > 0 {
            self.transform.record(device, queue, encoder, buffers, &moved);
        }
        let records = self.records.arena().buffer();
        for (positions, moved) in deformed {
            self.transform.record_deformed(device, queue, encoder, buffers, &moved, &positions, records);
        }
        self.recordings.begin(encoder, Update { written, textures, moved: handles })
    }

    /// Has the next update do again what never happened.
    fn redo_lost(&mut self) {
        let lost = self.recordings.take_lost();
        let mut written: [Vec<Written>; 6] = Default::default();
        for update in lost {
            written.iter_mut().zip(update.written).for_each(|(list, own)| list.push(own));
            self.masks.redo(update.textures);
            for handle in update.moved {
                if let Ok(instance) = self.instances.get_mut(handle)
                    && !std::mem::replace(&mut instance.moved, true)
                {
                    self.moved.push(handle);
                }
            }
        }
        self.arenas_mut().into_iter().zip(written).for_each(|(arena, written)| arena.redo(written.into_iter()));
    }

    /// What has to be transformed: with their meshes' positions, and each deformed instance.
    fn gather(&mut self, handles: &[Handle]) -> (Moved, Vec<(Positions, Moved)>) {
        let (mut moved, mut deformed) = (Moved::new(self.updates), Vec::new());
        for &handle in handles {
            let Ok(instance) = self.instances.get_mut(handle) else {
                continue;
            };
            instance.moved = false;
            let first = instance.first_chunk;
            let Ok(mesh) = self.meshes.get(instance.mesh) else {
                continue;
            };
            let chunks = first..first + mesh.chunks.len() as u32;
            let transform = rows(&instance.transform);
            match &instance.deformed {
                Some((positions, _)) => {
                    let mut own = Moved::new(self.updates);
                    own.push(chunks, transform);
                    deformed.push((positions.clone(), own));
                }
                None => moved.push(chunks, transform),
            }
        }
        (moved, deformed)
    }
}

/// Whether there may be so many chunks: whether they have numbers, and the device can bind their bits for a light.
fn check_chunks(count: u64, limits: &wgpu::Limits) -> Result<(), Error> {
    if count > MOST_CHUNKS {
        return Err(Error::TooManyChunks { needed: count, limit: MOST_CHUNKS });
    }
    let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    let needed = Share::bits_bytes(count) + workspace::COUNTERS_ROOM;
    if needed > limit {
        return Err(Error::CastersTooLarge { what: "chunks' bits", needed, limit });
    }
    Ok(())
}

fn validate(mesh: &CasterMesh) -> Result<(), Error> {
    let (positions, indices) = (mesh.positions.len(), mesh.indices.len());
    if positions == 0 || indices == 0 {
        return Err(Error::EmptyMesh { positions, indices });
    }
    if indices % 3 != 0 {
        return Err(Error::IndexCount { count: indices });
    }
    for place in 0..indices {
        let index = mesh.indices.get(place);
        if index as usize >= positions {
            return Err(Error::IndexOutOfRange { index, place, positions });
        }
    }
    match mesh.positions.iter().position(|p| !Vec3::from(*p).is_finite()) {
        Some(vertex) => Err(Error::PositionNotFinite { vertex, value: mesh.positions[vertex] }),
        None => mesh.mask.map_or(Ok(()), |mask| mask.validate(positions)),
    }
}

fn chunk_source(mesh: &Mesh, chunk: &Chunk, instance: &Instance) -> ChunkSource {
    let culling = match chunk.culling {
        Culling::None => 0,
        Culling::Closed => 1,
        Culling::Always => 2,
    };
    let pieces =
        if chunk.culling == Culling::Closed { chunk.pieces } else { Bounds { min: Vec3::ZERO, max: Vec3::ZERO } };
    let kind = mesh.kind(instance.moving);
    ChunkSource {
        local_vertex: mesh.first_vertex + chunk.first_vertex,
        vertex: instance.first_vertex + chunk.first_vertex,
        triangle: mesh.first_triangle + chunk.first_triangle,
        counts: chunk.vertex_count | chunk.triangle_count << 9 | culling << 18 | kind << 20,
        pieces_min: pieces.min,
        record: mesh.first_record + chunk.first_triangle,
        pieces_max: pieces.max,
        normals: chunk.normals,
    }
}

/// Rows of the matrix, as the shader multiplies.
fn rows(transform: &Affine3A) -> [[f32; 4]; 3] {
    let (m, t) = (transform.matrix3, transform.translation);
    [0, 1, 2].map(|row| [m.x_axis[row], m.y_axis[row], m.z_axis[row], t[row]])
}

/// Bounds of a transformed box, a little wider than exact to cover rounding.
fn transformed(bounds: &Bounds, transform: &Affine3A) -> Result<Bounds, Error> {
    let error = || Error::TransformNotFinite { value: format!("{:?}", rows(transform)) };
    if !transform.is_finite() {
        return Err(error());
    }
    if bounds.min.x > bounds.max.x {
        return Ok(*bounds);
    }
    let (matrix, size) = (
        transform.matrix3,
        Mat3A::from_cols(
            transform.matrix3.x_axis.abs(),
            transform.matrix3.y_axis.abs(),
            transform.matrix3.z_axis.abs(),
        ),
    );
    let half = Vec3A::from(0.5 * bounds.max - 0.5 * bounds.min);
    let middle = Vec3A::from(0.5 * bounds.max + 0.5 * bounds.min);
    let centre = matrix * middle + transform.translation;
    // Rounding is in proportion to what is summed, which may cancel in the sum.
    let slack = 1e-5 * (size * (middle.abs() + half) + transform.translation.abs());
    let reach = size * half + slack;
    let result = Bounds { min: (centre - reach).into(), max: (centre + reach).into() };
    if result.min.is_finite() && result.max.is_finite() { Ok(result) } else { Err(error()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_chunk_has_numbers_and_bits() {
        // A triangle's number with one added, and that of the map above it.
        assert!(crate::wgsl::cull(crate::view::Projection::PARABOLOIDS).contains("const SQUARE_SHIFT: u32 = 29u;"));
        let number = |chunk: u64| (chunk << 8 | 255) + 1;
        assert!(number(MOST_CHUNKS - 1) < 1 << 29 && number(MOST_CHUNKS) >= 1 << 29);
        let roomy =
            wgpu::Limits { max_storage_buffer_binding_size: 1 << 31, max_buffer_size: 1 << 31, ..Default::default() };
        assert_eq!(check_chunks(MOST_CHUNKS, &roomy), Ok(()));
        let too_many = Error::TooManyChunks { needed: MOST_CHUNKS + 1, limit: MOST_CHUNKS };
        assert_eq!(check_chunks(MOST_CHUNKS + 1, &roomy), Err(too_many));
        // 152 bytes each, and two mebibytes for counters.
        let most = ((128 << 20) - (2 << 20)) / 152;
        assert_eq!(check_chunks(most, &crate::required_limits()), Ok(()));
        let too_many = check_chunks(most + 1, &crate::required_limits());
        assert!(matches!(too_many, Err(Error::CastersTooLarge { what: "chunks' bits", .. })), "{too_many:?}");
    }
}
