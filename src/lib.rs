//! Omnidirectional shadows for point lights from a dual paraboloid pair.

mod arena;
mod casters;
mod chunks;
#[cfg(feature = "compare")]
pub mod compare;
mod demand;
mod depth;
mod error;
mod gpu;
mod light;
mod lookup;
pub mod paraboloid;
mod ranges;
mod route;
mod shadows;
mod slots;
mod split;
mod transform;
mod view;
pub mod wgsl;

pub use casters::{CasterMesh, Casters, Indices, InstanceId, MeshId, Sides};
pub use error::Error;
pub use light::{Coverage, PointLight};
pub use shadows::{LightId, PointShadows, PointShadowsDescriptor};
