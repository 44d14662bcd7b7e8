//! What the texels of a map hold, against what the rays through their centres meet.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{per_million, quantile};
use crate::compare::ideal::{IdealMap, MapGeometry, NO_TRIANGLE};
use crate::compare::reference::{Hit, Reference, View};
use crate::paraboloid::double as paraboloid;

/// How far off the true surface's plane, measured along its normal and in texel footprints, a stored depth may be
/// and still be that surface's. More than rounding, and far less than what a shadow shows.
pub const SURFACE_TOLERANCE: f64 = 0.05;

/// How far the true surface has to step to make a silhouette, in texel footprints along the normal. Less than
/// [`SURFACE_TOLERANCE`], since across an edge-on fold the step is measured along the other surface's normal.
const SILHOUETTE_DEPTH: f64 = 0.025;
/// Distance between the rings of rays that look for a silhouette, in texels, and how many of them there are.
const SILHOUETTE_RINGS: (f64, usize) = (0.125, 16);
/// The same close to the texel's centre, where it takes no more than rounding for the ray and the rasteriser to meet
/// different surfaces.
const SILHOUETTE_INNER_RINGS: (f64, usize) = (1.0 / 1024.0, 16);
/// Rays of each ring.
const SILHOUETTE_SPOKES: usize = 48;

/// Figures about the texels of a map.
///
/// Judged are the texels whose centre lies in a disc, guard band included, at least a texel inside the rim of the guard
/// band. A texel in whose direction the nearest caster is beyond the light's range isn't judged, since the map may
/// leave that caster out, unless it holds a depth within the range.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct MapError {
    /// Number of texels judged.
    pub texels: usize,
    /// Texels, in parts per million, that hold another surface than the one that the ray through their centre meets:
    /// the stored depth is off that triangle's plane by more than [`SURFACE_TOLERANCE`]. Without holes and phantoms.
    pub wrong_surface_ppm: f64,
    /// Texels that are empty although the ray meets a caster.
    pub holes: usize,
    /// Texels that hold a depth although the ray meets no caster.
    pub phantoms: usize,
    /// Median of |stored - true| / true over the texels that hold the right surface.
    pub depth_error_median: f64,
    /// 99th percentile of the same.
    pub depth_error_p99: f64,
    /// Largest of the same.
    pub depth_error_max: f64,
    /// Wrong surfaces, holes and phantoms farther than one texel from every silhouette: from every place where the
    /// true surface steps by more than a fortieth of a texel footprint between rays an eighth of a texel apart, or a 1024th
    /// of a texel close by. Silhouettes are looked for by rays, which can miss a thin one, so this is never too low.
    pub strays: usize,
    /// Largest distance from a wrong surface, hole or phantom to a silhouette, in texels; infinite when one is 2
    /// texels or more from any.
    #[serde(skip)]
    pub silhouette_distance_max: f64,
}

/// What a texel holds, against the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TexelVerdict {
    /// Outside the discs, or beyond the light's range.
    NotJudged,
    /// No caster, and none stored.
    Empty,
    /// The right surface, with this relative depth error.
    Right(f64),
    /// Another surface.
    WrongSurface,
    /// Nothing stored where there is a caster.
    Hole,
    /// Something stored where there is no caster.
    Phantom,
}

/// Figures about a map read back as the image of the pair ([`MapGeometry`]), 0 where it is empty.
///
/// # Panics
/// When `stored` doesn't have as many texels as the ideal map.
#[must_use]
pub fn map_error(stored: &[f32], ideal: &IdealMap, reference: &Reference, view: &View) -> MapError {
    let verdicts = judge_texels(stored, ideal, reference, view);
    let count = |verdict| verdicts.par_iter().filter(|&&v| v == verdict).count();
    let texels = verdicts.len() - count(TexelVerdict::NotJudged);
    let errors = depth_errors(&verdicts);
    let distances = silhouette_distances(&verdicts, ideal, reference, view);
    MapError {
        texels,
        wrong_surface_ppm: per_million(count(TexelVerdict::WrongSurface), texels),
        holes: count(TexelVerdict::Hole),
        phantoms: count(TexelVerdict::Phantom),
        depth_error_median: quantile(&errors, 0.5),
        depth_error_p99: quantile(&errors, 0.99),
        depth_error_max: quantile(&errors, 1.0),
        strays: distances.iter().filter(|&&distance| distance > 1.0).count(),
        silhouette_distance_max: distances.iter().copied().fold(0.0, f64::max),
    }
}

