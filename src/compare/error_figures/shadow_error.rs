//! What a renderer's lookups answer, against the truth at the same receivers.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use super::per_million;
use super::receivers::Receiver;
use crate::compare::ideal::MapGeometry;
use crate::compare::reference::{Hit, Reference, View};
use crate::paraboloid::double as paraboloid;

/// A wrong answer farther than this from every shadow boundary and crease, in texels, is a far one: the texels that
/// a bilinear lookup reads have their centres within 1.42 texels.
pub const FAR_TEXELS: f64 = 1.5;

/// How far in front of a lit receiver's plane a surface has to stand to count as a crease or an occluder's edge, in
/// texel footprints along the ray.
pub const CREASE_DEPTH: f64 = 0.1;

/// Rings of rays around a wrong sample that look for a boundary, the outermost at [`FAR_TEXELS`].
const RINGS: usize = 12;
/// Rays of the innermost ring; the n-th has n times as many.
const RAYS_OF_FIRST_RING: usize = 8;

/// Figures about the answers at a set of receivers. An answer of 0.5 or more means lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ShadowError {
    /// Number of receivers.
    pub samples: usize,
    /// Share of them that the light truly reaches, from 0 to 1.
    pub lit_fraction: f64,
    /// Wrong answers, in parts per million of all samples: leaks and false shadows.
    pub wrong_ppm: f64,
    /// Answered lit, truly dark.
    pub leak_ppm: f64,
    /// Answered dark, truly lit.
    pub false_shadow_ppm: f64,
    /// Wrong, and farther than [`FAR_TEXELS`] from every true shadow boundary and crease ([`near_boundary`]).
    pub far_wrong_ppm: f64,
}

/// The figures of a method with the floor at its resolution beside them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ShadowReport {
    /// The method's figures.
    #[serde(flatten)]
    pub error: ShadowError,
    /// `wrong_ppm` of the same receivers on a map whose texel centres were ray-cast.
    pub ideal_wrong_ppm: f64,
}

/// Figures about `values`, the answers from 0 (shadow) to 1 (lit) at `receivers`, given the [`super::truth`].
///
/// `geometry` is that of the map that answered; it says how large a texel is.
///
/// # Panics
/// When the three lists differ in length.
#[must_use]
pub fn shadow_error(
    receivers: &[Receiver],
    truth: &[bool],
    values: &[f32],
    reference: &Reference,
    view: &View,
    geometry: &MapGeometry,
) -> ShadowError {
    assert!(receivers.len() == truth.len() && receivers.len() == values.len(), "the lists differ in length");
    let wrong: Vec<usize> = (0..receivers.len()).filter(|&i| (values[i] >= 0.5) != truth[i]).collect();
    let leaks = wrong.iter().filter(|&&i| !truth[i]).count();
    let far = wrong.par_iter().filter(|&&i| !near_boundary(&receivers[i], truth[i], reference, view, geometry)).count();
    let samples = receivers.len();
    let lit = truth.iter().filter(|&&lit| lit).count();
    ShadowError {
        samples,
        lit_fraction: lit as f64 / samples.max(1) as f64,
        wrong_ppm: per_million(wrong.len(), samples),
        leak_ppm: per_million(leaks, samples),
        false_shadow_ppm: per_million(wrong.len() - leaks, samples),
        far_wrong_ppm: per_million(far, samples),
    }
}

/// Whether a true shadow boundary or crease lies within [`FAR_TEXELS`] of a receiver, seen from the light.
///
/// The receiver's plane is what counts, continued beyond its triangle: the lookup compares with that plane, and a
/// crease is where the surface leaves it. Rays of the light, in a disc of directions around the receiver, meet the plane
/// at points of their own; the *gap* there is how far in front of the plane the nearest caster stands, along the ray.
///
/// - For a lit receiver there is a boundary where a gap is more than [`CREASE_DEPTH`] footprints: an occluder's edge, or
///   the neighbouring face of a concave crease. A convex crease alone is no excuse.
/// - For a dark one there is a boundary where the gap is both less than [`CREASE_DEPTH`] footprints and less than half
///   of that at the receiver: the light reaches the plane, or a neighbouring face that leaves it a little. A sheet that stands before the receiver at an even gap, however thin, makes none: to
///   leak there is a far error.
///
/// The rays are a sample of the disc: they may miss a boundary, which makes a figure of far errors too high, and never
/// find one that isn't there.
#[must_use]
pub fn near_boundary(
    receiver: &Receiver,
    lit: bool,
    reference: &Reference,
    view: &View,
    geometry: &MapGeometry,
) -> bool {
    boundary_within(FAR_TEXELS, receiver, lit, reference, view, geometry)
}

