//! Compare
pub mod scene;
