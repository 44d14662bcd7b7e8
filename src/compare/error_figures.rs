//! How wrong a map and its shadows are, against the ray-cast truth.
//!
//! Two families of figures: the [`map_error`](map_error()) of what the texels hold, and the
//! [`shadow_error`](shadow_error()) of what a renderer gets to see, at [`Receiver`]s drawn over the scene. Distances
//! that are given in texels are distances in map coordinates; the mapping is conformal, so a disc of directions is a
//! disc there.

mod filter_error;
mod map_error;
mod receivers;
mod shadow_error;

pub use filter_error::{FilterError, LIT, filter_error};
pub use map_error::{MapError, SURFACE_TOLERANCE, TexelVerdict, judge_texels, map_error};
pub(in crate::compare) use receivers::distance_to_triangle;
pub use receivers::{Receiver, ideal_shadows, sample_receivers, truth};
pub use shadow_error::shadow_error;
pub use shadow_error::{CREASE_DEPTH, FAR_TEXELS, ShadowError, ShadowReport, boundary_within, near_boundary};

/// `count` out of `total` in parts per million; 0 of nothing is 0.
pub(super) fn per_million(count: usize, total: usize) -> f64 {
    if total == 0 { 0.0 } else { 1e6 * count as f64 / total as f64 }
}