/// The verdict on every texel of the image of the pair; see [`MapError`] for what each means.
///
/// # Panics
/// When `stored` doesn't have as many texels as the ideal map.
#[must_use]
pub fn judge_texels(stored: &[f32], ideal: &IdealMap, reference: &Reference, view: &View) -> Vec<TexelVerdict> {
    assert_eq!(stored.len(), ideal.depths.len(), "the maps differ in size");
    let judge = Judge { geometry: ideal.geometry, reference, view };
    (0..stored.len())
        .into_par_iter()
        .map(|index| judge.texel(f64::from(stored[index]), ideal.depths[index], ideal.triangles[index], index))
        .collect()
}

struct Judge<'a> {
    geometry: MapGeometry,
    reference: &'a Reference,
    view: &'a View,
}

impl Judge<'_> {
    fn texel(&self, stored: f64, ideal: f64, triangle: u32, index: usize) -> TexelVerdict {
        let (back, i, j) = self.geometry.texel_at(index);
        let p = self.geometry.centre(i, j);
        if p.length() > 1.0 + self.geometry.guard - self.geometry.texel() {
            return TexelVerdict::NotJudged;
        }
        if triangle == NO_TRIANGLE {
            return if stored == 0.0 { TexelVerdict::Empty } else { TexelVerdict::Phantom };
        }
        let same_surface = stored > 0.0 && self.is_on_surface(stored, ideal, triangle, p, back);
        if self.distance(ideal, p) > self.view.range {
            let intrudes = stored > 0.0 && !same_surface && self.distance(stored, p) <= self.view.range;
            return if intrudes { TexelVerdict::Phantom } else { TexelVerdict::NotJudged };
        }
        match (stored == 0.0, same_surface) {
            (true, _) => TexelVerdict::Hole,
            (false, true) => TexelVerdict::Right((stored - ideal).abs() / ideal),
            (false, false) => TexelVerdict::WrongSurface,
        }
    }

    /// Distance from the light, in world units, of a depth at map coordinates `p`.
    fn distance(&self, depth: f64, p: DVec2) -> f64 {
        self.view.near / depth * paraboloid::unproject_scaled(p).length()
    }

    fn is_on_surface(&self, stored: f64, ideal: f64, triangle: u32, p: DVec2, back: bool) -> bool {
        let point = self.view.to_world(paraboloid::unproject(p), back) * self.distance(stored, p);
        let footprint = self.distance(ideal, p) * paraboloid::texel_angle(p, self.geometry.texel());
        self.reference.height(point, triangle).abs() <= SURFACE_TOLERANCE * footprint
    }
}

fn depth_errors(verdicts: &[TexelVerdict]) -> Vec<f64> {
    let mut errors: Vec<f64> = verdicts
        .par_iter()
        .filter_map(|verdict| if let TexelVerdict::Right(error) = verdict { Some(*error) } else { None })
        .collect();
    errors.par_sort_unstable_by(f64::total_cmp);
    errors
}

/// For each wrong surface, hole and phantom its distance from a silhouette, in texels.
fn silhouette_distances(verdicts: &[TexelVerdict], ideal: &IdealMap, reference: &Reference, view: &View) -> Vec<f64> {
    let search = SilhouetteSearch { geometry: ideal.geometry, reference, view };
    verdicts
        .par_iter()
        .enumerate()
        .filter(|(_, verdict)| {
            matches!(verdict, TexelVerdict::WrongSurface | TexelVerdict::Hole | TexelVerdict::Phantom)
        })
        .map(|(index, _)| {
            let (back, i, j) = ideal.geometry.texel_at(index);
            search.distance(ideal.geometry.centre(i, j), back)
        })
        .collect()
}

