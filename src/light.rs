//! The point light: where it is, how far it reaches, which way its hemispheres face.

use crate::{Error, Filter};
use glam::{Quat, Vec3};

/// Which directions a light lights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Coverage {
    /// Every direction: a front and a back map.
    #[default]
    Full,
    /// The hemisphere around the light's +Z only, as of a lamp on a wall: one map at half the cost. Everything
    /// behind is in shadow.
    Hemisphere,
}

/// A point light that throws shadows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointLight {
    /// Position in world space.
    pub position: Vec3,
    /// Rotation from light space to world space. The front hemisphere's axis is light space's +Z. With
    /// [`Coverage::Full`] the shadows don't depend on it beyond the resolution's own error. That is least in the plane at
    /// right angles to the axis, where texels are finest: a light whose axis points where least of the scene is, seen
    /// from it, has about a tenth fewer wrong shadows than one that is turned at random.
    pub orientation: Quat,
    /// Casters nearer than this still throw shadows and receivers nearer than this are still shadowed; farther
    /// ones need not and are not. World units; finite, above `near`.
    pub range: f32,
    /// Casters nearer than `near / 2` on a hemisphere's axis and `near` at its rim are cut away. World units,
    /// above 0. Depth keeps its precision however small this is.
    pub near: f32,
    /// Both hemispheres, or one.
    pub coverage: Coverage,
    /// How far a receiver may lie from the surface of the casters that it belongs to, along its normal. World units, finite,
    /// 0 or more; 0 where the renderer draws the very triangles that cast. What stands before a receiver by more than this
    /// shadows it, so it is for shadow proxies, coarser levels of detail, displaced or tessellated surfaces, positions from
    /// a depth buffer, or skinning in other arithmetic: their greatest deviation.
    pub receiver_offset: f32,
    /// How soft the shadows are that `dp_shadow_filtered` finds. Changing it alone makes no map anew.
    pub filter: Filter,
}

impl Default for PointLight {
    /// At the origin, unturned, from 0.01 to 20 world units, in all directions, for receivers that cast, sharp.
    fn default() -> Self {
        Self {
            position: Vec3::ZERO,
            orientation: Quat::IDENTITY,
            range: 20.0,
            near: 0.01,
            coverage: Coverage::Full,
            receiver_offset: 0.0,
            filter: Filter::default(),
        }
    }
}

impl PointLight {
    /// # Errors
    /// [`Error::InvalidLight`] names the field that is not finite or out of range.
    pub fn validate(&self) -> Result<(), Error> {
        let wrong = |what, value: String, remedy| Err(Error::InvalidLight { what, value, remedy });
        if !self.position.is_finite() {
            return wrong("position", self.position.to_string(), "every coordinate must be finite");
        }
        if !self.orientation.is_finite() || !self.orientation.is_normalized() {
            return wrong("orientation", self.orientation.to_string(), "it must be a unit quaternion: normalize it");
        }
        if !(self.range.is_finite() && self.range > 0.0) {
            return wrong("range", self.range.to_string(), "it must be finite and above 0");
        }
        if !(self.near.is_finite() && self.near > 0.0) {
            return wrong("near distance", self.near.to_string(), "it must be finite and above 0");
        }
        if self.near >= self.range {
            return wrong("near distance", self.near.to_string(), "it must be below the range");
        }
        if !(self.receiver_offset.is_finite() && self.receiver_offset >= 0.0) {
            return wrong("receiver offset", self.receiver_offset.to_string(), "it must be finite and 0 or more");
        }
        self.filter.validate()
    }
}
