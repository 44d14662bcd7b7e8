//! What a renderer's lookups answer, against the truth at the same receivers.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::per_million;
use super::receivers::Receiver;
use crate::compare::ideal::MapGeometry;
use crate::compare::reference::{Hit, Reference, View};
use crate::paraboloid::double as paraboloid;

/// The pair in whose texels distances are published, whatever map answered: without guard bands, 1024 texels across.
pub const PUBLISHED_PAIR: MapGeometry = MapGeometry { resolution: 1024, guard: 0.0 };

/// A wrong answer farther than this from every shadow boundary is a far one, in texels of [`PUBLISHED_PAIR`]: the texels
/// that a bilinear lookup reads have their centres within 1.42 texels.
pub const FAR_TEXELS: f64 = 1.5;

/// How far apart two surfaces have to stand for the nearer one's edge to be a shadow boundary on the other, in texel
/// footprints along the ray.
pub const BOUNDARY_DEPTH: f64 = 0.1;

/// How often the stretch between two rays is halved to tell a step in depth from a slope.
const HALVINGS: usize = 24;

/// Rings of rays around a wrong sample that look for a boundary, the outermost at [`FAR_TEXELS`].
const RINGS: usize = 12;
/// Rays of the innermost ring; the n-th has n times as many.
const RAYS_OF_FIRST_RING: usize = 8;

/// Figures about the answers at a set of receivers. An answer of 0.5 or more means lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct ShadowError {
    /// Number of receivers that count ([`Receiver::counts`]).
    pub samples: usize,
    /// Share of them that the light truly reaches, from 0 to 1.
    pub lit_fraction: f64,
    /// Wrong answers, in parts per million of all samples: leaks and false shadows.
    pub wrong_ppm: f64,
    /// Wrong answers, grazing ones too, each weighed by its cosine with the direction to the light, in parts per million
    /// of the weight of all.
    pub wrong_energy_ppm: f64,
    /// Answered lit, truly dark.
    pub leak_ppm: f64,
    /// Answered dark, truly lit.
    pub false_shadow_ppm: f64,
    /// Wrong, and farther than [`FAR_TEXELS`] from every true shadow boundary ([`near_boundary`]).
    pub far_wrong_ppm: f64,
    /// Share of the samples on backs of double-sided triangles, from 0 to 1.
    pub back_fraction: f64,
    /// Wrong answers on fronts, in parts per million of the samples there.
    pub wrong_front_ppm: f64,
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
/// # Panics
/// When the three lists differ in length.
#[must_use]
pub fn shadow_error(
    receivers: &[Receiver],
    truth: &[bool],
    values: &[f32],
    reference: &Reference,
    view: &View,
) -> ShadowError {
    assert!(receivers.len() == truth.len() && receivers.len() == values.len(), "the lists differ in length");
    let counted: Vec<usize> = (0..receivers.len()).filter(|&i| receivers[i].counts(view.position)).collect();
    let wrong: Vec<usize> = counted.iter().copied().filter(|&i| (values[i] >= 0.5) != truth[i]).collect();
    let leaks = wrong.iter().filter(|&&i| !truth[i]).count();
    let is_far = |&&i: &&usize| !near_boundary(&receivers[i], truth[i], reference, view, &PUBLISHED_PAIR);
    let far = wrong.par_iter().filter(is_far).count();
    let samples = counted.len();
    let lit = counted.iter().filter(|&&i| truth[i]).count();
    let is_front = |&&i: &&usize| reference.shows_front(receivers[i].triangle, DVec3::ZERO);
    let fronts = counted.iter().filter(is_front).count();
    let wrong_fronts = wrong.iter().filter(is_front).count();
    ShadowError {
        samples,
        lit_fraction: lit as f64 / samples.max(1) as f64,
        wrong_ppm: per_million(wrong.len(), samples),
        wrong_energy_ppm: energy_ppm(receivers, truth, values, view.position),
        leak_ppm: per_million(leaks, samples),
        false_shadow_ppm: per_million(wrong.len() - leaks, samples),
        far_wrong_ppm: per_million(far, samples),
        back_fraction: (samples - fronts) as f64 / samples.max(1) as f64,
        wrong_front_ppm: per_million(wrong_fronts, fronts),
    }
}

