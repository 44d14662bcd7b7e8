//! A yardstick: the lookup of four votes as it was when figures were first published with it.
//!
//! "Wrong over ideal" says how near a method comes to what its resolution allows. The ideal is this lookup on a map whose
//! every texel centre was ray-cast, and it is frozen, so that ratios of different versions can be compared.
//! [`ideal::Lookup`](super::ideal::Lookup) follows the library's own lookup; this one must never change, and shares
//! nothing with it that may. A better yardstick gets another name.

use glam::{DVec2, DVec3};

use super::ideal::MapGeometry;
use super::reference::View;
use crate::paraboloid::double as paraboloid;

/// Bias along the ray, in texel footprints at the receiver.
const BIAS: f64 = 0.05;
/// Bias along the receiver's normal, in texel footprints: that of a pair with the tolerance 0.1.
const NORMAL_BIAS: f64 = 0.05;
/// Margin beyond the bias with which a texel votes against in full, in footprints along the ray and along the normal.
const RAMP: f64 = 0.5;
/// Margin behind the receiver's plane that halves a vote for light, in the same unit.
const FADE: f64 = 0.1;
/// Votes that it takes; with fewer in all, darkness counts for less.
const QUORUM: f64 = 0.02;
/// Bounds of the ratio between the depths of the receiver's plane at a texel centre and at the receiver.
const SLOPE: (f64, f64) = (0.25, 4.0);
/// Least cosine between normal and ray that the grazing factor takes.
const LEAST_INCIDENCE: f64 = 1e-3;

/// The frozen lookup `votes-v1` on the maps of one light.
#[derive(Clone, Copy, Debug)]
pub struct VotesV1 {
    /// Where the light looks from.
    pub view: View,
    /// Size of the maps.
    pub geometry: MapGeometry,
}

impl VotesV1 {
    /// How much of the light reaches a point of the world, from 0 (dark) to 1 (lit). Points out of range are lit.
    /// `stored` gives the depth in a texel of the image of the pair; `normal` is the receiver's geometric normal in the
    /// world, of any length and either sign.
    #[must_use]
    pub fn shadow(&self, stored: impl Fn(usize) -> f64, position: DVec3, normal: DVec3) -> f64 {
        let (x, back) = self.view.to_hemisphere(position - self.view.position);
        if x.length() > self.view.range {
            return 1.0;
        }
        let normal = paraboloid::to_hemisphere(self.view.orientation.inverse() * normal, back);
        let p = paraboloid::project(x);
        let ray = paraboloid::unproject_scaled(p);
        let incidence = normal.dot(ray).abs() / (normal.length() * ray.length()).max(1e-30);
        let footprint = paraboloid::texel_angle(p, self.geometry.texel());
        let (mut lit, mut dark) = (0.0, 0.0);
        for (i, j, weight) in self.four_texels(p) {
            let slope = slope(normal, ray, paraboloid::unproject_scaled(self.geometry.centre(i, j)));
            let plane = paraboloid::depth(x, self.view.near) * slope;
            let margin = (stored(self.geometry.index(back, i, j)) / plane - 1.0) / footprint;
            let votes = votes(margin, incidence);
            lit += weight * votes.0;
            dark += weight * votes.1;
        }
        1.0 - dark / f64::max(lit + dark, QUORUM)
    }

    /// Column, row and bilinear weight of the texels around map coordinates `p`.
    fn four_texels(&self, p: DVec2) -> [(u32, u32, f64); 4] {
        let last = self.geometry.resolution - 1;
        let at = self.geometry.position(p) - 0.5;
        let base = at.floor().clamp(DVec2::ZERO, DVec2::splat(f64::from(last.saturating_sub(1))));
        let f = (at - base).clamp(DVec2::ZERO, DVec2::ONE);
        let (columns, rows) = ([1.0 - f.x, f.x], [1.0 - f.y, f.y]);
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| {
            let (i, j) = ((base.x as u32 + x).min(last), (base.y as u32 + y).min(last));
            (i, j, columns[x as usize] * rows[y as usize])
        })
    }
}

