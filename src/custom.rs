//! Casters that the caller draws into the maps with pipelines of its own.

use crate::gpu;
use crate::light::PointLight;

/// A render pass over one hemisphere's map, for the caller to draw casters in: what
/// [`RecordOptions::draw`](crate::RecordOptions::draw) is called with, once for each hemisphere of each map that is made.
///
/// The viewport is set. A pipeline for it has
///
/// - in its vertex shader the text of [`wgsl::caster`](crate::wgsl::caster) and
///   `@invariant @builtin(position) position = dp_caster_position(world_position)`, in its fragment shader nothing, or
///   what discards,
/// - [`PointShadows::caster_bind_group_layout`](crate::PointShadows::caster_bind_group_layout) in the group of that text,
/// - [`CasterPass::depth_state`], and no colour target.
///
/// What is drawn isn't split, so the caller sees to it that
///
/// - no edge spans more than [`PointShadows::caster_angle_limit`](crate::PointShadows::caster_angle_limit) as seen from
///   the light. Longer ones miss their place, and the depth between their ends is off, in proportion to the square,
/// - triangles that share an edge share its ends to the bit, or there are cracks.
#[derive(Debug)]
pub struct CasterPass<'a> {
    /// What to draw with.
    pub pass: wgpu::RenderPass<'a>,
    /// The light, so that what is out of its range may be left out.
    pub light: PointLight,
    /// Whether this is the hemisphere around the light's -Z.
    pub back: bool,
    pub(crate) hemisphere: &'a wgpu::BindGroup,
    pub(crate) offset: u32,
}

impl CasterPass<'_> {
    /// Binds what the text of [`wgsl::caster`](crate::wgsl::caster) reads, under the same number.
    pub fn bind(&mut self, group: u32) {
        self.pass.set_bind_group(group, self.hemisphere, &[self.offset]);
    }

    /// The depth state of pipelines: format and comparison of the maps.
    #[must_use]
    pub fn depth_state() -> wgpu::DepthStencilState {
        gpu::depth_state()
    }
}
