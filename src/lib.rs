//! stub
#[cfg(feature = "compare")]
pub mod compare;
pub mod paraboloid;
