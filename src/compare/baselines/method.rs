//! The methods by name, their sizes for a fair comparison, and their lookups.

use std::fmt;
use std::str::FromStr;

use super::{CubeMultiview, Lookup};
use crate::compare::gpu::Gpu;
use serde::{Deserialize, Serialize};

pub(super) const NO_MULTIVIEW: &str =
    "it needs a device with multiview over six layers, requested with wgpu::Features::MULTIVIEW";
const WRONG_MULTIVIEW: &str =
    "software drivers draw to the wrong face what they clip in a multiview pass (seen with Mesa 22.3)";

/// A way to make a point light's shadow map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// This library.
    Paraboloid,
    /// The paraboloid pair as published and as engines ship it: vertices warped, nothing split, a constant bias.
    VertexWarp,
    /// Six passes into a cube map, each instance culled against each face's frustum.
    Cube,
    /// Six passes into a cube map, everything drawn in each.
    CubeUnculled,
    /// [`Self::Cube`] with texels of two bytes.
    #[serde(rename = "cube-16")]
    Cube16,
    /// Six passes into a cube map, over triangles chosen by this library's routing.
    CubeRouted,
    /// One pass into all faces of a cube map; for devices with [`wgpu::Features::MULTIVIEW`].
    CubeMultiview,
    /// A cube map by this library's rasteriser in compute.
    CubeCompute,
    /// One plain view of the whole scene: the least that drawing each triangle once costs.
    DepthView,
}

/// What is kept equal when maps of different shape are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Budget {
    /// Texels across: a cube's face is as wide as one of the pair's maps.
    EqualSide,
    /// Texels in all: six faces have as many as the pair.
    EqualTexels,
}

impl Method {
    /// Every method.
    pub const ALL: [Self; 9] = [
        Self::Paraboloid,
        Self::VertexWarp,
        Self::Cube,
        Self::CubeUnculled,
        Self::Cube16,
        Self::CubeRouted,
        Self::CubeMultiview,
        Self::CubeCompute,
        Self::DepthView,
    ];

    /// The name that [`str::parse`] reads.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Paraboloid => "paraboloid",
            Self::VertexWarp => "vertex-warp",
            Self::Cube => "cube",
            Self::CubeUnculled => "cube-unculled",
            Self::Cube16 => "cube-16",
            Self::CubeRouted => "cube-routed",
            Self::CubeMultiview => "cube-multiview",
            Self::CubeCompute => "cube-compute",
            Self::DepthView => "depth-view",
        }
    }

    /// Whether the map is a cube of six faces; else it is two squares side by side.
    #[must_use]
    pub fn is_cube(self) -> bool {
        !matches!(self, Self::Paraboloid | Self::VertexWarp | Self::DepthView)
    }

    /// Whether there is a map of this method on the device: nothing in [`Self::left_out`].
    #[must_use]
    pub fn is_available(self, gpu: &Gpu) -> bool {
        self.left_out(gpu).is_none()
    }

    /// Why there is no map of this method on the device, or no right one, for reports; `None` where there is.
    #[must_use]
    pub fn left_out(self, gpu: &Gpu) -> Option<&'static str> {
        let software = gpu.info.device_type == wgpu::DeviceType::Cpu;
        match self {
            Self::CubeMultiview if !CubeMultiview::is_supported(&gpu.device) => Some(NO_MULTIVIEW),
            Self::CubeMultiview if software => Some(WRONG_MULTIVIEW),
            _ => None,
        }
    }

    /// Texels across one square of this method's map, to set against a pair of `pair` texels across each.
    #[must_use]
    pub fn side(self, pair: u32, budget: Budget) -> u32 {
        if self.is_cube() && budget == Budget::EqualTexels {
            // 6 C^2 = 2 R^2
            ((f64::from(pair) / 3f64.sqrt()).round() as u32).max(1)
        } else {
            pair
        }
    }

    /// Squares that the map consists of.
    #[must_use]
    pub fn squares(self) -> u32 {
        if self.is_cube() { 6 } else { 2 }
    }

    /// Bytes of a texel of the map.
    #[must_use]
    pub fn bytes_per_texel(self) -> u64 {
        match self {
            Self::Cube16 => 2,
            // Depth and the triangle's number.
            Self::Paraboloid | Self::CubeCompute => 8,
            _ => 4,
        }
    }

    /// The method whose maps have the same contents, of which this one's differ by rounding at most: what is fitted to
    /// the one is fitted to the other.
    #[must_use]
    pub fn same_map(self) -> Self {
        match self {
            Self::CubeUnculled | Self::CubeRouted | Self::CubeMultiview => Self::Cube,
            _ => self,
        }
    }

    /// Whether a lookup reads its map.
    #[must_use]
    pub fn is_read_by(self, lookup: Lookup) -> bool {
        self.lookups().contains(&lookup) || (self == Self::Paraboloid && lookup == Lookup::Filtered)
    }

    /// The lookups by which it is compared: none for [`Method::DepthView`], which no light looks out of.
    #[must_use]
    pub fn lookups(self) -> &'static [Lookup] {
        match self {
            Self::Paraboloid => &[Lookup::Paraboloid, Lookup::Votes],
            Self::VertexWarp => &[Lookup::VertexWarp, Lookup::VertexWarpShipped],
            Self::Cube16 => &[Lookup::CubeHardware, Lookup::CubeShipped],
            Self::CubeCompute => &[Lookup::CubeWalk, Lookup::CubePlane],
            Self::DepthView => &[],
            _ => &[Lookup::CubeHardware, Lookup::CubePlane, Lookup::CubeShipped],
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no method has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("no method is called {name:?}: there are {}", Method::ALL.map(Method::name).join(", "))]
pub struct UnknownMethod {
    /// What was given.
    pub name: String,
}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(name: &str) -> Result<Self, UnknownMethod> {
        let found = Self::ALL.into_iter().find(|method| method.name() == name);
        found.ok_or_else(|| UnknownMethod { name: name.to_owned() })
    }
}