/// [`near_boundary`] for another distance, in texels.
#[must_use]
pub fn boundary_within(
    reach: f64,
    receiver: &Receiver,
    lit: bool,
    reference: &Reference,
    view: &View,
    geometry: &MapGeometry,
) -> bool {
    let search = BoundarySearch::new(receiver, lit, reference, view, geometry);
    let p = search.plane.p;
    nearby_texel_centres(p, geometry, reach).chain(nearby_rings(p, geometry, reach)).any(|q| search.is_other_side(q))
}

struct BoundarySearch<'a> {
    receiver: &'a Receiver,
    lit: bool,
    reference: &'a Reference,
    view: &'a View,
    texel: f64,
    plane: Plane,
    /// Half of the gap in front of the receiver itself, relative to its distance; infinite if nothing stands there.
    half_gap: f64,
}

impl<'a> BoundarySearch<'a> {
    fn new(
        receiver: &'a Receiver,
        lit: bool,
        reference: &'a Reference,
        view: &'a View,
        geometry: &MapGeometry,
    ) -> Self {
        let plane = Plane::new(receiver, reference, view);
        let mut search =
            Self { receiver, lit, reference, view, texel: geometry.texel(), plane, half_gap: f64::INFINITY };
        search.half_gap = search.relative_gap(search.plane.p).map_or(f64::INFINITY, |gap| 0.5 * gap);
        search
    }

    /// The ray at map coordinates `q`: its direction in world axes, and where it meets the plane, if the map holds that.
    fn meets_plane(&self, q: DVec2) -> Option<(DVec3, f64)> {
        let d = paraboloid::unproject(q);
        let t = self.plane.distance_along(d).filter(|&t| t >= self.clip_distance(q))?;
        Some((self.view.to_world(d, self.plane.back), t))
    }

    fn clip_distance(&self, q: DVec2) -> f64 {
        self.view.clip_distance(paraboloid::unproject(q))
    }

    /// The gap at map coordinates `q`, relative to the plane's distance there. Zero if nothing stands before the plane,
    /// and for a surface that the plane's point lies on within the receiver's rounding: that one is the receiver's own.
    fn relative_gap(&self, q: DVec2) -> Option<f64> {
        let (direction, t) = self.meets_plane(q)?;
        let slack = self.receiver.slack(self.view.position);
        let is_own = |hit: &Hit| {
            hit.triangle == self.receiver.triangle
                || self.reference.lies_on(direction * t, t - hit.t, hit.triangle, slack)
        };
        let front = self.reference.nearest(direction, self.clip_distance(q)).filter(|hit| hit.t < t && !is_own(hit));
        Some(front.map_or(0.0, |hit| 1.0 - hit.t / t))
    }

    /// Whether the plane's point at `q` is dark for a lit receiver, or lit for a dark one.
    fn is_other_side(&self, q: DVec2) -> bool {
        let Some(gap) = self.relative_gap(q) else { return false };
        let crease = CREASE_DEPTH * paraboloid::texel_angle(q, self.texel);
        if self.lit { gap > crease } else { gap < crease.min(self.half_gap) }
    }
}

/// A receiver's plane in the space of its hemisphere.
struct Plane {
    back: bool,
    /// Map coordinates of the receiver.
    p: DVec2,
    normal: DVec3,
    /// Signed distance of the plane from the light.
    distance: f64,
}

impl Plane {
    fn new(receiver: &Receiver, reference: &Reference, view: &View) -> Self {
        let (x, back) = view.to_hemisphere(receiver.relative(view.position));
        let normal = view.orientation.inverse() * reference.normal(receiver.triangle);
        let normal = paraboloid::to_hemisphere(normal, back);
        Self { back, p: paraboloid::project(x), normal, distance: normal.dot(x) }
    }

    /// Where the ray along a unit direction meets the plane, if it does.
    fn distance_along(&self, d: DVec3) -> Option<f64> {
        let t = self.distance / self.normal.dot(d);
        (t > 0.0 && t.is_finite()).then_some(t)
    }
}