/// Wrong answers in parts per million, each weighed by its receiver's cosine with the direction to the light, with no
/// cut-off: receivers are drawn by area over distance squared, so this is the share of the light's energy.
#[must_use]
pub fn energy_ppm(receivers: &[Receiver], truth: &[bool], values: &[f32], light_position: DVec3) -> f64 {
    let (mut wrong, mut all) = (0.0, 0.0);
    for ((receiver, lit), value) in receivers.iter().zip(truth).zip(values) {
        // Rounding may turn what is all but edge-on away from the light.
        let energy = receiver.incidence(light_position).max(0.0);
        all += energy;
        wrong += if (*value >= 0.5) == *lit { 0.0 } else { energy };
    }
    if all > 0.0 { 1e6 * wrong / all } else { 0.0 }
}

/// Whether a true shadow boundary lies within [`FAR_TEXELS`] of a receiver, seen from the light, in texels of a map of this
/// geometry; published figures are in those of [`PUBLISHED_PAIR`].
///
/// The receiver's plane is what counts, continued beyond its triangle: the lookup compares with that plane. Rays of
/// the light, in a disc of directions around the receiver, meet the plane at points of their own; the *gap* there is how
/// far in front of the plane the nearest caster stands, along the ray.
///
/// - For a lit receiver there is a boundary where the gap *steps* by more than [`BOUNDARY_DEPTH`] footprints: an
///   occluder's edge. A gap that grows steadily is the neighbouring face of a crease, and no boundary. Nor is the edge of
///   the receiver's own surface, since nothing stands before its plane.
/// - For a dark one there is a boundary where the gap is both less than [`BOUNDARY_DEPTH`] footprints and less than half
///   of that at the receiver: the occluder ends there, and the light reaches the plane or a neighbouring face that leaves
///   it a little. A sheet that stands before the receiver at an even gap, however thin, makes none: to leak there is a
///   far error.
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
    let search = BoundarySearch::new(receiver, lit, reference, view, geometry);
    if lit { search.steps_within(FAR_TEXELS) } else { search.any_within(FAR_TEXELS, |q| search.is_reached(q)) }
}

/// Whether all that a kernel of this reach sees is as lit, or as dark, as the receiver: no boundary ([`near_boundary`]) is
/// within `reach` texels of a map, and for a lit one no neighbouring face of a crease, which stands before its plane.
#[must_use]
pub(super) fn is_even_within(
    reach: f64,
    receiver: &Receiver,
    lit: bool,
    reference: &Reference,
    view: &View,
    geometry: &MapGeometry,
) -> bool {
    let search = BoundarySearch::new(receiver, lit, reference, view, geometry);
    !search.any_within(reach, |q| if lit { search.is_covered(q) } else { search.is_reached(q) })
}

