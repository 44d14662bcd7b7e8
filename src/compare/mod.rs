//! What the library is held against: a ray-cast reference, error figures, scenes. Feature `compare`.

pub mod error_figures;
mod fill;
pub mod gpu;
pub mod ideal;
pub mod procedural;
pub mod reference;
pub mod scene;

pub use fill::fill;
