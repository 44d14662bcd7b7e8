//! A light as the stages see it: the twins of the structs in `shaders/view.wgsl` and `shaders/hemisphere.wgsl`.

use crate::batch::{Item, OVERFLOWS, TILE};
use crate::light::{Coverage, PointLight};
use crate::paraboloid;
use crate::wgsl;
use crate::workspace::Workspace;
use glam::{Quat, Vec3};

/// Alignment of dynamic offsets that every device honours, and the size of what a buffer has of each item.
pub(crate) const SLOT: u64 = 256;

/// How a light's maps, all of them squares, show what is around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Projection {
    /// Maps of a light; twin of `SQUARES`.
    pub(crate) squares: u32,
    /// How many of them lie side by side in a layer; twin of `square_origin`.
    pub(crate) squares_in_layer: u32,
    /// Its functions in WGSL.
    pub(crate) text: &'static str,
}

impl Projection {
    /// The library's own.
    pub(crate) const PARABOLOIDS: Self = Self { squares: 2, squares_in_layer: 2, text: wgsl::PARABOLOIDS };
}

/// One of a light's maps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MapShape {
    pub(crate) projection: Projection,
    /// Texels across.
    pub(crate) resolution: u32,
    /// Half the map's width in map coordinates, `1 + g`.
    pub(crate) half_width: f32,
}

/// How far a chord of casters that the caller draws may bend, in texels.
const CHORD_TOLERANCE: f32 = 0.1;

impl MapShape {
    /// `guard` in texels; small maps have a sixteenth of their width at most.
    pub(crate) fn new(resolution: u32, guard: f32) -> Self {
        let size = resolution as f32;
        let guard = guard.min(size / 16.0);
        Self { projection: Projection::PARABOLOIDS, resolution, half_width: size / (size - 2.0 * guard) }
    }

    /// Texels per unit of map coordinates.
    pub(crate) fn texels(&self) -> f32 {
        0.5 * self.resolution as f32 / self.half_width
    }

    /// Tiles across.
    pub(crate) fn tiles(&self) -> u32 {
        self.resolution.div_ceil(TILE)
    }

    /// Tiles of all of a light's maps.
    pub(crate) fn all_tiles(&self) -> u32 {
        self.projection.squares * self.tiles() * self.tiles()
    }

    /// Width, height and layers of the maps of so many lights.
    pub(crate) fn extent(&self, lights: u32) -> [u32; 3] {
        let Projection { squares, squares_in_layer, .. } = self.projection;
        [squares_in_layer * self.resolution, self.resolution, squares / squares_in_layer * lights]
    }

    /// How far depth that the hardware interpolates over the caller's casters may be off along a surface's normal, in texel
    /// footprints.
    pub(crate) fn chord_bias() -> f32 {
        0.5 * CHORD_TOLERANCE
    }

    /// The angle in radians that edges of the caller's casters may span.
    pub(crate) fn angle_limit(&self) -> f32 {
        // An edge that touches the map ends this far out at most, where an angle takes up more of the map than at the rim.
        let r = self.half_width + paraboloid::LONGEST_EDGE;
        paraboloid::angle_limit(self.texels(), 0.375 * CHORD_TOLERANCE) / (0.5 + 0.5 * r * r)
    }

    /// Cosine of the angle behind which nothing can touch the map: a texel outside.
    fn behind(&self) -> f32 {
        let r = self.half_width + 1.0 / self.texels();
        (1.0 - r * r) / (1.0 + r * r)
    }
}

/// A work item; twin of `View`.
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
    texel: f32,
    resolution: f32,
    behind: f32,
    hemispheres: u32,
    end_chunk: u32,
    kinds: u32,
    across: u32,
    first_tile: u32,
    first_record: u32,
    first_job: u32,
    first_bits: u32,
    record_capacity: u32,
    job_capacity: u32,
    first_winner: u32,
    winner_capacity: u32,
    counters: u32,
    tile_counters: u32,
    tile_lists: u32,
    left: u32,
    top: u32,
    layer: u32,
    flags: u32,
    padding: [u32; 27],
}

/// Light space's axes in world space: the rows of the rotation from world to light space.
pub(crate) fn axes(orientation: Quat) -> [Vec3; 3] {
    [orientation * Vec3::X, orientation * Vec3::Y, orientation * Vec3::Z]
}

/// Bits of the hemispheres that a light has; all bits for all directions, whatever the projection.
pub(crate) fn hemispheres(coverage: Coverage) -> u32 {
    match coverage {
        Coverage::Full => u32::MAX,
        Coverage::Hemisphere => 1,
    }
}

impl View {
    /// Of the item number `number` of a recording, which is number `place` of its batch.
    pub(crate) fn new(
        item: &Item,
        shape: &MapShape,
        workspace: &Workspace,
        chunks: u32,
        number: u32,
        place: u32,
    ) -> Self {
        let Item { light, layer, kinds, start } = item;
        let [right, up, forward] = axes(light.orientation);
        let share = workspace.share();
        Self {
            right,
            near: light.near,
            up,
            range: light.range,
            forward,
            texels: shape.texels(),
            position: light.position,
            texel: 1.0 / shape.texels(),
            resolution: shape.resolution as f32,
            behind: shape.behind(),
            hemispheres: hemispheres(light.coverage),
            end_chunk: chunks,
            kinds: *kinds,
            across: shape.tiles(),
            first_tile: place * share.tiles,
            first_record: place * share.records,
            first_job: place * share.jobs,
            first_bits: workspace.bits(place),
            record_capacity: share.records,
            job_capacity: share.jobs,
            first_winner: workspace.winners(place),
            winner_capacity: share.winners,
            counters: Workspace::counters(number),
            tile_counters: workspace.tile_counters(),
            tile_lists: workspace.tile_lists(),
            left: 0,
            top: 0,
            layer: *layer,
            flags: start | if share.overflows { OVERFLOWS } else { 0 },
            padding: [0; 27],
        }
    }
}

/// One hemisphere as the caller's casters are drawn in it; twin of `DpHemisphere`.
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
}

impl HemisphereView {
    pub(crate) fn new(light: &PointLight, shape: &MapShape, back: bool) -> Self {
        let [right, up, forward] = axes(light.orientation);
        let turn = if back { -1.0 } else { 1.0 };
        Self {
            right: right * turn,
            near: light.near,
            up,
            scale: 1.0 / shape.half_width,
            forward: forward * turn,
            padding_0: 0,
            origin: light.position,
            padding_1: 0,
        }
    }
}
