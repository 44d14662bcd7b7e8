//! A light as the stages see it, and where their indirect draws and counters lie: the twins of the structs in
//! `shaders/view.wgsl` and `shaders/depth.wgsl`.

use crate::batch::{Job, Shares};
use crate::light::{Coverage, PointLight};
use crate::paraboloid;
use glam::{Quat, Vec3};

/// Alignment of dynamic offsets that every device honours, and the size of what a buffer has of each job.
pub(crate) const SLOT: u64 = 256;

const _: () = assert!(size_of::<View>() as u64 == SLOT && size_of::<Arguments>() as u64 == SLOT);

/// The map of one hemisphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MapShape {
    /// Texels across.
    pub(crate) resolution: u32,
    /// Half the map's width in map coordinates, `1 + g`.
    pub(crate) half_width: f32,
    /// How far a chord may bend at a triangle's outline, in texels.
    pub(crate) tolerance: f32,
}

impl MapShape {
    /// `guard` in texels; small maps have a sixteenth of their width at most.
    pub(crate) fn new(resolution: u32, guard: f32, tolerance: f32) -> Self {
        let size = resolution as f32;
        let guard = guard.min(size / 16.0);
        let unbounded = Self { resolution, half_width: size / (size - 2.0 * guard), tolerance };
        Self { tolerance: tolerance.min(unbounded.longest_bend()), ..unbounded }
    }

    /// Bend of the longest edge that is ever drawn, in texels.
    fn longest_bend(&self) -> f32 {
        0.125 * self.texels() * paraboloid::LONGEST_EDGE * paraboloid::LONGEST_EDGE
    }

    /// Texels per unit of map coordinates.
    pub(crate) fn texels(&self) -> f32 {
        0.5 * self.resolution as f32 / self.half_width
    }

    /// How far depth that is interpolated over what is drawn may be off along a surface's normal, in texel footprints.
    pub(crate) fn depth_tolerance(&self) -> f32 {
        0.5 * self.tolerance
    }

    /// The angle in radians that edges may span which are drawn without being looked at: then they bend by no more than
    /// those of triangles that the route draws whole.
    pub(crate) fn angle_limit(&self) -> f32 {
        // An edge that touches the map ends this far out at most, where an angle takes up more of the map than at the rim.
        let r = self.half_width + paraboloid::LONGEST_EDGE;
        paraboloid::angle_limit(self.texels(), 0.375 * self.tolerance) / (0.5 + 0.5 * r * r)
    }

    /// Cosine of the angle behind which nothing can touch the map: a texel and a half outside, so that chords of
    /// what is drawn don't open the rim.
    fn behind(&self) -> f32 {
        let r = self.half_width + (1.5 + self.longest_bend()) / self.texels();
        ((1.0 - r * r) / (1.0 + r * r)).max(paraboloid::BEHIND)
    }
}

/// A job; twin of `View`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct View {
    right: Vec3,
    near: f32,
    up: Vec3,
    range: f32,
    forward: Vec3,
    texels: f32,
    position: Vec3,
    tolerance: f32,
    resolution: f32,
    behind: f32,
    hemispheres: u32,
    first_chunk: u32,
    end_chunk: u32,
    first_triangle: u32,
    list_capacity: u32,
    first_piece: u32,
    piece_capacity: u32,
    longest_bend: f32,
    kinds: u32,
    padding: [u32; 37],
}

/// Light space's axes in world space: the rows of the rotation from world to light space.
pub(crate) fn axes(orientation: Quat) -> [Vec3; 3] {
    [orientation * Vec3::X, orientation * Vec3::Y, orientation * Vec3::Z]
}

/// Bits of the hemispheres that a light has.
pub(crate) fn hemispheres(coverage: Coverage) -> u32 {
    match coverage {
        Coverage::Full => 3,
        Coverage::Hemisphere => 1,
    }
}

impl View {
    pub(crate) fn new(job: &Job, shape: &MapShape, shares: &Shares) -> Self {
        let Job { light, chunks, kinds, .. } = job;
        let [right, up, forward] = axes(light.orientation);
        Self {
            right,
            near: light.near,
            up,
            range: light.range,
            forward,
            texels: shape.texels(),
            position: light.position,
            tolerance: shape.tolerance,
            resolution: shape.resolution as f32,
            behind: shape.behind(),
            hemispheres: hemispheres(light.coverage),
            first_chunk: chunks.start,
            end_chunk: chunks.end,
            first_triangle: shares.first_triangle,
            list_capacity: shares.triangles,
            first_piece: shares.first_piece,
            piece_capacity: shares.pieces,
            longest_bend: shape.longest_bend(),
            kinds: *kinds,
            padding: [0; 37],
        }
    }
}

/// One hemisphere as the depth stage sees it; twin of `HemisphereView`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct HemisphereView {
    right: Vec3,
    near: f32,
    up: Vec3,
    scale: f32,
    forward: Vec3,
    padding_0: u32,
    origin: Vec3,
    padding_1: u32,
    light: Vec3,
    padding_2: u32,
}

impl HemisphereView {
    /// For vertices relative to `origin`: the light's position for those in world space, zero for pieces.
    pub(crate) fn new(light: &PointLight, shape: &MapShape, back: bool, origin: Vec3) -> Self {
        let [right, up, forward] = axes(light.orientation);
        let turn = if back { -1.0 } else { 1.0 };
        Self {
            right: right * turn,
            near: light.near,
            up,
            scale: 1.0 / shape.half_width,
            forward: forward * turn,
            padding_0: 0,
            origin,
            padding_1: 0,
            light: light.position,
            padding_2: 0,
        }
    }
}

/// Arguments of an indirect indexed draw.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct DrawIndexed {
    pub(crate) index_count: u32,
    pub(crate) instance_count: u32,
    pub(crate) first_index: u32,
    pub(crate) base_vertex: u32,
    pub(crate) first_instance: u32,
}

/// Arguments of an indirect draw.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Draw {
    pub(crate) vertex_count: u32,
    pub(crate) instance_count: u32,
    pub(crate) first_vertex: u32,
    pub(crate) first_instance: u32,
}

/// What the stages of one job count; twin of `Arguments`. Index 0 is the front, 1 the back.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Arguments {
    pub(crate) whole: [DrawIndexed; 2],
    pub(crate) pieces: [Draw; 2],
    pub(crate) exact: [Draw; 2],
    pub(crate) to_split: [u32; 2],
    pub(crate) pieces_wanted: [u32; 2],
    pub(crate) parts: [u32; 2],
    padding: [u32; 32],
}

impl Arguments {
    /// As they are before the first stage.
    pub(crate) fn new(shares: &Shares) -> Self {
        let first_index = |h: u32| 3 * (shares.first_triangle + shares.triangles * h);
        let first_vertex = |h: u32| 3 * (shares.first_piece + shares.pieces * h);
        let whole = |h| DrawIndexed { instance_count: 1, first_index: first_index(h), ..Default::default() };
        let pieces = |h| Draw { instance_count: 1, first_vertex: first_vertex(h), ..Default::default() };
        Self { whole: [0, 1].map(whole), pieces: [0, 1].map(pieces), ..bytemuck::Zeroable::zeroed() }
    }
}
