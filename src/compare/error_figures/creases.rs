//! Lit creases: what a lookup answers where two lit faces meet, as floor and wall do.
//!
//! Of a map's texels along such an edge some show one face and some the other, so every lookup that compares depths is in
//! doubt there. Nothing shadows these receivers, and the answer should be 1.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::shadow_error::{PUBLISHED_PAIR, near_boundary};
use super::{Receiver, per_million, quantile};
use crate::compare::reference::{Reference, View};
use crate::paraboloid::double as paraboloid;

/// How near to a crease receivers are *in* it, in texels of [`PUBLISHED_PAIR`].
pub const CREASE_TEXELS: f64 = 0.5;

/// Two faces make a crease where the angle between them, on their lit side, is less than this, in degrees.
pub const CREASE_ANGLE: f64 = 150.0;

/// A lit crease that is answered with less than this is dark.
pub const DARK_CREASE: f32 = 0.9;

/// Rays around a receiver that look for a crease: they find 98 % of the disc.
const RAYS: usize = 16;

/// How often the stretch between two rays is halved to find where two faces meet.
const HALVINGS: usize = 24;

/// How far apart faces may be where they meet, in texel footprints along the ray.
const TOUCHING: f64 = 1e-3;

/// What is answered in lit creases, where 1 is right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct CreaseError {
    /// Number of receivers in creases.
    pub samples: usize,
    /// Mean of the answers, from 0 to 1.
    pub mean: f64,
    /// The answer that a thousandth of them stays below.
    pub q001: f64,
    /// Answers below [`DARK_CREASE`], in parts per million of the receivers in creases.
    pub below_ppm: f64,
}

/// Figures about the answers at the receivers of [`lit_creases`]; `None` for no answers.
#[must_use]
pub fn crease_error(values: &[f32]) -> Option<CreaseError> {
    if values.is_empty() {
        return None;
    }
    let mut sorted: Vec<f64> = values.iter().copied().map(f64::from).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let below = values.iter().filter(|value| **value < DARK_CREASE).count();
    Some(CreaseError {
        samples: values.len(),
        mean: sorted.iter().sum::<f64>() / sorted.len() as f64,
        q001: quantile(&sorted, 0.001),
        below_ppm: per_million(below, values.len()),
    })
}

/// The numbers of the receivers in lit creases: those that count, that the light reaches, that have the edge of a concave
/// dihedral of less than [`CREASE_ANGLE`] within [`CREASE_TEXELS`], and no occluder's edge near
/// ([`near_boundary`]). Faces that merely touch or cut through each other count as those of one mesh do.
#[must_use]
pub fn lit_creases(receivers: &[Receiver], lit: &[bool], reference: &Reference, view: &View) -> Vec<usize> {
    (0..receivers.len())
        .into_par_iter()
        .filter(|&number| {
            let receiver = &receivers[number];
            lit[number]
                && receiver.counts(view.position)
                && is_in_crease(receiver, reference, view)
                && !near_boundary(receiver, true, reference, view, &PUBLISHED_PAIR)
        })
        .collect()
}

fn is_in_crease(receiver: &Receiver, reference: &Reference, view: &View) -> bool {
    let (x, back) = view.to_hemisphere(receiver.relative(view.position));
    let search = Search { reference, view, back };
    let p = paraboloid::project(x);
    let own = Seen { q: p, point: receiver.relative(view.position), normal: receiver.normal.as_dvec3() };
    let radius = CREASE_TEXELS * PUBLISHED_PAIR.texel();
    (0..RAYS).any(|ray| {
        let around = p + DVec2::from_angle(TAU * ray as f64 / RAYS as f64) * radius;
        search.look(around).is_some_and(|seen| search.meet_in_crease(own, seen))
    })
}

/// A place that the light sees: map coordinates, point relative to the light and unit normal towards it in world axes.
#[derive(Clone, Copy)]
struct Seen {
    q: DVec2,
    point: DVec3,
    normal: DVec3,
}

impl Seen {
    /// Cosine of the angle that the surface turns by between two places, if it turns towards itself.
    fn fold(&self, other: &Self) -> Option<f64> {
        let apart = other.point - self.point;
        let is_concave = self.normal.dot(apart) > 0.0 && other.normal.dot(apart) < 0.0;
        is_concave.then(|| self.normal.dot(other.normal))
    }
}

struct Search<'a> {
    reference: &'a Reference,
    view: &'a View,
    back: bool,
}

