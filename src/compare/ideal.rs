//! The floor at a resolution: a map whose every texel centre was ray-cast, and the lookup in double precision.
//!
//! What [`Lookup`] gets wrong on an [`IdealMap`] is owed to the resolution and to the lookup's own rule. What the
//! library gets wrong beyond that is owed to the library.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::reference::{Reference, View};
use crate::paraboloid::double as paraboloid;

/// In [`IdealMap::triangles`]: no caster in that direction.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// Size of a pair of maps. Both hemispheres lie side by side in one image of `2R x R` texels, the front at columns
/// `0..R`, the back at `R..2R`, row 0 on top (map coordinate v up, rows down).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapGeometry {
    /// Texels along one side of one hemisphere's map, R.
    pub resolution: u32,
    /// Width of the guard band in map coordinates, g: the map reaches from `-(1 + g)` to `1 + g`.
    pub guard: f64,
}

impl MapGeometry {
    /// Side of a texel in map coordinates, `2 (1 + g)/R`.
    #[must_use]
    pub fn texel(&self) -> f64 {
        2.0 * (1.0 + self.guard) / f64::from(self.resolution)
    }

    /// Number of texels of the pair, both whole squares.
    #[must_use]
    pub fn texels(&self) -> usize {
        2 * self.resolution as usize * self.resolution as usize
    }

    /// Map coordinates of the centre of the texel in column `i` and row `j` of its hemisphere's map.
    #[must_use]
    pub fn centre(&self, i: u32, j: u32) -> DVec2 {
        let half = 0.5 * f64::from(self.resolution);
        DVec2::new(f64::from(i) + 0.5 - half, half - f64::from(j) - 0.5) * self.texel()
    }

    /// Where map coordinates lie in their hemisphere's map, in texels from its upper left corner.
    #[must_use]
    pub fn position(&self, p: DVec2) -> DVec2 {
        let half = 0.5 * f64::from(self.resolution);
        DVec2::splat(half) + DVec2::new(p.x, -p.y) / self.texel()
    }

    /// Index of a texel in the image of the pair.
    #[must_use]
    pub fn index(&self, back: bool, i: u32, j: u32) -> usize {
        let r = self.resolution as usize;
        2 * r * j as usize + r * usize::from(back) + i as usize
    }

    /// Hemisphere, column and row of a texel of the image of the pair: undoes [`MapGeometry::index`].
    #[must_use]
    pub fn texel_at(&self, index: usize) -> (bool, u32, u32) {
        let r = self.resolution as usize;
        let (row, column) = (index / (2 * r), index % (2 * r));
        (column >= r, (column % r) as u32, row as u32)
    }

    /// Whether map coordinates lie in the disc that a map holds, guard band included.
    #[must_use]
    pub fn in_disc(&self, p: DVec2) -> bool {
        p.length() <= 1.0 + self.guard
    }
}

/// A pair of maps, ray-cast at its texel centres.
pub struct IdealMap {
    /// What of the light's surroundings the image shows.
    pub geometry: MapGeometry,
    /// For each texel of the image, the depth `near / w` of the nearest caster, 0 where there is none and outside the
    /// disc. Casters beyond the light's range are in it.
    pub depths: Vec<f64>,
    /// For each texel the triangle that was hit, or [`NO_TRIANGLE`].
    pub triangles: Vec<u32>,
}

/// Casts a ray through each texel centre of both discs, guard bands included.
#[must_use]
pub fn ideal_map(reference: &Reference, view: &View, geometry: MapGeometry) -> IdealMap {
    let (depths, triangles) = (0..geometry.texels())
        .into_par_iter()
        .map(|index| {
            let (back, i, j) = geometry.texel_at(index);
            ideal_texel(reference, view, &geometry, back, geometry.centre(i, j))
        })
        .unzip();
    IdealMap { geometry, depths, triangles }
}

/// Depth and triangle that a map should hold at map coordinates `p`.
fn ideal_texel(reference: &Reference, view: &View, geometry: &MapGeometry, back: bool, p: DVec2) -> (f64, u32) {
    if !geometry.in_disc(p) {
        return (0.0, NO_TRIANGLE);
    }
    let d = paraboloid::unproject(p);
    reference
        .nearest(view.to_world(d, back), view.clip_distance(d))
        .map_or((0.0, NO_TRIANGLE), |hit| (paraboloid::depth(d * hit.t, view.near), hit.triangle))
}

