//! The lookups of all methods as text for a shader, and the bias of those that engines have.

use super::{cube_lookup, vertex_warp};
use serde::Serialize;

/// A shadow lookup in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Lookup {
    /// `dp_shadow`: four texels, each compared with the receiver's plane.
    Paraboloid,
    /// `dp_shadow_filtered`: the light's own filter, without noise.
    Filtered,
    /// The hardware's comparison in a warped pair: four texels, one reference, a constant bias.
    VertexWarp,
    /// The hardware's comparison in a cube: four texels, one reference, a constant and a normal-offset bias.
    CubeHardware,
    /// In a cube: four texels, each compared with the receiver's plane, with the bias of `dp_shadow`.
    CubePlane,
}

impl Lookup {
    /// The name for reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Paraboloid => "paraboloid",
            Self::Filtered => "filtered",
            Self::VertexWarp => "vertex-warp",
            Self::CubeHardware => "cube-hardware",
            Self::CubePlane => "cube-plane",
        }
    }

    /// WGSL to put beside a shader's own, reading the method's bind group under the number `group`.
    #[must_use]
    pub fn text(self, group: u32) -> String {
        match self {
            Self::Paraboloid | Self::Filtered => crate::wgsl::lookup(group),
            Self::VertexWarp => vertex_warp::lookup_text(group),
            Self::CubeHardware | Self::CubePlane => cube_lookup::text(group),
        }
    }

    /// The WGSL expression for the share of the light that reaches `position`, on a surface of the geometric normal
    /// `normal`; both are variables of type `vec3<f32>` in world space.
    #[must_use]
    pub fn expression(self) -> &'static str {
        match self {
            Self::Paraboloid => "dp_shadow(0u, position, normal)",
            Self::Filtered => "dp_shadow_filtered(0u, position, normal, 0.0)",
            Self::VertexWarp => "warp_shadow(position)",
            Self::CubeHardware => "cube_shadow_hardware(position, normal)",
            Self::CubePlane => "cube_shadow_plane(position, normal)",
        }
    }
}

/// The bias of the lookups that compare with one reference: what engines let their users tune.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstantBias {
    /// How far a receiver is moved toward the light, in world units. Too little shows as acne on surfaces that
    /// slope away from the light, too much as peter-panning.
    pub depth: f32,
    /// How far a receiver is moved along its normal, in diagonals of a texel's footprint. Cube lookup only.
    pub normal: f32,
}

impl Default for ConstantBias {
    /// The defaults of bevy's point lights.
    fn default() -> Self {
        Self { depth: 0.08, normal: 0.6 }
    }
}
