//! What a renderer's lookups answer, against the truth at the same receivers.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::Serialize;

use super::per_million;
use super::receivers::Receiver;
use crate::compare::ideal::MapGeometry;
use crate::compare::reference::{Reference, View};
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
    assert!(
        receivers.len() == truth.len() && receivers.len() == values.len(),
        "the lists differ in length"
    );
    let wrong: Vec<usize> = (0..receivers.len())
        .filter(|&i| (values[i] >= 0.5) != truth[i])
        .collect();
    let leaks = wrong.iter().filter(|&&i| !truth[i]).count();
    let far = wrong
        .par_iter()
        .filter(|&&i| !near_boundary(&receivers[i], truth[i], reference, view, geometry))
        .count();
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
/// at points of their own. For a receiver in the dark there is a boundary if one of these points is truly visible. For
/// a lit one there is, if at one of them another surface stands in front of the plane by more than [`CREASE_DEPTH`]
/// footprints, be it an occluder or the neighbouring face of a concave crease. A convex crease alone is no excuse.
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
    let plane = Plane::new(receiver, reference, view);
    let boundary_at = |q: DVec2| {
        let d = paraboloid::unproject(q);
        let Some(t) = plane.distance_along(d).filter(|&t| t >= view.clip_distance(d)) else {
            return false;
        };
        let direction = view.to_world(d, plane.back);
        if !lit {
            let slack = receiver.slack(view.position);
            return !reference.occluded(direction * t, Some(receiver.triangle), view.clip_distance(d), slack);
        }
        let crease = CREASE_DEPTH * paraboloid::texel_angle(q, geometry.texel());
        let front = reference.nearest(direction, view.clip_distance(d));
        front.is_some_and(|hit| hit.triangle != receiver.triangle && hit.t < t * (1.0 - crease))
    };
    nearby_texel_centres(plane.p, geometry).any(boundary_at) || nearby_rings(plane.p, geometry).any(boundary_at)
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
        Self {
            back,
            p: paraboloid::project(x),
            normal,
            distance: normal.dot(x),
        }
    }

    /// Where the ray along a unit direction meets the plane, if it does.
    fn distance_along(&self, d: DVec3) -> Option<f64> {
        let t = self.distance / self.normal.dot(d);
        (t > 0.0 && t.is_finite()).then_some(t)
    }
}

/// Centres of the texels that a lookup at `p` or close by reads.
fn nearby_texel_centres(p: DVec2, geometry: &MapGeometry) -> impl Iterator<Item = DVec2> {
    let texel = geometry.texel();
    let offset = geometry.position(p).fract() - 0.5;
    let around = (-2..=2).flat_map(|row| (-2..=2).map(move |column| DVec2::new(f64::from(column), f64::from(row))));
    around
        .map(move |cell| cell - offset)
        .filter(|from_p| from_p.length() <= FAR_TEXELS)
        .map(move |from_p| p + DVec2::new(from_p.x, -from_p.y) * texel)
}

/// Rings around `p` that fill the disc evenly.
fn nearby_rings(p: DVec2, geometry: &MapGeometry) -> impl Iterator<Item = DVec2> {
    let reach = FAR_TEXELS * geometry.texel();
    (1..=RINGS).flat_map(move |ring| {
        let rays = RAYS_OF_FIRST_RING * ring;
        let radius = reach * ring as f64 / RINGS as f64;
        (0..rays).map(move |ray| p + DVec2::from_angle(TAU * ray as f64 / rays as f64) * radius)
    })
}
