//! Filters by name, for the command lines of `render` and `measure`.

use clap::ValueEnum;
use dual_paraboloid::Filter;

/// Radius of the disc, in radians: about half a degree.
const DISC: f32 = 0.01;
/// Radius of a soft light that isn't given one, as a share of its range.
const LIGHT_RADIUS: f32 = 0.005;

/// A filter without its settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FilterName {
    /// The casters' own edges, smooth over a pixel
    Sharp,
    /// The same, light or darkness and nothing between
    Hard,
    /// 3 x 3 texels
    Pcf3,
    /// 5 x 5 texels
    Pcf5,
    /// A disc of directions, of 0.01 radians to each side
    Disc,
    /// A sphere of light
    Soft,
}

impl FilterName {
    /// The filter, for a light of this radius in world units, or of half a hundredth of its range.
    pub fn with(self, light_radius: Option<f32>, range: f32) -> Filter {
        match self {
            Self::Hard => Filter::Hard,
            Self::Sharp => Filter::Sharp,
            Self::Pcf3 => Filter::Pcf3,
            Self::Pcf5 => Filter::Pcf5,
            Self::Disc => Filter::disc(DISC),
            Self::Soft => Filter::soft(light_radius.unwrap_or(LIGHT_RADIUS * range)),
        }
    }
}
