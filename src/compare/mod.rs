//! Compare
pub mod procedural;
pub mod scene;
