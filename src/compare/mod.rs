//! What the library is held against: a ray-cast reference, error figures, scenes. Feature `compare`.
//!
//! [`reference`](mod@reference) is the truth by ray casting, [`ideal`] the map and the lookup as they would be if the
//! resolution were the only source of error, [`votes_v1`] the lookup that floors are published with, [`error_figures`] says how far from both an answer is, [`area_light`] is
//! the truth for soft lights, and [`measure`] puts them together. [`baselines`] are the cubes and the published technique, [`timing`] takes their times, and
//! [`cost`] sets these against the errors.

pub mod area_light;
pub mod baselines;
mod closed_pieces;
pub mod cost;
mod cut_outs;
pub mod error_figures;
mod fill;
pub mod gpu;
pub mod ideal;
pub mod lookup_cost;
pub mod measure;
pub mod numbered;
pub mod procedural;
pub mod reference;
pub mod scene;
pub mod shot;
#[cfg(test)]
mod test_shapes;
pub mod text;
pub mod timing;
pub mod votes_v1;

pub use cut_outs::{AlphaMask, CutOuts};
pub use fill::fill;
