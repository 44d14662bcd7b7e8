//! How soft a light's shadows are (`shaders/filter.wgsl`).

use crate::Error;

/// How the lookup `dp_shadow_filtered` softens the edges of a light's shadows. `dp_shadow` is always [`Filter::Sharp`].
///
/// The first two ask the casters' triangles. Those of 3 x 3 and 5 x 5 texels are as wide as texels are: their width in the
/// scene varies with the resolution and, twofold, from the axis of a hemisphere to its rim. The other two have a width of
/// their own, the same in every direction, up to 20 degrees as seen from the light and across the join of the hemispheres.
///
/// With [`Coverage::Hemisphere`](crate::Coverage::Hemisphere) everything behind counts as dark.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Filter {
    /// The casters' own edges, smooth over the pixel that the lookup is given: the least that a lookup costs. Four texels, one
    /// gather; where they disagree, a second one and the triangles that they show.
    #[default]
    Sharp,
    /// [`Filter::Sharp`] at the pixel's middle, for light or darkness and nothing between.
    Hard,
    /// The mean over 3 x 3 texels, four gathers.
    Pcf3,
    /// The mean over 5 x 5 texels, nine gathers. Wants a [guard band](crate::PointShadowsDescriptor::guard) of 4 texels
    /// or more: with less it is narrower where it meets the join.
    Pcf5,
    /// The mean over a disc of directions, by taps along a spiral that the lookup's noise turns. As wide at a contact
    /// as anywhere, so it lets light in under casters by as much, and darkens concave creases.
    Disc {
        /// Angle between the disc's middle and its rim as seen from the light, in radians: 0 to [`Filter::WIDEST`].
        radius: f32,
        /// Gathers, 1 to [`Filter::MOST_TAPS`].
        taps: u32,
    },
    /// The share of a sphere around the light that the receiver sees: sharp at contacts and softer with the distance
    /// between caster and receiver, as sharp as [`Filter::Sharp`] where penumbras are narrower than a texel. What stands so near the light that its penumbra would be wider than 20 degrees to
    /// each side throws one of 20.
    ///
    /// After Fernando, *Percentage-closer soft shadows* (2005): a search for what stands before the sphere, and a disc
    /// as wide as its penumbra. What a tap finds counts where a line from the receiver through it meets the sphere, as
    /// in Guennebaud, Barthe and Paulin, *Real-time soft shadow mapping by backprojection* (2006). Of casters behind one
    /// another the map has the one that is nearest to the light: whether another stands behind is guessed from what shows
    /// beside it. Against ray tracing the RMS error in penumbras is 0.02 to 0.1 of the light among plates and boxes, more
    /// where much is hidden.
    Soft {
        /// The sphere's radius in world units, finite, 0 or more.
        light_radius: f32,
        /// Gathers of the search, and as many of the disc where it finds something: 1 to [`Filter::MOST_TAPS`].
        taps: u32,
    },
}

/// A filter as the lookup reads it; twin of `DpFilter`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct FilterRecord {
    kind: u32,
    size: f32,
    taps: u32,
}

impl Filter {
    /// Radius of the widest disc, in radians: 20 degrees.
    pub const WIDEST: f32 = 20.0 * std::f32::consts::PI / 180.0;

    /// The most taps.
    pub const MOST_TAPS: u32 = 256;

    /// A [`Filter::Disc`] of a radius in radians, with 16 taps.
    #[must_use]
    pub const fn disc(radius: f32) -> Self {
        Self::Disc { radius, taps: 16 }
    }

    /// A [`Filter::Soft`] of a radius in world units, with 32 taps.
    #[must_use]
    pub const fn soft(light_radius: f32) -> Self {
        Self::Soft { light_radius, taps: 32 }
    }

    /// # Errors
    /// [`Error::InvalidLight`] names the setting that is out of range.
    pub fn validate(&self) -> Result<(), Error> {
        let wrong = |what, value: String, remedy| Err(Error::InvalidLight { what, value, remedy });
        let taps = match *self {
            Self::Disc { radius, .. } if !(0.0..=Self::WIDEST).contains(&radius) => {
                return wrong("filter's radius", radius.to_string(), "it must be 0 to 20 degrees, in radians");
            }
            Self::Soft { light_radius, .. } if !(light_radius.is_finite() && light_radius >= 0.0) => {
                return wrong("filter's light radius", light_radius.to_string(), "it must be finite and 0 or more");
            }
            Self::Disc { taps, .. } | Self::Soft { taps, .. } => taps,
            Self::Hard | Self::Sharp | Self::Pcf3 | Self::Pcf5 => 1,
        };
        if !(1..=Self::MOST_TAPS).contains(&taps) {
            return wrong("filter's number of taps", taps.to_string(), "it must be 1 to 256");
        }
        Ok(())
    }

    pub(crate) fn record(&self) -> FilterRecord {
        let (kind, size, taps) = match *self {
            Self::Sharp => (0, 0.0, 0),
            Self::Hard => (1, 0.0, 0),
            Self::Pcf3 => (2, 0.0, 0),
            Self::Pcf5 => (3, 0.0, 0),
            Self::Disc { radius, taps } => (4, radius, taps),
            Self::Soft { light_radius, taps } => (5, light_radius, taps),
        };
        FilterRecord { kind, size, taps }
    }
}