/// Radii of the rings of rays that look for a silhouette, in texels.
fn silhouette_radii() -> impl Iterator<Item = f64> {
    let (step, rings) = SILHOUETTE_RINGS;
    let (inner_step, inner_rings) = SILHOUETTE_INNER_RINGS;
    let inner = (1..=inner_rings).map(move |ring| ring as f64 * inner_step);
    inner.chain((1..=rings).map(move |ring| ring as f64 * step))
}

struct SilhouetteSearch<'a> {
    geometry: MapGeometry,
    reference: &'a Reference,
    view: &'a View,
}

/// A ray's direction in world axes, the angle a texel spans there, and what it meets.
#[derive(Clone, Copy)]
struct Ray {
    direction: DVec3,
    texel_angle: f64,
    hit: Option<Hit>,
}

impl SilhouetteSearch<'_> {
    /// Distance in texels from map coordinates `p` to the nearest silhouette: rays along spokes, ring by ring
    /// outward, until the surface steps between one ring and the next. Infinite if none is within reach.
    fn distance(&self, p: DVec2, back: bool) -> f64 {
        let mut spokes = [self.cast(p, back); SILHOUETTE_SPOKES];
        for radius in silhouette_radii() {
            for (number, spoke) in spokes.iter_mut().enumerate() {
                let angle = TAU * number as f64 / SILHOUETTE_SPOKES as f64;
                let ray = self.cast(p + DVec2::from_angle(angle) * (radius * self.geometry.texel()), back);
                if self.is_step(spoke, &ray) {
                    return radius;
                }
                *spoke = ray;
            }
        }
        f64::INFINITY
    }

    fn cast(&self, p: DVec2, back: bool) -> Ray {
        let d = paraboloid::unproject(p);
        let direction = self.view.to_world(d, back);
        let hit = self.reference.nearest(direction, self.view.clip_distance(d));
        Ray { direction, texel_angle: paraboloid::texel_angle(p, self.geometry.texel()), hit }
    }

    fn is_step(&self, one: &Ray, other: &Ray) -> bool {
        match (one.hit, other.hit) {
            (Some(a), Some(b)) => self.is_off(one, a, b.triangle) || self.is_off(other, b, a.triangle),
            (None, None) => false,
            _ => true,
        }
    }

    /// Whether what a ray meets is off another triangle's plane.
    fn is_off(&self, ray: &Ray, hit: Hit, triangle: u32) -> bool {
        let height = self.reference.height(ray.direction * hit.t, triangle).abs();
        height > SILHOUETTE_DEPTH * ray.texel_angle * hit.t
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::ideal::ideal_map;
    use crate::compare::test_shapes::{box_triangles, sheet};
    use glam::DQuat;

    /// A plate in front of one wall of a room that is open upward.
    struct Scene {
        reference: Reference,
        view: View,
        ideal: IdealMap,
        stored: Vec<f32>,
    }

    const GEOMETRY: MapGeometry = MapGeometry { resolution: 128, guard: 0.05 };

    fn scene(range: f64) -> Scene {
        let mut triangles = box_triangles(DVec3::splat(-3.0), DVec3::splat(3.0));
        triangles.retain(|t| !t.iter().all(|corner| corner.y == 3.0));
        triangles.extend(sheet(DVec3::new(-0.5, -0.5, 1.5), DVec3::X, DVec3::Y));
        let orientation = DQuat::from_rotation_x(0.3) * DQuat::from_rotation_y(0.2);
        let view = View { position: DVec3::ZERO, orientation, near: 0.05, range };
        let reference = Reference::new(&triangles, None, view.position);
        let ideal = ideal_map(&reference, &view, GEOMETRY);
        let stored = ideal.depths.iter().map(|&depth| depth as f32).collect();
        Scene { reference, view, ideal, stored }
    }

    impl Scene {
        fn error(&self) -> MapError {
            map_error(&self.stored, &self.ideal, &self.reference, &self.view)
        }

        /// The texel whose centre is nearest to a direction of the world.
        fn texel(&self, direction: DVec3) -> usize {
            let (x, back) = self.view.to_hemisphere(direction);
            let at = GEOMETRY.position(paraboloid::project(x));
            GEOMETRY.index(back, at.x as u32, at.y as u32)
        }
    }

    #[test]
    fn the_ideal_map_has_no_error_but_rounding() {
        let error = scene(f64::INFINITY).error();
        let disc = std::f64::consts::PI * (64.0_f64 - 1.0).powi(2) * 2.0;
        assert!((error.texels as f64 / disc - 1.0).abs() < 0.005, "{error:?}");
        assert_eq!((error.wrong_surface_ppm, error.holes, error.phantoms, error.strays), (0.0, 0, 0, 0));
        assert!(error.depth_error_max > 0.0 && error.depth_error_max < 6e-8, "{error:?}");
    }

    #[test]
    fn holes_phantoms_and_wrong_surfaces_are_told_apart() {
        let mut scene = scene(f64::INFINITY);
        let [wall, sky, floor] = [DVec3::NEG_Z, DVec3::Y, DVec3::NEG_Y].map(|direction| scene.texel(direction));
        scene.stored[wall] = 0.0;
        scene.stored[sky] = 0.01;
        scene.stored[floor] *= 1.2;
        let error = scene.error();
        assert_eq!((error.holes, error.phantoms), (1, 1));
        assert!((error.wrong_surface_ppm * error.texels as f64 - 1e6).abs() < 1e-3, "{error:?}");
        assert_eq!((error.strays, error.silhouette_distance_max), (3, f64::INFINITY));
    }

    #[test]
    fn a_depth_error_within_the_tolerance_is_a_depth_error() {
        let mut scene = scene(f64::INFINITY);
        let floor = scene.texel(DVec3::NEG_Y);
        let (_, i, j) = GEOMETRY.texel_at(floor);
        let footprint = paraboloid::texel_angle(GEOMETRY.centre(i, j), GEOMETRY.texel());
        let exact = scene.stored[floor];
        let cases = [(0.9, true), (-0.9, true), (1.1, false), (-1.1, false)]
            .map(|(share, right)| (share * SURFACE_TOLERANCE, right));
        for (footprints, right) in cases {
            // The floor is met at right angles, so its distance is the one along its normal.
            scene.stored[floor] = (f64::from(exact) / (1.0 - footprints * footprint)) as f32;
            let error = scene.error();
            assert_eq!(error.wrong_surface_ppm == 0.0, right, "{footprints}");
            if right {
                let expected = (1.0 / (1.0 - footprints * footprint) - 1.0).abs();
                assert!((error.depth_error_max - expected).abs() < 1e-6, "{error:?} {expected}");
                assert!(error.depth_error_p99 < 1e-7);
            }
        }
    }

    /// The plate, moved sideways by 0.8 texels: wrong texels along its outline only, and none stray.
    #[test]
    fn wrong_surfaces_at_a_silhouette_are_near_it() {
        let mut scene = scene(f64::INFINITY);
        let turn = DQuat::from_rotation_y(0.8 * paraboloid::texel_angle(DVec2::ZERO, GEOMETRY.texel()));
        let moved = View { orientation: turn * scene.view.orientation, ..scene.view };
        let is_plate = |triangle: u32| triangle >= 10 && triangle != NO_TRIANGLE;
        let plate = |index: usize| is_plate(scene.ideal.triangles[index]);
        let moved = ideal_map(&scene.reference, &moved, GEOMETRY);
        for (index, stored) in scene.stored.iter_mut().enumerate() {
            if is_plate(moved.triangles[index]) != plate(index) {
                *stored = moved.depths[index] as f32;
            }
        }
        let verdicts = judge_texels(&scene.stored, &scene.ideal, &scene.reference, &scene.view);
        let wrong = (0..verdicts.len()).filter(|&i| verdicts[i] == TexelVerdict::WrongSurface).count();
        let outline = (0..verdicts.len()).filter(|&i| plate(i)).count() as f64;
        assert!(wrong as f64 > outline.sqrt(), "{wrong} {outline}");
        let error = scene.error();
        assert_eq!(error.strays, 0, "{error:?}");
        assert!(error.silhouette_distance_max > 0.5 && error.silhouette_distance_max <= 1.0, "{error:?}");
    }

    /// A wall in front of a room, with and without a crack of a hundredth of a texel, a hundredth beside a texel's
    /// centre: the room in that texel is at a silhouette or strays.
    #[test]
    fn a_hairline_crack_is_a_silhouette() {
        let view = View { position: DVec3::ZERO, orientation: DQuat::IDENTITY, near: 0.05, range: f64::INFINITY };
        let p = GEOMETRY.centre(70, 60);
        let texel = GEOMETRY.index(false, 70, 60);
        let d = paraboloid::unproject(p);
        let footprint = 2.0 / d.z * paraboloid::texel_angle(p, GEOMETRY.texel());
        let left = 2.0 * d.x / d.z + 0.01 * footprint;
        for (crack, strays) in [(0.01 * footprint, 0), (0.0, 1)] {
            let mut triangles = box_triangles(DVec3::splat(-3.0), DVec3::splat(3.0));
            triangles.extend(sheet(DVec3::new(-1.0, -1.0, 2.0), DVec3::X * (left + 1.0), DVec3::Y * 2.0));
            triangles.extend(sheet(DVec3::new(left + crack, -1.0, 2.0), DVec3::X * 2.0, DVec3::Y * 2.0));
            let reference = Reference::new(&triangles, None, view.position);
            let ideal = ideal_map(&reference, &view, GEOMETRY);
            let mut stored: Vec<f32> = ideal.depths.iter().map(|&depth| depth as f32).collect();
            stored[texel] *= 2.0 / 3.0;
            assert_eq!(map_error(&stored, &ideal, &reference, &view).strays, strays, "{crack}");
        }
    }

    #[test]
    fn what_is_out_of_range_may_be_in_the_map_or_not() {
        let mut scene = scene(3.5);
        let whole = scene.error();
        let in_range = (0..GEOMETRY.texels()).filter(|&texel| {
            let (_, i, j) = GEOMETRY.texel_at(texel);
            let p = GEOMETRY.centre(i, j);
            let t = 0.05 / scene.ideal.depths[texel] * 0.5 * (1.0 + p.length_squared());
            p.length() <= 1.05 - GEOMETRY.texel() && (t <= 3.5 || scene.ideal.depths[texel] == 0.0)
        });
        assert_eq!((whole.texels, whole.wrong_surface_ppm), (in_range.count(), 0.0));
        let (corner, wall) = (scene.texel(DVec3::new(1.0, -1.0, 1.0)), scene.texel(DVec3::NEG_Z));
        scene.stored[corner] = 0.0;
        assert_eq!(scene.error(), whole);
        scene.stored[corner] = 1.0;
        assert_eq!(scene.error().phantoms, whole.phantoms + 1);
        scene.stored[wall] = 0.0;
        assert_eq!(scene.error().holes, whole.holes + 1);
    }

    #[test]
    fn keys_are_those_of_the_report() {
        let json = serde_json::to_value(MapError::default()).expect("plain numbers");
        let mut keys: Vec<_> = json.as_object().expect("a struct").keys().collect();
        keys.sort();
        let expected =
            "depth_error_max depth_error_median depth_error_p99 holes phantoms strays texels wrong_surface_ppm";
        assert_eq!(keys, expected.split(' ').collect::<Vec<_>>());
    }
}