impl Search<'_> {
    fn look(&self, q: DVec2) -> Option<Seen> {
        let d = paraboloid::unproject(q);
        let direction = self.view.to_world(d, self.back);
        let hit = self.reference.nearest(direction, self.view.clip_distance(d))?;
        let normal = self.reference.normal(hit.triangle);
        let normal = if normal.dot(direction) < 0.0 { normal } else { -normal };
        Some(Seen { q, point: direction * hit.t, normal })
    }

    /// Whether the surface between two places folds at one edge by enough. Halves of the stretch, each time the one that
    /// folds more, end at the edge; on a curved surface their fold vanishes, and at an occluder's edge they stay apart.
    fn meet_in_crease(&self, mut one: Seen, mut other: Seen) -> bool {
        let sharp = (180.0 - CREASE_ANGLE).to_radians().cos();
        let folds = |a: &Seen, b: &Seen| a.fold(b).filter(|&cosine| cosine < sharp);
        if folds(&one, &other).is_none() {
            return false;
        }
        for _ in 0..HALVINGS {
            let Some(middle) = self.look(0.5 * (one.q + other.q)) else { return false };
            match (folds(&one, &middle), folds(&middle, &other)) {
                (None, None) => return false,
                (Some(first), Some(second)) if first <= second => other = middle,
                (Some(_), None) => other = middle,
                (_, Some(_)) => one = middle,
            }
        }
        let footprint = paraboloid::texel_angle(one.q, PUBLISHED_PAIR.texel()) * one.point.length();
        one.point.distance(other.point) < TOUCHING * footprint
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::error_figures::{sample_receivers, truth};
    use crate::compare::test_shapes::sheet;
    use glam::DQuat;

    fn view() -> View {
        let orientation = DQuat::from_rotation_x(0.7) * DQuat::from_rotation_y(0.4);
        View { position: DVec3::ZERO, orientation, near: 0.001, range: f64::INFINITY }
    }

    /// Sheets that rise from the line y = -1, x = 1 by some degrees, above the floor that ends there or goes on below.
    fn crease(rise: f64, floor_goes_on: bool, lift: f64) -> Vec<[DVec3; 3]> {
        let end = if floor_goes_on { 2.0 } else { 1.0 };
        let floor = sheet(DVec3::new(-3.0, -1.0, -2.0), DVec3::X * (3.0 + end), DVec3::Z * 4.0);
        let up = DVec3::new(rise.to_radians().cos(), rise.to_radians().sin(), 0.0);
        [floor, sheet(DVec3::new(1.0, -1.0 + lift, -2.0), up * 2.0, DVec3::Z * 4.0)].concat()
    }

    /// Distance in texels from a receiver to the line y = -1, x = 1.
    fn distance(receiver: &Receiver, view: &View) -> f64 {
        let (x, back) = view.to_hemisphere(receiver.relative(DVec3::ZERO));
        let p = paraboloid::project(x);
        let on_line = |k: i32| DVec3::new(1.0, -1.0, f64::from(receiver.position.z) + f64::from(k) * 1e-4);
        let in_map =
            |point: DVec3| paraboloid::project(paraboloid::to_hemisphere(view.orientation.inverse() * point, back));
        (-100..=100).map(|k| in_map(on_line(k)).distance(p)).fold(f64::INFINITY, f64::min) / PUBLISHED_PAIR.texel()
    }

    /// Receivers found to be in a crease, and the distances of all from it; infinite for dark ones.
    fn found(triangles: &[[DVec3; 3]]) -> (Vec<usize>, Vec<f64>) {
        let view = view();
        let reference = Reference::new(triangles, None, DVec3::ZERO);
        let receivers = sample_receivers(&reference, &view, 300_000, 1);
        let lit = truth(&receivers, &reference, &view);
        let far = |(receiver, lit): (&Receiver, &bool)| if *lit { distance(receiver, &view) } else { f64::INFINITY };
        let distances = receivers.iter().zip(&lit).map(far).collect();
        (lit_creases(&receivers, &lit, &reference, &view), distances)
    }

    #[test]
    fn receivers_within_half_a_texel_are_in_a_crease() {
        for floor_goes_on in [false, true] {
            let (found, distances) = found(&crease(90.0, floor_goes_on, 0.0));
            assert!(found.len() > 200, "{}", found.len());
            assert!(found.iter().all(|&number| distances[number] < 0.502));
            let near: Vec<usize> = (0..distances.len()).filter(|&number| distances[number] < 0.485).collect();
            // But where the line ends, beside open space.
            let missed = near.iter().filter(|number| !found.contains(number)).count();
            assert!(missed * 100 < near.len(), "{missed} of {}", near.len());
        }
    }

    #[test]
    fn flat_creases_and_convex_edges_are_none() {
        assert!(!found(&crease(31.0, false, 0.0)).0.is_empty(), "a dihedral of 149 degrees");
        assert_eq!(found(&crease(29.0, false, 0.0)).0, [0; 0], "a dihedral of 151 degrees");
        assert_eq!(found(&crease(-20.0, false, 0.0)).0, [0; 0], "convex");
    }

    /// A wall that hangs above the floor is an occluder: its edge throws a shadow.
    #[test]
    fn an_edge_above_the_floor_is_none() {
        assert_eq!(found(&crease(90.0, true, 0.05)).0, [0; 0]);
    }

    #[test]
    fn a_crease_of_a_half_says_a_half() {
        let error = CreaseError { samples: 3, mean: 0.5, q001: 0.5, below_ppm: 1e6 };
        assert_eq!(crease_error(&[0.5; 3]), Some(error));
        assert_eq!(crease_error(&[]), None);
    }

    /// A thousand answers of 1 and four darker ones: the thousandth is the second darkest of 1004.
    #[test]
    fn figures_of_known_answers() {
        let values = [&[1.0; 1000][..], &[0.25, 0.5, 0.75, 0.9]].concat();
        let error = crease_error(&values).expect("answers");
        assert_eq!((error.samples, error.q001), (1004, 0.5));
        assert!(
            (error.mean - 1002.4 / 1004.0).abs() < 1e-9 && (error.below_ppm - 3e6 / 1004.0).abs() < 1e-9,
            "{error:?}"
        );
    }
}
