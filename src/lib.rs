//! stub
pub mod paraboloid;
#[cfg(feature = "compare")]
pub mod compare;