/// Centres of the texels that a lookup at `p` or close by reads; of wide kernels, those in the middle.
fn nearby_texel_centres(p: DVec2, geometry: &MapGeometry, reach: f64) -> impl Iterator<Item = DVec2> {
    let texel = geometry.texel();
    let offset = geometry.position(p).fract() - 0.5;
    let side = reach.ceil().min(6.0) as i32;
    let around =
        (-side..=side).flat_map(move |row| (-side..=side).map(move |column| DVec2::new(column.into(), row.into())));
    around
        .map(move |cell| cell - offset)
        .filter(move |from_p| from_p.length() <= reach)
        .map(move |from_p| p + DVec2::new(from_p.x, -from_p.y) * texel)
}

/// Rings around `p` that fill the disc evenly.
fn nearby_rings(p: DVec2, geometry: &MapGeometry, reach: f64) -> impl Iterator<Item = DVec2> {
    let reach = reach * geometry.texel();
    (1..=RINGS).flat_map(move |ring| {
        let rays = RAYS_OF_FIRST_RING * ring;
        let radius = reach * ring as f64 / RINGS as f64;
        (0..rays).map(move |ray| p + DVec2::from_angle(TAU * ray as f64 / rays as f64) * radius)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::error_figures::{ideal_shadows, sample_receivers, truth};
    use crate::compare::ideal::{Lookup, ideal_map};
    use crate::compare::test_shapes::{box_triangles, random_vector, sheet};
    use glam::{DQuat, Vec3};
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    const GEOMETRY: MapGeometry = MapGeometry { resolution: 256, guard: 0.05 };

    fn view(orientation: DQuat) -> View {
        View { position: DVec3::ZERO, orientation, near: 0.01, range: f64::INFINITY }
    }

    fn receiver(reference: &Reference, triangle: u32, position: DVec3) -> Receiver {
        let rounded = position.as_vec3();
        let normal: Vec3 = reference.normal(triangle).as_vec3();
        Receiver { position: rounded, normal, triangle, rounding: rounded.as_dvec3().distance(position) }
    }

    #[test]
    fn counts_are_of_all_samples() {
        let reference = Reference::new(&box_triangles(DVec3::NEG_ONE, DVec3::ONE), None, DVec3::ZERO);
        let view = view(DQuat::IDENTITY);
        let receivers = sample_receivers(&reference, &view, 1000, 1);
        let lit: Vec<bool> = (0..1000).map(|i| i % 4 != 0).collect();
        let mut values: Vec<f32> = lit.iter().map(|&lit| if lit { 0.5 } else { 0.49 }).collect();
        let none = shadow_error(&receivers, &lit, &values, &reference, &view, &GEOMETRY);
        let expected = ShadowError { samples: 1000, lit_fraction: 0.75, ..ShadowError::default() };
        assert_eq!(none, expected);
        values[0] = 0.5;
        values[4] = 1.0;
        values[5] = 0.49;
        let some = shadow_error(&receivers, &lit, &values, &reference, &view, &GEOMETRY);
        assert_eq!((some.wrong_ppm, some.leak_ppm, some.false_shadow_ppm), (3000.0, 2000.0, 1000.0));
    }

    /// The shadow of a plate on a floor, at receivers all over the floor: a boundary is near where the outline's
    /// projection is.
    #[test]
    fn boundaries_are_found_where_they_are() {
        let mut scene = sheet(DVec3::new(-30.0, -2.0, -30.0), DVec3::X * 60.0, DVec3::Z * 60.0);
        scene.extend(sheet(DVec3::new(-0.4, -1.0, -0.3), DVec3::X * 0.9, DVec3::new(0.2, 0.1, 0.8)));
        let reference = Reference::new(&scene, None, DVec3::ZERO);
        let view = view(DQuat::from_rotation_z(0.4) * DQuat::from_rotation_x(0.9));
        let [a, b, c] = reference.triangles()[2];
        let outline = [a, b, c, reference.triangles()[3][2]];
        let mut near_ones = [0, 0];
        for receiver in sample_receivers(&reference, &view, 10_000, 2).iter().filter(|r| r.triangle < 2) {
            let (x, back) = view.to_hemisphere(receiver.relative(DVec3::ZERO));
            let p = paraboloid::project(x);
            let distance = (0..4000)
                .map(|i| outline[i / 1000].lerp(outline[(i / 1000 + 1) % 4], f64::from(i as u32 % 1000) * 1e-3))
                .map(|point| paraboloid::project(paraboloid::to_hemisphere(view.orientation.inverse() * point, back)))
                .map(|q| p.distance(q) / GEOMETRY.texel())
                .fold(f64::INFINITY, f64::min);
            let lit = truth(&[*receiver], &reference, &view)[0];
            if (distance - FAR_TEXELS).abs() > 0.06 {
                let near = near_boundary(receiver, lit, &reference, &view, &GEOMETRY);
                assert_eq!(near, distance < FAR_TEXELS, "{lit} {distance} {p}");
                near_ones[usize::from(lit)] += usize::from(near);
            }
        }
        assert!(near_ones.iter().all(|&count| count > 20), "{near_ones:?}");
    }

    /// In a lit room, a wall's receivers have a crease near them next to the corner, and none elsewhere; outside of a
    /// box, its convex edges are none.
    #[test]
    fn concave_creases_count_and_convex_ones_do_not() {
        let room = Reference::new(&box_triangles(DVec3::splat(-2.0), DVec3::splat(2.0)), None, DVec3::ZERO);
        let view = view(DQuat::from_rotation_x(0.5));
        let near = |reference: &Reference, triangle, position| {
            near_boundary(&receiver(reference, triangle, position), true, reference, &view, &GEOMETRY)
        };
        let floor = (0..12).find(|&t| room.triangles()[t as usize].iter().all(|c| c.y == -2.0)).expect("a floor");
        assert!(!near(&room, floor, DVec3::new(0.3, -2.0, 0.2)));
        assert!(!near(&room, floor, DVec3::new(1.8, -2.0, 0.2)));
        assert!(near(&room, floor, DVec3::new(1.99, -2.0, 0.2)));
        let below = DVec3::new(0.0, -3.0, 0.0);
        let block = Reference::new(&box_triangles(below - 0.5, below + 0.5), None, DVec3::ZERO);
        let lid = (0..12).find(|&t| block.triangles()[t as usize].iter().all(|c| c.y == -2.5)).expect("a lid");
        assert!(!near(&block, lid, DVec3::new(0.499, -2.5, 0.1)));
    }

    /// Sheets a hair apart: a leak in the lower one is far from any boundary, and is said to be.
    #[test]
    fn a_leak_through_a_thin_gap_is_far() {
        let floor = |y: f64| sheet(DVec3::new(-5.0, y, -5.0), DVec3::X * 10.0, DVec3::Z * 10.0);
        let reference = Reference::new(&[floor(-2.0), floor(-2.0 - 1e-4)].concat(), None, DVec3::ZERO);
        let view = view(DQuat::IDENTITY);
        let receivers = [receiver(&reference, 2, DVec3::new(0.3, -2.0 - 1e-4, 0.1))];
        let lit = truth(&receivers, &reference, &view);
        assert_eq!(lit, [false]);
        let error = shadow_error(&receivers, &lit, &[1.0], &reference, &view, &GEOMETRY);
        assert_eq!((error.leak_ppm, error.far_wrong_ppm), (1e6, 1e6));
    }

    /// A plate's edge right above a concave crease of one degree: one face all dark, the other all lit. A dark receiver
    /// close to the crease is close to the boundary, although the lit face hides the plane of its own.
    #[test]
    fn a_boundary_on_the_neighbouring_face_counts() {
        let floor = sheet(DVec3::new(0.0, -2.0, -5.0), DVec3::X * 5.0, DVec3::Z * 10.0);
        let rising = sheet(DVec3::new(0.0, -2.0, -5.0), DVec3::new(-5.0, 5.0 * 0.0175, 0.0), DVec3::Z * 10.0);
        let plate = sheet(DVec3::new(0.0, -1.0, -5.0), DVec3::X * 5.0, DVec3::Z * 10.0);
        let reference = Reference::new(&[floor, rising, plate].concat(), None, DVec3::ZERO);
        let view = view(DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2));
        let texel = 2.0 * paraboloid::texel_angle(DVec2::ZERO, GEOMETRY.texel());
        for (texels, near) in [(1.0, true), (2.0, false)] {
            let receiver = receiver(&reference, 0, DVec3::new(texels * texel, -2.0, 0.1));
            assert_eq!(truth(&[receiver], &reference, &view), [false]);
            assert_eq!(near_boundary(&receiver, false, &reference, &view, &GEOMETRY), near, "{texels}");
        }
    }

    /// The twin of the lookup on a ray-cast map of a room with boxes, in random orientations: wrong next to boundaries
    /// only, and the less the finer the map.
    #[test]
    fn the_ideal_is_wrong_next_to_boundaries_only() {
        let mut random = Pcg64::seed_from_u64(9);
        let mut scene = box_triangles(DVec3::splat(-4.0), DVec3::splat(4.0));
        for _ in 0..20 {
            let turn = DQuat::from_scaled_axis(random_vector(&mut random) * 3.0);
            let size = DVec3::from_array(std::array::from_fn(|_| random.random_range(0.05..0.5)));
            let mut at = random_vector(&mut random) * 3.5;
            if at.length() < 1.2 {
                at = at.normalize() * 1.2;
            }
            scene.extend(box_triangles(-size, size).iter().map(|t| t.map(|corner| at + turn * corner)));
        }
        let reference = Reference::new(&scene, None, DVec3::ZERO);
        for _ in 0..3 {
            let view = view(DQuat::from_scaled_axis(random_vector(&mut random) * 3.0));
            let receivers = sample_receivers(&reference, &view, 50_000, 11);
            let lit = truth(&receivers, &reference, &view);
            let error_at = |resolution, bias| {
                let geometry = MapGeometry { resolution, guard: 0.05 };
                let map = ideal_map(&reference, &view, geometry);
                let values = ideal_shadows(&receivers, &map, &Lookup { view, geometry, bias, tolerance: 0.0 });
                shadow_error(&receivers, &lit, &values, &reference, &view, &geometry)
            };
            let (coarse, fine) = (error_at(128, 0.35), error_at(512, 0.35));
            assert_eq!((coarse.far_wrong_ppm, fine.far_wrong_ppm), (0.0, 0.0), "{coarse:?} {fine:?}");
            assert!(fine.wrong_ppm > 0.0 && fine.wrong_ppm < 0.4 * coarse.wrong_ppm, "{coarse:?} {fine:?}");
            assert!(coarse.wrong_ppm < 30_000.0 && (0.2..0.9).contains(&coarse.lit_fraction), "{coarse:?}");
        }
    }

    /// A tilted plane of small triangles, so far from the origin that rounding moves receivers by more than the depth of
    /// a crease: still no boundary.
    #[test]
    fn rounding_makes_no_boundaries() {
        let offset = DVec3::new(1e5, 1e5, -1e5);
        let turn = DQuat::from_scaled_axis(DVec3::new(0.4, 0.1, 0.3));
        let at = |i: i32, j: i32| offset + turn * DVec3::new(f64::from(i) * 0.1, -2.0, f64::from(j) * 0.1);
        let scene: Vec<_> = (-30..30)
            .flat_map(|i| (-30..30).map(move |j| (i, j)))
            .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]])
            .collect();
        let reference = Reference::new(&scene, None, offset);
        let view = View { position: offset, ..view(DQuat::IDENTITY) };
        let receivers = sample_receivers(&reference, &view, 5000, 4);
        let geometry = MapGeometry { resolution: 1024, guard: 0.05 };
        assert!(receivers.iter().any(|receiver| receiver.rounding > 0.003));
        for (receiver, lit) in receivers.iter().zip(truth(&receivers, &reference, &view)) {
            assert!(lit && !near_boundary(receiver, true, &reference, &view, &geometry), "{receiver:?}");
        }
    }

    /// A map that stands before its surfaces by two texel footprints shadows them far from any boundary.
    #[test]
    fn acne_is_far() {
        let reference = Reference::new(&box_triangles(DVec3::splat(-4.0), DVec3::splat(4.0)), None, DVec3::ZERO);
        let view = view(DQuat::from_rotation_x(0.3));
        let receivers = sample_receivers(&reference, &view, 1000, 11);
        let lit = truth(&receivers, &reference, &view);
        let mut map = ideal_map(&reference, &view, GEOMETRY);
        for depth in &mut map.depths {
            *depth *= 1.0 + 4.0 * GEOMETRY.texel();
        }
        let values = ideal_shadows(&receivers, &map, &Lookup { view, geometry: GEOMETRY, bias: 0.2, tolerance: 0.0 });
        let error = shadow_error(&receivers, &lit, &values, &reference, &view, &GEOMETRY);
        assert!(error.false_shadow_ppm > 900_000.0 && error.far_wrong_ppm > 800_000.0, "{error:?}");
    }

    #[test]
    fn keys_are_those_of_the_report() {
        let json = serde_json::to_value(ShadowReport::default()).expect("plain numbers");
        let mut keys: Vec<_> = json.as_object().expect("a struct").keys().collect();
        keys.sort();
        let expected = "false_shadow_ppm far_wrong_ppm ideal_wrong_ppm leak_ppm lit_fraction samples wrong_ppm";
        assert_eq!(keys, expected.split(' ').collect::<Vec<_>>());
    }
}
