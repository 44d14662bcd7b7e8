//! What the library is held against: a ray-cast reference, error figures, scenes. Feature `compare`.

pub mod gpu;
pub mod procedural;
pub mod scene;
