//! How wrong a map and its shadows are, against the ray-cast truth.
//!
//! Three families of figures: the [`map_error`](map_error()) of what the texels hold, the
//! [`shadow_error`](shadow_error()) of what a renderer gets to see, at [`Receiver`]s drawn over the scene, and the
//! [`crease_error`] where two lit faces meet. Distances that are given in texels are distances in map coordinates; the
//! mapping is conformal, so a disc of directions is a disc there.

mod creases;
mod filter_error;
mod map_error;
mod receivers;
mod shadow_error;

pub use creases::{CREASE_ANGLE, CREASE_TEXELS, CreaseError, DARK_CREASE, crease_error, lit_creases};
pub use filter_error::{FilterError, LIT, filter_error};
pub use map_error::{MapError, SURFACE_TOLERANCE, TexelVerdict, judge_texels, map_error};
pub(in crate::compare) use receivers::distance_to_triangle;
pub(super) use receivers::is_lit;
pub use receivers::{GRAZING, Receiver, SAMPLES, sample_receivers, truth};
pub use shadow_error::{BOUNDARY_DEPTH, FAR_TEXELS, PUBLISHED_PAIR, ShadowError, ShadowReport};
pub use shadow_error::{energy_ppm, near_boundary, shadow_error};

/// `count` out of `total` in parts per million; 0 of nothing is 0.
pub(super) fn per_million(count: usize, total: usize) -> f64 {
    if total == 0 { 0.0 } else { 1e6 * count as f64 / total as f64 }
}

/// The value below which a share of a sorted list lies (the nearest rank); 0 for an empty list.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_by_nearest_rank() {
        let sorted: Vec<f64> = (1..=150).map(f64::from).collect();
        assert_eq!([0.5, 0.99, 1.0].map(|share| quantile(&sorted, share)), [75.0, 149.0, 150.0]);
        assert_eq!(quantile(&[], 0.5), 0.0);
        assert_eq!(quantile(&[3.0], 0.99), 3.0);
    }
}