/// The lookup of `shaders/lookup.wgsl`, bilinear, in double precision: the same steps under the same names.
#[derive(Clone, Copy, Debug)]
pub struct Lookup {
    /// Where the light looks from.
    pub view: View,
    /// Size of the maps.
    pub geometry: MapGeometry,
    /// How far before the receiver's plane a texel's content may stand and still count as the receiver's surface, along
    /// the ray, in texel footprints at the receiver; above 0. Too little shows as acne on curved casters, too much as
    /// peter-panning. The library's is [`BIAS`].
    pub bias: f64,
    /// Bias along the receiver's normal, in texel footprints. The library's is [`NORMAL_BIAS`].
    pub normal_bias: f64,
}

/// The library's bias along the ray, `DP_BIAS`.
pub const BIAS: f64 = 0.05;

/// The library's bias along the normal, in `DpLight`.
pub const NORMAL_BIAS: f64 = crate::shadows::NORMAL_BIAS as f64;

/// Margin beyond the bias with which a texel's content is in the way for certain, `DP_RAMP`; in texel footprints, once
/// along the ray and once along the normal.
pub const RAMP: f64 = 0.5;

/// Margin behind the receiver's plane that halves a texel's vote for light, `DP_FADE`; in the same unit.
pub const FADE: f64 = 0.1;

/// Votes that it takes, `DP_QUORUM`: with fewer in all, darkness counts for less.
pub const QUORUM: f64 = 0.02;

/// Bounds of the ratio between the depths of the receiver's plane at a texel centre and at the receiver, against
/// planes that are seen edge-on: `DP_SLOPE_LOW` and `DP_SLOPE_HIGH`.
pub const SLOPE: (f64, f64) = (0.25, 4.0);

/// A receiver in the map of its hemisphere: `DpReceiver`.
struct Located {
    /// Hemisphere space, relative to the light.
    position: DVec3,
    normal: DVec3,
    back: bool,
    /// Map coordinates.
    map: DVec2,
}

impl Located {
    /// Cosine between the normal and the ray, from 0 (edge-on) to 1.
    fn incidence(&self) -> f64 {
        let ray = paraboloid::unproject_scaled(self.map);
        self.normal.dot(ray).abs() / (self.normal.length() * ray.length()).max(1e-30)
    }
}

impl Lookup {
    /// How much of the light reaches a point of the world, from 0 (dark) to 1 (lit), by the bilinear filter over the
    /// four nearest texels. Points out of range are lit. `stored` gives the depth in a texel of the image of the pair;
    /// `normal` is the receiver's geometric normal in the world, of any length and either sign.
    #[must_use]
    pub fn shadow(&self, stored: impl Fn(usize) -> f64, position: DVec3, normal: DVec3) -> f64 {
        let receiver = self.locate(position, normal);
        if receiver.position.length() > self.view.range {
            return 1.0;
        }
        self.sample_bilinear(stored, &receiver)
    }

    fn locate(&self, position: DVec3, normal: DVec3) -> Located {
        let (position, back) = self.view.to_hemisphere(position - self.view.position);
        let normal = paraboloid::to_hemisphere(self.view.orientation.inverse() * normal, back);
        Located { position, normal, back, map: paraboloid::project(position) }
    }

    /// Depth of the receiver's plane at map coordinates `p`.
    fn receiver_depth(&self, receiver: &Located, p: DVec2) -> f64 {
        let here = receiver.normal.dot(paraboloid::unproject_scaled(receiver.map));
        let there = receiver.normal.dot(paraboloid::unproject_scaled(p));
        // Without a plane (no normal, or the light in it) the receiver's own depth has to do.
        let slope = if here == 0.0 { 1.0 } else { (there / here).clamp(SLOPE.0, SLOPE.1) };
        paraboloid::depth(receiver.position, self.view.near) * slope
    }

    /// How far a texel's votes for light and for darkness count, each from 0 to 1, by its margin: how far its content
    /// stands before the receiver's plane, along the ray, in texel footprints.
    fn votes(&self, receiver: &Located, margin: f64) -> (f64, f64) {
        let grazing = 1.0 / receiver.incidence().max(1e-3);
        let bias = self.bias + self.normal_bias * grazing;
        // Half along the ray and half along the normal.
        let spread = 1.0 + grazing;
        let before = (1.0 - margin / bias).max(0.0);
        let behind = 1.0 / (1.0 - margin.min(0.0) / (FADE * spread));
        let dark = ((margin - bias) / (RAMP * spread)).clamp(0.0, 1.0);
        (if margin < 0.0 { behind } else { before }, dark)
    }

