//! What the library is held against: a ray-cast reference, error figures, scenes, other methods and their
//! times. Feature `compare`.

pub mod baselines;
pub mod error_figures;
mod fill;
pub mod gpu;
pub mod ideal;
pub mod procedural;
pub mod reference;
pub mod scene;
pub mod timing;

pub use fill::fill;
