//! The lookups of all methods as text for a shader, and their biases.

use super::{cube_compute, cube_lookup, vertex_warp};
use serde::{Deserialize, Serialize};
use std::f32::consts::SQRT_2;
use std::fmt;

/// A shadow lookup in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Lookup {
    /// `dp_shadow`: four texels, and where they disagree, the triangles that they show.
    Paraboloid,
    /// `dp_shadow` without the triangles: four texels, each compared with the receiver's plane.
    Votes,
    /// `dp_shadow_filtered`: the light's own filter, without noise.
    Filtered,
    /// The hardware's comparison in a warped pair: four texels, one reference, a constant and a normal-offset bias.
    VertexWarp,
    /// [`Self::VertexWarp`] with the bias that Godot 4 ships for its omni lights, applied as Godot does: `shadow_bias`
    /// of 0.1 world units toward the light; `shadow_normal_bias` of 1, by which only the direction is turned toward the
    /// normal, ten texels' widths at most. Godot's wider filter is left out.
    VertexWarpShipped,
    /// The hardware's comparison in a cube: four texels, one reference, a constant and a normal-offset bias.
    CubeHardware,
    /// [`Self::CubeHardware`] with the bias that bevy 0.20 ships for its point lights: `shadow_depth_bias` of 0.08
    /// world units toward the light, `shadow_normal_bias` of 0.6 diagonals of a texel. Bevy's wider filter is left out.
    CubeShipped,
    /// In a cube: four texels, each compared with the receiver's plane and voting as [`Self::Votes`] do.
    CubePlane,
    /// [`Self::Paraboloid`] in a cube of this library's own making: four texels, and where they disagree, the same walks
    /// over the triangles that they show.
    CubeWalk,
}

impl Lookup {
    /// The name for reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Paraboloid => "paraboloid",
            Self::Votes => "votes",
            Self::Filtered => "filtered",
            Self::VertexWarp => "vertex-warp",
            Self::VertexWarpShipped => "vertex-warp-shipped",
            Self::CubeHardware => "cube-hardware",
            Self::CubeShipped => "cube-shipped",
            Self::CubePlane => "cube-plane",
            Self::CubeWalk => "cube-walk",
        }
    }

    /// WGSL to put beside a shader's own, reading the method's bind groups under the numbers from `group` on.
    #[must_use]
    pub fn text(self, group: u32) -> String {
        match self {
            Self::Paraboloid | Self::Filtered => crate::wgsl::lookup(group, group + 1),
            Self::Votes => crate::wgsl::lookup_votes(group),
            Self::VertexWarp | Self::VertexWarpShipped => vertex_warp::lookup_text(group),
            Self::CubeHardware | Self::CubeShipped | Self::CubePlane => cube_lookup::text(group, true),
            Self::CubeWalk => cube_compute::walk_text(group, true),
        }
    }

    /// [`Self::text`] for lights without an orientation: cubes then turn no directions, as engines' don't, and take less
    /// time. The others' text is the same.
    #[must_use]
    pub fn text_unturned(self, group: u32) -> String {
        match self {
            Self::CubeHardware | Self::CubeShipped | Self::CubePlane => cube_lookup::text(group, false),
            Self::CubeWalk => cube_compute::walk_text(group, false),
            _ => self.text(group),
        }
    }

    /// The WGSL expression for the share of the light that reaches `position`, on a surface of the geometric normal
    /// `normal`, both variables of type `vec3<f32>` in world space, over a `view` as `dp_shadow` takes it.
    #[must_use]
    pub fn expression(self) -> &'static str {
        match self {
            Self::Paraboloid | Self::Votes => "dp_shadow(0u, position, normal, view)",
            Self::Filtered => "dp_shadow_filtered(0u, position, normal, view, 0.0)",
            Self::VertexWarp => "warp_shadow(position, normal)",
            Self::VertexWarpShipped => "warp_shadow_shipped(position, normal)",
            Self::CubeHardware => "cube_shadow_hardware(position, normal)",
            Self::CubeShipped => "cube_shadow_shipped(position, normal)",
            Self::CubePlane => "cube_shadow_plane(position, normal)",
            Self::CubeWalk => "cube_shadow_walk(0u, position, normal, view)",
        }
    }

    /// Whether the answer is one over the pixel, and not that at its middle.
    #[must_use]
    pub fn takes_pixel(self) -> bool {
        matches!(self, Self::Paraboloid | Self::Filtered | Self::CubeWalk)
    }

    /// The bias that the lookup has until [`Baseline::set_bias`](super::Baseline::set_bias) gives it another; `None`
    /// for lookups whose bias is fixed. That of bevy's point lights for the hardware's comparisons, `dp_shadow`'s along the
    /// ray for planes.
    #[must_use]
    pub fn default_bias(self) -> Option<Bias> {
        match self {
            Self::VertexWarp => Some(Bias { depth: 0.08, ..Bias::default() }),
            Self::CubeHardware => Some(Bias { depth: 0.08, normal: 0.6 * SQRT_2, ..Bias::default() }),
            Self::CubePlane => Some(Bias { ray: 0.05, ..Bias::default() }),
            Self::Paraboloid
            | Self::Votes
            | Self::Filtered
            | Self::VertexWarpShipped
            | Self::CubeShipped
            | Self::CubeWalk => None,
        }
    }
}

/// How much nearer to the light a receiver counts than it is. Too little shows as acne, too much as peter-panning.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, Serialize)]
pub struct Bias {
    /// Toward the light, in world units, the same at every distance. [`Lookup::VertexWarp`] and
    /// [`Lookup::CubeHardware`] alone.
    pub depth: f32,
    /// Toward the light, in texel footprints at the receiver. [`Lookup::CubePlane`] alone.
    pub ray: f32,
    /// Along the normal, in texel footprints at the receiver.
    pub normal: f32,
}

impl fmt::Display for Bias {
    /// The parts that aren't 0.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let parts = [("depth", self.depth), ("ray", self.ray), ("normal", self.normal)];
        let parts: Vec<String> = parts
            .into_iter()
            .filter(|(_, part)| *part != 0.0)
            .map(|(name, part)| format!("{name} {part:.2e}"))
            .collect();
        f.pad(&if parts.is_empty() { "0".to_owned() } else { parts.join(", ") })
    }
}