    fn sample_bilinear(&self, stored: impl Fn(usize) -> f64, receiver: &Located) -> f64 {
        let last = self.geometry.resolution - 1;
        let at = self.geometry.position(receiver.map) - 0.5;
        let base = at.floor().clamp(DVec2::ZERO, DVec2::splat(f64::from(last.saturating_sub(1))));
        let f = (at - base).clamp(DVec2::ZERO, DVec2::ONE);
        let footprint = paraboloid::texel_angle(receiver.map, self.geometry.texel());
        let (columns, rows) = ([1.0 - f.x, f.x], [1.0 - f.y, f.y]);
        let (mut lit, mut dark) = (0.0, 0.0);
        for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (i, j) = ((base.x as u32 + x).min(last), (base.y as u32 + y).min(last));
            let plane = self.receiver_depth(receiver, self.geometry.centre(i, j));
            let nearer = stored(self.geometry.index(receiver.back, i, j)) / plane - 1.0;
            let votes = self.votes(receiver, nearer / footprint);
            let weight = columns[x as usize] * rows[y as usize];
            lit += weight * votes.0;
            dark += weight * votes.1;
        }
        1.0 - dark / f64::max(lit + dark, QUORUM)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::test_shapes::{box_triangles, random_direction, random_vector, sheet};
    use glam::DQuat;
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    const GEOMETRY: MapGeometry = MapGeometry { resolution: 128, guard: 0.05 };

    fn view(position: DVec3, orientation: DQuat) -> View {
        View { position, orientation, near: 0.01, range: f64::INFINITY }
    }

