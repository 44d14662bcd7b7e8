//! Cones of normals: whether everything around a vertex, or in a chunk, faces away.

use glam::Vec3;

/// What is added to the sine of a cone's angle, for rounding and since the sine itself is stored in 1/127ths.
const SLACK: f32 = 0.02;

/// A cone that holds all normals of some triangles, in four signed bytes as `unpack4x8snorm` has them: the axis, and the
/// sine of the angle to it at most. A sine of 1 is a cone that is too wide to be of use.
#[repr(transparent)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Cone(pub(crate) u32);

impl Cone {
    /// Too wide to be of use.
    pub(crate) const NONE: Self = Self(0x7f00_0000);

    /// Around unit normals.
    pub(crate) fn new(normals: impl Iterator<Item = Vec3> + Clone) -> Self {
        let sum: Vec3 = normals.clone().sum();
        let axis = (sum.normalize_or_zero() * 127.0).round();
        let unit = axis.normalize_or_zero();
        let cosine = normals.map(|normal| normal.dot(unit)).fold(1.0, f32::min);
        if cosine <= 0.0 || unit == Vec3::ZERO {
            return Self::NONE;
        }
        let sine = ((1.0 - cosine * cosine).max(0.0).sqrt() + SLACK) * 127.0;
        let byte = |value: f32| u32::from(value as i8 as u8);
        Self(byte(axis.x) | byte(axis.y) << 8 | byte(axis.z) << 16 | byte(sine.ceil().min(127.0)) << 24)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unpack(cone: Cone) -> (Vec3, f32) {
        let [x, y, z, sine] = cone.0.to_le_bytes().map(|byte| f32::from(byte as i8) / 127.0);
        (Vec3::new(x, y, z).normalize(), sine)
    }

    #[test]
    fn a_cone_holds_its_normals() {
        let normals = [Vec3::X, Vec3::new(0.9, 0.3, -0.2), Vec3::new(0.7, -0.1, 0.5)].map(Vec3::normalize);
        let (axis, sine) = unpack(Cone::new(normals.into_iter()));
        for normal in normals {
            assert!(normal.cross(axis).length() < sine && normal.dot(axis) > 0.0, "{normal} is outside");
        }
        assert!(sine < 0.75, "a sine of {sine} is wider than need be");
    }

    #[test]
    fn normals_all_around_have_no_cone() {
        assert_eq!(Cone::new([Vec3::X, Vec3::NEG_X].into_iter()), Cone::NONE);
        assert_eq!(Cone::new([Vec3::X, Vec3::Y, Vec3::Z, -Vec3::ONE.normalize()].into_iter()), Cone::NONE);
        assert_eq!(Cone::new(std::iter::empty()), Cone::NONE);
    }
}