/// Ratio of the depths of the receiver's plane at two rays of its hemisphere.
fn slope(normal: DVec3, here: DVec3, there: DVec3) -> f64 {
    let (here, there) = (normal.dot(here), normal.dot(there));
    // Without a plane (no normal, or the light in it) the receiver's own depth has to do.
    if here == 0.0 { 1.0 } else { (there / here).clamp(SLOPE.0, SLOPE.1) }
}

/// How far a texel's votes for light and for darkness count, each from 0 to 1, by how far its content stands before the
/// receiver's plane, in footprints along the ray.
fn votes(margin: f64, incidence: f64) -> (f64, f64) {
    let grazing = 1.0 / incidence.max(LEAST_INCIDENCE);
    let bias = BIAS + NORMAL_BIAS * grazing;
    let spread = 1.0 + grazing;
    let before = (1.0 - margin / bias).max(0.0);
    let behind = 1.0 / (1.0 - margin.min(0.0) / (FADE * spread));
    let dark = ((margin - bias) / (RAMP * spread)).clamp(0.0, 1.0);
    (if margin < 0.0 { behind } else { before }, dark)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    const GEOMETRY: MapGeometry = MapGeometry { resolution: 64, guard: 0.0 };

    /// The frozen values: a surface square to the ray has the bias 0.1 and the spread 2, one at a cosine of a half 0.15
    /// and 3.
    #[test]
    fn votes_are_what_they_were() {
        for (margin, incidence, lit, dark) in [
            (0.0, 1.0, 1.0, 0.0),
            (0.05, 1.0, 0.5, 0.0),
            (0.1, 1.0, 0.0, 0.0),
            (0.6, 1.0, 0.0, 0.5),
            (1.1, 1.0, 0.0, 1.0),
            (-0.2, 1.0, 0.5, 0.0),
            (0.15, 0.5, 0.0, 0.0),
            (0.9, 0.5, 0.0, 0.5),
            (-0.9, 0.5, 0.25, 0.0),
        ] {
            let found = votes(margin, incidence);
            assert!((found.0 - lit).abs() < 1e-12 && (found.1 - dark).abs() < 1e-12, "{margin} {incidence}: {found:?}");
        }
    }

    /// A floor square to the axis, asked at the corner that four texels share: each has a quarter of the weight.
    #[test]
    fn four_texels_vote() {
        let view = View { position: DVec3::ZERO, orientation: DQuat::IDENTITY, near: 0.01, range: 10.0 };
        let lookup = VotesV1 { view, geometry: GEOMETRY };
        let plane = |texel: usize| {
            let (_, i, j) = GEOMETRY.texel_at(texel);
            paraboloid::plane_depth(DVec3::Z, 2.0, GEOMETRY.centre(i, j), 0.01)
        };
        let nearer = |texels: &[(u32, u32)], footprints: f64| {
            let of = |texel: usize| texels.iter().any(|&(i, j)| GEOMETRY.index(false, i, j) == texel);
            let factor = 1.0 + footprints * paraboloid::texel_angle(DVec2::ZERO, GEOMETRY.texel());
            lookup.shadow(|texel| plane(texel) * if of(texel) { factor } else { 1.0 }, DVec3::Z * 2.0, DVec3::Z)
        };
        assert!((nearer(&[], 0.0) - 1.0).abs() < 1e-12);
        assert!((nearer(&[(31, 31)], 2.0) - 0.75).abs() < 1e-12, "one full vote against of four");
        assert!((nearer(&[(31, 31), (32, 32)], 2.0) - 0.5).abs() < 1e-12);
        assert!((nearer(&[(31, 31)], 0.6) - (1.0 - 0.5 / 3.5)).abs() < 1e-9, "half a vote against");
        let all = [(31, 31), (32, 31), (31, 32), (32, 32)];
        assert!(nearer(&all, 2.0).abs() < 1e-12);
        assert_eq!(lookup.shadow(|_| 1.0, DVec3::Z * 10.1, DVec3::Z), 1.0, "out of range");
    }
}
