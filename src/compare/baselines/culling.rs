//! Which instances a view can see, by their boxes, as engines cull on the CPU.

use glam::{Affine3A, Vec3};

/// Share of a distance that rounding may cost; boxes nearer than that to a border count as inside.
const SLACK: f32 = 1e-5;

/// A box at any angle, in world space.
#[derive(Debug, Clone, Copy)]
pub(super) struct OrientedBox {
    pub(super) centre: Vec3,
    /// From the centre to the middle of three faces.
    pub(super) half_axes: [Vec3; 3],
}

impl OrientedBox {
    /// An axis-aligned box of mesh space, seen from the world.
    pub(super) fn new(low: Vec3, high: Vec3, transform: &Affine3A) -> Self {
        let half = 0.5 * (high - low);
        let matrix = transform.matrix3;
        Self {
            centre: transform.transform_point3(0.5 * (low + high)),
            half_axes: [matrix.x_axis * half.x, matrix.y_axis * half.y, matrix.z_axis * half.z].map(Vec3::from),
        }
    }

    /// How far the box reaches from its centre along `direction`, times the length of that.
    pub(super) fn reach(&self, direction: Vec3) -> f32 {
        self.half_axes.iter().map(|axis| axis.dot(direction).abs()).sum()
    }

    /// Whether some of the box is in the half-space of `x` with `normal.x >= distance`, relative to `origin`.
    pub(super) fn touches_half_space(&self, origin: Vec3, normal: Vec3, distance: f32) -> bool {
        let centre = self.centre - origin;
        let (ahead, reach) = (centre.dot(normal), self.reach(normal));
        ahead + reach - distance >= -SLACK * (centre.length() + reach)
    }

    /// Whether some of the box may be in a sphere: exact along the line of the centres, as engines test it.
    pub(super) fn touches_sphere(&self, centre: Vec3, radius: f32) -> bool {
        let between = self.centre - centre;
        let distance = between.length();
        let reach = self.reach(between / distance.max(f32::MIN_POSITIVE));
        distance <= (radius + reach) * (1.0 + SLACK)
    }

    /// Lowest and highest corner of the axis-aligned box around it.
    pub(super) fn world_bounds(&self) -> (Vec3, Vec3) {
        let reach = self.half_axes.iter().map(|axis| axis.abs()).sum::<Vec3>();
        (self.centre - reach, self.centre + reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    fn turned_bar() -> OrientedBox {
        // Eight long along x, turned to lie along the diagonal of x and y.
        let turn = Affine3A::from_rotation_translation(Quat::from_rotation_z(45f32.to_radians()), Vec3::X * 10.0);
        OrientedBox::new(Vec3::new(-4.0, -0.1, -0.1), Vec3::new(4.0, 0.1, 0.1), &turn)
    }

    #[test]
    fn half_spaces_see_the_turned_box_and_not_the_box_around_it() {
        let bar = turned_bar();
        let across = Vec3::new(1.0, -1.0, 0.0).normalize();
        let centre = 10.0 * across.x;
        assert!(bar.touches_half_space(Vec3::ZERO, across, centre + 0.09));
        assert!(!bar.touches_half_space(Vec3::ZERO, across, centre + 0.11));
    }

    #[test]
    fn spheres_touch_at_the_bar_s_end() {
        let bar = turned_bar();
        let end = bar.centre + bar.half_axes[0];
        let beyond = bar.centre + 2.0 * bar.half_axes[0];
        assert!(bar.touches_sphere(beyond, beyond.distance(end) + 0.01));
        assert!(!bar.touches_sphere(beyond, beyond.distance(end) - 0.01));
        assert!(bar.touches_sphere(bar.centre, 0.01));
    }

    #[test]
    fn world_bounds_hold_the_corners() {
        let (low, high) = turned_bar().world_bounds();
        let (end, width) = (8f32.sqrt(), 0.1 * 2f32.sqrt());
        assert!((high - Vec3::new(10.0 + end + width / 2.0, end + width / 2.0, 0.1)).length() < 1e-5);
        assert!((low + high - Vec3::X * 20.0).length() < 1e-5);
    }
}