struct BoundarySearch<'a> {
    receiver: &'a Receiver,
    reference: &'a Reference,
    view: &'a View,
    geometry: &'a MapGeometry,
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
        geometry: &'a MapGeometry,
    ) -> Self {
        let plane = Plane::new(receiver, reference, view);
        let mut search = Self { receiver, reference, view, geometry, plane, half_gap: f64::INFINITY };
        if !lit {
            search.half_gap = search.relative_gap(search.plane.p).map_or(f64::INFINITY, |gap| 0.5 * gap);
        }
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

    /// [`BOUNDARY_DEPTH`] at map coordinates `q`, relative to the distance.
    fn boundary_depth(&self, q: DVec2) -> f64 {
        BOUNDARY_DEPTH * paraboloid::texel_angle(q, self.geometry.texel())
    }

    /// Whether something stands before the plane at `q`.
    fn is_covered(&self, q: DVec2) -> bool {
        self.relative_gap(q).is_some_and(|gap| gap > self.boundary_depth(q))
    }

    /// Whether the light reaches the plane at `q`, or a face close to it, past what hides a dark receiver.
    fn is_reached(&self, q: DVec2) -> bool {
        self.relative_gap(q).is_some_and(|gap| gap < self.boundary_depth(q).min(self.half_gap))
    }

    fn any_within(&self, reach: f64, found: impl Fn(DVec2) -> bool) -> bool {
        let p = self.plane.p;
        let rings = (1..=RINGS).flat_map(|ring| self.ring(ring, reach));
        nearby_texel_centres(p, self.geometry, reach).chain(rings).any(found)
    }

    /// Whether the gap steps anywhere around a lit receiver: between it and a ray, or between the neighbours of a ring.
    fn steps_within(&self, reach: f64) -> bool {
        let known = |q| Some((q, self.relative_gap(q)?));
        let here = (self.plane.p, 0.0);
        let spokes = nearby_texel_centres(here.0, self.geometry, reach)
            .any(|q| known(q).is_some_and(|there| self.is_step(here, there)));
        spokes
            || (1..=RINGS).any(|number| {
                let ring: Vec<_> = self.ring(number, reach).map(known).collect();
                let neighbours = ring.iter().zip(ring.iter().cycle().skip(1));
                neighbours.filter_map(|(one, other)| (*one).zip(*other)).any(|(one, other)| self.is_step(one, other))
            })
    }

    /// Whether the gap steps between two places with a gap each: halves of the stretch, each time the one that it differs
    /// over more, keep a step and divide a slope.
    fn is_step(&self, mut one: (DVec2, f64), mut other: (DVec2, f64)) -> bool {
        // A surface within the receiver's rounding is its own; where it stops being that, the gap steps by so much.
        let light = self.view.position;
        let slack = 50.0 * self.receiver.slack(light) / self.receiver.relative(light).length();
        let least = self.boundary_depth(one.0).max(slack);
        for _ in 0..HALVINGS {
            if (one.1 - other.1).abs() <= least {
                return false;
            }
            let q = 0.5 * (one.0 + other.0);
            let Some(gap) = self.relative_gap(q) else { return false };
            if (one.1 - gap).abs() >= (gap - other.1).abs() {
                other = (q, gap);
            } else {
                one = (q, gap);
            }
        }
        true
    }

    /// Map coordinates around the receiver; the rings together fill the disc evenly.
    fn ring(&self, number: usize, reach: f64) -> impl Iterator<Item = DVec2> {
        let (p, rays) = (self.plane.p, RAYS_OF_FIRST_RING * number);
        let radius = reach * self.geometry.texel() * number as f64 / RINGS as f64;
        (0..rays).map(move |ray| p + DVec2::from_angle(TAU * ray as f64 / rays as f64) * radius)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::error_figures::{sample_receivers, truth};
    use crate::compare::ideal::{IdealMap, Lookup, ideal_map};
    use crate::compare::test_shapes::{box_triangles, random_vector, sheet};
    use glam::{DQuat, Vec3};
    use rand::{Rng, SeedableRng};
    use rand_pcg::Pcg64;

    const GEOMETRY: MapGeometry = MapGeometry { resolution: 256, guard: 0.05 };

    fn ideal_answers(receivers: &[Receiver], map: &IdealMap, lookup: &Lookup) -> Vec<f32> {
        let answer = |receiver: &Receiver| {
            let (position, normal) = (receiver.position.as_dvec3(), receiver.normal.as_dvec3());
            lookup.shadow(|texel| map.depths[texel], position, normal) as f32
        };
        receivers.iter().map(answer).collect()
    }

    fn view(orientation: DQuat) -> View {
        View { position: DVec3::ZERO, orientation, near: 0.01, range: f64::INFINITY }
    }

    fn receiver(reference: &Reference, triangle: u32, position: DVec3) -> Receiver {
        let rounded = position.as_vec3();
        let normal: Vec3 = reference.normal(triangle).as_vec3();
        let normal = if normal.dot(rounded) < 0.0 { normal } else { -normal };
        Receiver { position: rounded, normal, triangle, rounding: rounded.as_dvec3().distance(position) }
    }

    #[test]
    fn counts_are_of_all_that_count() {
        let reference = Reference::new(&box_triangles(DVec3::NEG_ONE, DVec3::ONE), None, DVec3::ZERO);
        let view = view(DQuat::IDENTITY);
        let mut receivers = sample_receivers(&reference, &view, 1000, 1);
        // One that grazes: its answer doesn't count, and its energy is next to nothing.
        receivers.push(Receiver { normal: Vec3::new(0.0, -0.01, 1.0), ..receiver(&reference, 0, DVec3::Y) });
        let lit: Vec<bool> = (0..1001).map(|i| i % 4 != 0).collect();
        let mut values: Vec<f32> = lit.iter().map(|&lit| if lit { 0.5 } else { 0.49 }).collect();
        let error = |values: &[f32]| shadow_error(&receivers, &lit, values, &reference, &view);
        let expected = ShadowError { samples: 1000, lit_fraction: 0.75, ..ShadowError::default() };
        assert_eq!(error(&values), expected);
        values[1000] = 1.0 - values[1000];
        let grazing = error(&values);
        assert_eq!(grazing.wrong_ppm, 0.0);
        assert!(grazing.wrong_energy_ppm > 5.0 && grazing.wrong_energy_ppm < 20.0, "{grazing:?}");
        values[0] = 0.5;
        values[4] = 1.0;
        values[5] = 0.49;
        let some = error(&values);
        assert_eq!((some.wrong_ppm, some.leak_ppm, some.false_shadow_ppm), (3000.0, 2000.0, 1000.0));
    }

    /// Two floors, one square to the light and one at a cosine of a half, wrong on the slanted one: a third of the energy.
    #[test]
    fn energy_goes_by_the_cosine() {
        let slanted = Vec3::new(0.75f32.sqrt(), 0.5, 0.0);
        let receivers = [Vec3::Y, slanted].map(|normal| Receiver {
            position: Vec3::new(0.0, -2.0, 0.0),
            normal,
            triangle: 0,
            rounding: 0.0,
        });
        for (lit, values, expected) in [
            ([true, true], [1.0, 0.0], 1e6 / 3.0),
            ([true, false], [0.49, 0.49], 2e6 / 3.0),
            ([true, false], [0.5, 0.0], 0.0),
            ([false, false], [0.5, 0.5], 1e6),
        ] {
            let found = energy_ppm(&receivers, &lit, &values, DVec3::ZERO);
            assert!((found - expected).abs() < 0.1, "{found} {expected}");
        }
        assert_eq!(energy_ppm(&[], &[], &[], DVec3::ZERO), 0.0);
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
        for receiver in sample_receivers(&reference, &view, 40_000, 2).iter().filter(|r| r.triangle < 2) {
            let (x, back) = view.to_hemisphere(receiver.relative(DVec3::ZERO));
            let p = paraboloid::project(x);
            let distance = (0..4000)
                .map(|i| outline[i / 1000].lerp(outline[(i / 1000 + 1) % 4], f64::from(i as u32 % 1000) * 1e-3))
                .map(|point| paraboloid::project(paraboloid::to_hemisphere(view.orientation.inverse() * point, back)))
                .map(|q| p.distance(q) / PUBLISHED_PAIR.texel())
                .fold(f64::INFINITY, f64::min);
            let lit = truth(&[*receiver], &reference, &view)[0];
            if (distance - FAR_TEXELS).abs() > 0.06 {
                let near = near_boundary(receiver, lit, &reference, &view, &PUBLISHED_PAIR);
                assert_eq!(near, distance < FAR_TEXELS, "{lit} {distance} {p}");
                near_ones[usize::from(lit)] += usize::from(near);
            }
        }
        assert!(near_ones.iter().all(|&count| count > 20), "{near_ones:?}");
    }

    /// In a lit room the corners are no boundaries, nor are a box's own edges; the edge of a plate before the wall is one.
    #[test]
    fn creases_are_no_boundaries() {
        let room = box_triangles(DVec3::splat(-2.0), DVec3::splat(2.0));
        let plate = sheet(DVec3::new(1.9, -1.0, -0.5), DVec3::Y, DVec3::Z);
        let room = Reference::new(&[room, plate].concat(), None, DVec3::ZERO);
        let view = view(DQuat::from_rotation_x(0.5));
        let texel = PUBLISHED_PAIR.texel();
        let find = |reference: &Reference, triangle, position| {
            let receiver = receiver(reference, triangle, position);
            assert_eq!(truth(&[receiver], reference, &view), [true]);
            let even = is_even_within(FAR_TEXELS, &receiver, true, reference, &view, &PUBLISHED_PAIR);
            (near_boundary(&receiver, true, reference, &view, &PUBLISHED_PAIR), even)
        };
        let side = |axis: usize, at: f64| {
            (0..12).find(|&t| room.triangles()[t as usize].iter().all(|c| c[axis] == at)).expect("a side")
        };
        assert_eq!(find(&room, side(1, -2.0), DVec3::new(0.3, -2.0, 0.2)), (false, true));
        assert_eq!(find(&room, side(1, -2.0), DVec3::new(2.0 - texel, -2.0, 0.2)), (false, false), "a crease");
        // The plate's upper edge, in the plane of the light, throws its shadow's end there.
        assert_eq!(find(&room, side(0, 2.0), DVec3::new(2.0, texel, 0.1)), (true, false), "an occluder's edge");
        assert_eq!(find(&room, side(0, 2.0), DVec3::new(2.0, 0.1, 0.1)), (false, true));
        let below = DVec3::new(0.0, -3.0, 0.0);
        let block = Reference::new(&box_triangles(below - 0.5, below + 0.5), None, DVec3::ZERO);
        let lid = (0..12).find(|&t| block.triangles()[t as usize].iter().all(|c| c.y == -2.5)).expect("a lid");
        assert_eq!(find(&block, lid, DVec3::new(0.4999, -2.5, 0.1)), (false, true), "its own edge");
    }

    /// A kerb of half a texel on a floor: what rises steadily from the receiver is a crease, what drops behind it an edge.
    #[test]
    fn the_far_edge_of_a_kerb_is_a_boundary() {
        let texel = 2.0 * paraboloid::texel_angle(DVec2::ZERO, PUBLISHED_PAIR.texel());
        let view = view(DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2));
        let floor = sheet(DVec3::new(-5.0, -2.0, -5.0), DVec3::X * 10.0, DVec3::Z * 10.0);
        for (width, near) in [(0.5, true), (4.0, false)] {
            let (low, high) = (DVec3::new(1.0, -3.0, -5.0), DVec3::new(1.0 + width * texel, -2.0 + 2.0 * texel, 5.0));
            let reference = Reference::new(&[floor.clone(), box_triangles(low, high)].concat(), None, DVec3::ZERO);
            let before = (0..2).map(|t| receiver(&reference, t, DVec3::new(1.0 - 0.2 * texel, -2.0, 0.1)));
            for receiver in before {
                assert_eq!(truth(&[receiver], &reference, &view), [true]);
                assert_eq!(near_boundary(&receiver, true, &reference, &view, &PUBLISHED_PAIR), near, "{width}");
            }
        }
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
        let error = shadow_error(&receivers, &lit, &[1.0], &reference, &view);
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
        let texel = 2.0 * paraboloid::texel_angle(DVec2::ZERO, PUBLISHED_PAIR.texel());
        for (texels, near) in [(1.0, true), (2.0, false)] {
            let receiver = receiver(&reference, 0, DVec3::new(texels * texel, -2.0, 0.1));
            assert_eq!(truth(&[receiver], &reference, &view), [false]);
            assert_eq!(near_boundary(&receiver, false, &reference, &view, &PUBLISHED_PAIR), near, "{texels}");
        }
    }

    /// The twin of the lookup on a ray-cast map of a room with boxes apart from each other, in random orientations: wrong
    /// next to boundaries only, and the less the finer the map. Texels of a coarser map reach farther than far is.
    #[test]
    fn the_ideal_is_wrong_next_to_boundaries_only() {
        let mut random = Pcg64::seed_from_u64(9);
        let mut scene = box_triangles(DVec3::splat(-4.0), DVec3::splat(4.0));
        let mut places: Vec<DVec3> = Vec::new();
        while places.len() < 20 {
            let at = random_vector(&mut random) * 3.1;
            if at.length() > 1.2 && places.iter().all(|place| place.distance(at) > 1.1) {
                places.push(at);
                let turn = DQuat::from_scaled_axis(random_vector(&mut random) * 3.0);
                let size = DVec3::from_array(std::array::from_fn(|_| random.random_range(0.05..0.3)));
                scene.extend(box_triangles(-size, size).iter().map(|t| t.map(|corner| at + turn * corner)));
            }
        }
        let reference = Reference::new(&scene, None, DVec3::ZERO);
        for _ in 0..2 {
            let view = view(DQuat::from_scaled_axis(random_vector(&mut random) * 3.0));
            let receivers = sample_receivers(&reference, &view, 50_000, 11);
            let lit = truth(&receivers, &reference, &view);
            let error_at = |resolution| {
                let geometry = MapGeometry { resolution, guard: 0.05 };
                let map = ideal_map(&reference, &view, geometry);
                let lookup = Lookup { view, geometry, bias: 0.35, normal_bias: 0.0 };
                shadow_error(&receivers, &lit, &ideal_answers(&receivers, &map, &lookup), &reference, &view)
            };
            let (coarse, fine) = (error_at(128), error_at(1100));
            assert!(coarse.far_wrong_ppm > 0.2 * coarse.wrong_ppm && fine.far_wrong_ppm == 0.0, "{coarse:?} {fine:?}");
            assert!(fine.wrong_ppm > 0.0 && fine.wrong_ppm < 0.4 * coarse.wrong_ppm, "{coarse:?} {fine:?}");
            assert!(coarse.wrong_ppm < 30_000.0 && (0.2..0.95).contains(&coarse.lit_fraction), "{coarse:?}");
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
        assert!(receivers.iter().any(|receiver| receiver.rounding > 0.003));
        for (receiver, lit) in receivers.iter().zip(truth(&receivers, &reference, &view)) {
            assert!(lit && !near_boundary(receiver, true, &reference, &view, &PUBLISHED_PAIR), "{receiver:?}");
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
        let lookup = Lookup { view, geometry: GEOMETRY, bias: 0.2, normal_bias: 0.0 };
        let error = shadow_error(&receivers, &lit, &ideal_answers(&receivers, &map, &lookup), &reference, &view);
        assert!(error.false_shadow_ppm > 900_000.0 && error.far_wrong_ppm > 800_000.0, "{error:?}");
    }

    #[test]
    fn keys_are_those_of_the_report() {
        let json = serde_json::to_value(ShadowReport::default()).expect("plain numbers");
        let mut keys: Vec<_> = json.as_object().expect("a struct").keys().collect();
        keys.sort();
        let expected = "back_fraction false_shadow_ppm far_wrong_ppm ideal_wrong_ppm leak_ppm lit_fraction samples \
                        wrong_energy_ppm wrong_front_ppm wrong_ppm";
        assert_eq!(keys, expected.split(' ').collect::<Vec<_>>());
    }
}
