//! Lookups that ask the triangles, in Rust: the twins of `shaders/exact.wgsl` in both precisions, over the casters' own
//! data.
//!
//! A map's texel knows the triangle under its centre. Where the texels around a receiver disagree, the lookup walks from
//! their triangles over the mesh towards the receiver's direction, and finds whether the surface that a texel saw stands
//! before the receiver. [`double`] is what [`ideal`](super::ideal) is for the votes: the rule without rounding.

mod ideal;
mod surface;
mod twins;

pub use ideal::IdealWalks;
pub use surface::Surface;
pub use twins::{double, single};

/// Triangles beyond the first that a walk looks at; `DP_WALK_STEPS`.
pub const STEPS: u32 = 16;

/// How far in front of the receiver a triangle has to stand to be in the way for certain, in footprints, and once more
/// times the grazing factor: `DP_WALK_OVER`, `DP_WALK_OVER_GRAZING`.
pub const OVER: (f64, f64) = (0.003, 1e-4);

/// What single precision loses: by so much of its coordinates a point may be off, and a third of what the arithmetic
/// loses of its distance; `DP_WALK_ROUNDING`.
pub const ROUNDING: f64 = 1.2e-7;

/// Up to so many footprints times the grazing factor before or behind the receiver's plane a texel holds the receiver's
/// own surface for certain; `DP_WALK_FLAT`.
pub const FLAT: f64 = 0.02;

/// Up to so many footprints times the grazing factor before or behind the receiver's plane a texel whose walk is lost speaks
/// for light; `DP_WALK_LEVEL`.
pub const LEVEL: f64 = 0.05;

#[cfg(test)]
mod tests;