    #[test]
    fn texels_and_map_coordinates_go_both_ways() {
        for index in 0..GEOMETRY.texels() {
            let (back, i, j) = GEOMETRY.texel_at(index);
            assert_eq!(GEOMETRY.index(back, i, j), index);
            let at = GEOMETRY.position(GEOMETRY.centre(i, j));
            assert!((at - DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5)).length() < 1e-10, "{at}");
        }
        let corner = GEOMETRY.centre(0, 0) + DVec2::new(-0.5, 0.5) * GEOMETRY.texel();
        assert!((corner - DVec2::new(-1.05, 1.05)).length() < 1e-12, "upper left: {corner}");
    }

    #[test]
    fn map_of_a_room_is_its_closed_form() {
        let mut random = Pcg64::seed_from_u64(1);
        for _ in 0..10 {
            let turn = DQuat::from_scaled_axis(random_vector(&mut random) * 3.0);
            let light = random_vector(&mut random);
            let view = view(light, turn);
            let (min, max) = (DVec3::new(-2.0, -1.5, -1.1), DVec3::new(1.3, 4.0, 6.0));
            let reference = Reference::new(&box_triangles(min, max), None, light);
            let map = ideal_map(&reference, &view, GEOMETRY);
            for (index, &depth) in map.depths.iter().enumerate() {
                let (back, i, j) = GEOMETRY.texel_at(index);
                let p = GEOMETRY.centre(i, j);
                if p.length() > 1.05 {
                    assert_eq!((depth, map.triangles[index]), (0.0, NO_TRIANGLE));
                    continue;
                }
                // The mapping in its textbook form, the back hemisphere turned half a circle about Y.
                let r2 = p.length_squared();
                let mut d = DVec3::new(2.0 * p.x, 2.0 * p.y, 1.0 - r2) / (1.0 + r2);
                let cosine = d.z;
                if back {
                    d = DQuat::from_rotation_y(std::f64::consts::PI) * d;
                }
                let d = turn * d;
                let walls = DVec3::select(d.cmpgt(DVec3::ZERO), max - light, min - light) / d;
                let expected = view.near / (walls.min_element() * (1.0 + cosine));
                assert!((depth / expected - 1.0).abs() < 1e-9, "{p} {depth} {expected}");
            }
        }
    }

    /// A cap of radius 0.9 near in front of each axis direction: held where w >= near, which is everywhere but next
    /// to the rim.
    #[test]
    fn casters_nearer_than_the_clip_distance_are_left_out() {
        let near = 1.0;
        let view = View { near, ..view(DVec3::ZERO, DQuat::IDENTITY) };
        let size = DVec3::splat(0.8);
        let reference = Reference::new(&box_triangles(-size, size), None, DVec3::ZERO);
        let map = ideal_map(&reference, &view, GEOMETRY);
        let mut clipped = 0;
        for (index, &depth) in map.depths.iter().enumerate() {
            let (_, i, j) = GEOMETRY.texel_at(index);
            let p = GEOMETRY.centre(i, j);
            if !GEOMETRY.in_disc(p) {
                continue;
            }
            let d = paraboloid::unproject(p);
            let w = 0.8 / d.abs().max_element() * (1.0 + d.z);
            assert_eq!(depth > 0.0, w >= near, "{p} {w}");
            clipped += usize::from(w < near);
        }
        assert!(clipped > 100);
    }

    /// A floor seen from a hand's breadth to grazing: no texel of it may shadow it, in any orientation, without a bias
    /// beyond rounding.
    #[test]
    fn a_plane_does_not_shadow_itself() {
        let mut random = Pcg64::seed_from_u64(3);
        for _ in 0..20 {
            let turn = DQuat::from_scaled_axis(random_vector(&mut random) * 3.0);
            let view = view(DVec3::ZERO, turn);
            let floor = sheet(DVec3::new(-1e3, -1.0, -1e3), DVec3::X * 2e3, DVec3::Z * 2e3);
            let reference = Reference::new(&floor, None, DVec3::ZERO);
            let map = ideal_map(&reference, &view, GEOMETRY);
            let lookup = Lookup { view, geometry: GEOMETRY, bias: 1e-6, normal_bias: 0.0 };
            for _ in 0..2000 {
                let mut d = random_direction(&mut random);
                d.y = -d.y.abs() - 0.1;
                let normal = DVec3::Y * random.random_range(0.1..10.0) * if random.random() { 1.0 } else { -1.0 };
                let value = lookup.shadow(|texel| map.depths[texel], d / -d.y, normal);
                assert!((value - 1.0).abs() < 1e-12, "{d} {value}");
            }
        }
    }

    /// What stands before the receiver's plane by more than the bias shadows it, and what stands less far doesn't.
    #[test]
    fn bias_is_in_texel_footprints_along_the_ray() {
        let geometry = MapGeometry { resolution: 64, guard: 0.0 };
        let lookup = Lookup { view: view(DVec3::ZERO, DQuat::IDENTITY), geometry, bias: 0.5, normal_bias: 0.0 };
        let mut random = Pcg64::seed_from_u64(4);
        for _ in 0..1000 {
            let d = random_direction(&mut random);
            let (in_map, _) = lookup.view.to_hemisphere(d);
            let footprint = paraboloid::texel_angle(paraboloid::project(in_map), geometry.texel());
            let value = |margin: f64| {
                let distance = 1.0 / (1.0 + margin * footprint);
                lookup.shadow(|texel| plane_depth(&geometry, in_map, distance, texel), d, d)
            };
            assert_eq!(value(0.49), 1.0, "{d}");
            assert!(value(0.52) < 0.5 && value(0.5 + 2.0 * RAMP) == 0.0, "{d}");
        }
    }

    /// Depth in a texel of the plane at `distance` from the light, square to a unit direction of its hemisphere.
    fn plane_depth(geometry: &MapGeometry, normal: DVec3, distance: f64, texel: usize) -> f64 {
        let (_, i, j) = geometry.texel_at(texel);
        paraboloid::plane_depth(normal, distance, geometry.centre(i, j), 0.01)
    }

    /// With one texel of the four dark and the others on the receiver's surface, the answer falls by that texel's
    /// bilinear weight.
    #[test]
    fn weights_are_bilinear() {
        for_one_dark_texel(
            |d, dark, texel| if texel == dark { 1.0 } else { plane_depth(&GEOMETRY, d, 3.0, texel) },
            |weight| 1.0 - weight,
        );
    }

    /// Where the others show what is behind the receiver's surface, the dark one decides.
    #[test]
    fn texels_past_the_end_of_the_surface_hardly_count() {
        for_one_dark_texel(
            |_, dark, texel| if texel == dark { 1.0 } else { 0.0 },
            |weight| (1.0 - weight / QUORUM).max(0.0),
        );
    }

    /// Asks around a texel of the front map, with a surface square to the ray: `stored` gives the depth by the ray's
    /// direction, the dark texel and the one that is read, `expected` the answer by the dark texel's bilinear weight.
    fn for_one_dark_texel(stored: impl Fn(DVec3, usize, usize) -> f64, expected: impl Fn(f64) -> f64) {
        let lookup =
            Lookup { view: view(DVec3::ZERO, DQuat::IDENTITY), geometry: GEOMETRY, bias: 0.1, normal_bias: 0.0 };
        let (i, j) = (40, 70);
        let dark = GEOMETRY.index(false, i, j);
        for (x, y) in [(0.0, 0.0), (0.25, 0.5), (-0.75, 0.1), (0.9, -0.9), (-0.3, -0.4), (1.1, 0.0)] {
            let p = GEOMETRY.centre(i, j) + DVec2::new(x, y) * GEOMETRY.texel();
            let d = paraboloid::unproject(p);
            let weight = f64::max(0.0, 1.0 - f64::abs(x)) * f64::max(0.0, 1.0 - f64::abs(y));
            let value = lookup.shadow(|texel| stored(d, dark, texel), d * 3.0, d);
            assert!((value - expected(weight)).abs() < 0.05, "{x} {y}: {value} {}", expected(weight));
        }
    }
}
