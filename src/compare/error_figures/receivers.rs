//! Points to ask for their shadow, and the truth at them.

use glam::{DVec3, Vec3};
use rand::Rng;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use crate::compare::reference::{Reference, View};

/// How many receivers a published error has, the same for every method.
pub const SAMPLES: usize = 1_000_000;

/// Cosine between normal and direction to the light up to which a receiver is *grazing*: next to no light arrives there,
/// whatever its shadow, so it counts by its energy alone.
pub const GRAZING: f64 = 0.02;

/// A triangle is cut until the distances from the light to its parts vary by at most this factor, so that drawing
/// uniformly over a part and rejecting takes few draws.
const DISTANCE_RATIO: f64 = 2.0;

/// Draws for one receiver before it is given up: only a scene whose every surface is out of reach needs so many.
const MAX_DRAWS: usize = 10_000;

/// Receivers drawn for each that isn't grazing, at most.
const MAX_GRAZING: usize = 16;

/// A point on a surface of the scene, as a renderer's shader would have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// Position in the world, rounded to single precision. The truth is judged here, not at the point that was drawn.
    pub position: Vec3,
    /// Unit geometric normal in the world, on the side that is asked about: the one that the light or the camera is on.
    pub normal: Vec3,
    /// Index of the triangle it was drawn on.
    pub triangle: u32,
    /// How far rounding moved the position, in world units.
    pub rounding: f64,
}

impl Receiver {
    /// The position relative to the light, in world axes.
    #[must_use]
    pub fn relative(&self, light_position: DVec3) -> DVec3 {
        self.position.as_dvec3() - light_position
    }

    /// Cosine between the normal and the direction to the light; negative if its side faces away. NaN at the light.
    #[must_use]
    pub fn incidence(&self, light_position: DVec3) -> f64 {
        -self.normal.as_dvec3().dot(self.relative(light_position).normalize())
    }

    /// Whether it counts wherever receivers are counted: its side faces the light with a cosine above [`GRAZING`].
    #[must_use]
    pub fn counts(&self, light_position: DVec3) -> bool {
        self.incidence(light_position) > GRAZING
    }

    /// How far the position may be off the surfaces it was meant to lie on, in world units: its rounding, and that of
    /// double precision.
    #[must_use]
    pub fn slack(&self, light_position: DVec3) -> f64 {
        1.01 * self.rounding + 1e-9 * self.relative(light_position).length()
    }
}

/// Draws receivers over all triangles, casters or not, with probability in proportion to area / distance^2, until `n`
/// of them count ([`Receiver::counts`]).
///
/// Drawn are points that a renderer lights and that someone may see, on the side that faces the light:
///
/// - Fronts, and either side of a double-sided triangle ([`Reference::with_double_sided`]).
/// - Not the inside of a closed double-sided piece, unless the light is inside. Many files mark every material
///   double-sided. The insides of their solid walls are dark, and no camera outside sees them; on
///   `fog_arcade_bevy.glb` they would be half of all receivers. Where the light is inside, as in a room made as one
///   shell, a camera may be too, so the inside counts.
/// - Outside of holes; within the light's range, and no nearer than `near`, so that maps hold them in every orientation.
///
/// A piece is connected by edges between equal positions, within one mesh. It is closed if every edge has exactly two
/// triangles that pass it in opposite directions, and its signed volume isn't 0. A negative volume means that fronts are
/// inside. A mesh with a hole mask or blending has no closed pieces: one sees through it. Pieces don't know each other:
/// of a thick wall made as two shells around a room, the sides that face into the wall may count.
///
/// The grazing ones that were drawn on the way are among them: all together are a sample without a cut-off, whose cosines
/// weigh them by the energy that arrives.
///
/// The weight is exact for triangles of any size: they are cut until the distance varies little over a part, and drawn by
/// rejection within it. The same seed gives the same receivers, on any number of threads. Fewer than `n` count where
/// next to no surface qualifies.
#[must_use]
pub fn sample_receivers(reference: &Reference, view: &View, n: usize, seed: u64) -> Vec<Receiver> {
    let sampler = Sampler::new(reference, view);
    let draw = |i: usize| sampler.draw(&mut Pcg64::new(u128::from(seed), i as u128));
    let (mut receivers, mut counted, mut draws) = (Vec::with_capacity(n), 0, 0);
    // As many as are missing at a time: the last one drawn is the first with which `n` count.
    while counted < n && draws < MAX_GRAZING * n && !sampler.pieces.is_empty() {
        let round = draws..draws + n - counted;
        let first = receivers.len();
        draws = round.end;
        receivers.par_extend(round.into_par_iter().filter_map(draw));
        counted += receivers[first..].iter().filter(|receiver| receiver.counts(view.position)).count();
    }
    receivers
}

/// For each receiver, whether the light reaches it: a segment test in double precision at the rounded position.
///
/// Nothing occludes that the map has to leave out: what is nearer than the clip distance. Neither does the receiver's
/// own triangle nor a surface that the position lies on within its rounding ([`Reference::occluded`]).
#[must_use]
pub fn truth(receivers: &[Receiver], reference: &Reference, view: &View) -> Vec<bool> {
    receivers.par_iter().map(|receiver| is_lit(receiver, reference, view)).collect()
}

/// The [`truth`] of one receiver.
pub(in crate::compare) fn is_lit(receiver: &Receiver, reference: &Reference, view: &View) -> bool {
    let target = receiver.relative(view.position);
    let (x, _) = view.to_hemisphere(target);
    let t_min = view.clip_distance(x.normalize());
    !reference.occluded(target, Some(receiver.triangle), t_min, receiver.slack(view.position))
}

/// A part of a triangle over which the distance to the light varies little.
struct Piece {
    triangle: u32,
    /// Weights of the triangle's second and third corner at the piece's corners. Halves of halves: exact.
    corners: [[f32; 2]; 3],
}

impl Piece {
    fn corners(&self, triangle: &[DVec3; 3]) -> [DVec3; 3] {
        self.corners.map(|[b, c]| interpolate(triangle, f64::from(b), f64::from(c)))
    }

    /// Cuts the piece at the middle of its longest edge.
    fn halves(&self, corners: &[DVec3; 3]) -> [Self; 2] {
        let length = |i: usize| corners[i].distance_squared(corners[(i + 1) % 3]);
        let longest = (0..3).max_by(|&i, &j| length(i).total_cmp(&length(j))).unwrap_or(0);
        let (a, b, c) = (self.corners[longest], self.corners[(longest + 1) % 3], self.corners[(longest + 2) % 3]);
        let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        let triangle = self.triangle;
        [Self { triangle, corners: [a, middle, c] }, Self { triangle, corners: [middle, b, c] }]
    }
}

fn interpolate(triangle: &[DVec3; 3], b: f64, c: f64) -> DVec3 {
    triangle[0] * (1.0 - b - c) + triangle[1] * b + triangle[2] * c
}

struct Sampler<'a> {
    reference: &'a Reference,
    view: &'a View,
    pieces: Vec<Piece>,
    /// Running sum of the pieces' weights, area / (shortest distance)^2.
    cumulative: Vec<f64>,
}

impl<'a> Sampler<'a> {
    fn new(reference: &'a Reference, view: &'a View) -> Self {
        let (pieces, mut cumulative): (Vec<Piece>, Vec<f64>) = (0..reference.triangles().len() as u32)
            .into_par_iter()
            .flat_map_iter(|triangle| weighted_pieces(reference, view, triangle))
            .unzip();
        let mut sum = 0.0;
        for weight in &mut cumulative {
            sum += *weight;
            *weight = sum;
        }
        Self { reference, view, pieces, cumulative }
    }

    fn draw(&self, random: &mut Pcg64) -> Option<Receiver> {
        let total = *self.cumulative.last()?;
        (0..MAX_DRAWS).find_map(|_| {
            let share = random.random::<f64>() * total;
            let piece = &self.pieces[self.cumulative.partition_point(|&sum| sum <= share).min(self.pieces.len() - 1)];
            self.draw_on(piece, random)
        })
    }

    fn draw_on(&self, piece: &Piece, random: &mut Pcg64) -> Option<Receiver> {
        let corners = piece.corners(&self.reference.triangles()[piece.triangle as usize]);
        let (root, share) = (random.random::<f64>().sqrt(), random.random::<f64>());
        let point = interpolate(&corners, root * (1.0 - share), root * share);
        let keep = (shortest_distance(&corners, self.view) / point.length()).powi(2);
        if random.random::<f64>() >= keep {
            return None;
        }
        self.receiver(piece.triangle, point)
    }

    fn receiver(&self, triangle: u32, point: DVec3) -> Option<Receiver> {
        if self.reference.is_hole(triangle, point) {
            return None;
        }
        let normal = self.reference.normal(triangle);
        let towards_light = if normal.dot(point) < 0.0 { normal } else { -normal };
        let exact = self.view.position + point;
        let position = exact.as_vec3();
        let rounding = position.as_dvec3().distance(exact);
        let receiver = Receiver { position, normal: towards_light.as_vec3(), triangle, rounding };
        let distance = receiver.relative(self.view.position).length();
        (distance >= self.view.near && distance <= self.view.range).then_some(receiver)
    }
}

/// The parts of a triangle that receivers may lie on, each with its weight.
fn weighted_pieces(reference: &Reference, view: &View, triangle: u32) -> Vec<(Piece, f64)> {
    let triangle_corners = &reference.triangles()[triangle as usize];
    // The light, at the origin, is in the plane of a triangle without area.
    if !triangle_corners.iter().all(|corner| corner.is_finite()) || !reference.receives(triangle) {
        return Vec::new();
    }
    let mut pieces = Vec::new();
    let mut rest = vec![Piece { triangle, corners: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] }];
    while let Some(piece) = rest.pop() {
        let corners = piece.corners(triangle_corners);
        let farthest = corners.iter().map(|corner| corner.length()).fold(0.0, f64::max);
        let nearest = shortest_distance(&corners, view);
        if farthest < nearest || nearest > view.range {
            // All of it is nearer than `near`, or out of range.
        } else if farthest > DISTANCE_RATIO * nearest {
            rest.extend(piece.halves(&corners));
        } else {
            let area = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
            pieces.push((piece, area / (nearest * nearest)));
        }
    }
    pieces
}

/// Distance to the nearest point of a triangle that may hold a receiver.
fn shortest_distance(corners: &[DVec3; 3], view: &View) -> f64 {
    distance_to_triangle(corners).max(view.near)
}

/// Distance from the origin to a triangle of non-zero area.
pub(in crate::compare) fn distance_to_triangle(corners: &[DVec3; 3]) -> f64 {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let inside = (0..3).all(|i| corners[i].cross(corners[(i + 1) % 3]).dot(normal) >= 0.0);
    if inside {
        return corners[0].dot(normal).abs() / normal.length();
    }
    (0..3).map(|i| distance_to_segment(corners[i], corners[(i + 1) % 3])).fold(f64::INFINITY, f64::min)
}

/// Distance from the origin to the segment between two points.
fn distance_to_segment(a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let share = (-a.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    (a + along * share).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::test_shapes::{box_triangles, random_vector, sheet};
    use crate::paraboloid::double as paraboloid;
    use glam::DQuat;
    use rand::SeedableRng;

    fn view(position: DVec3) -> View {
        View { position, orientation: DQuat::from_rotation_x(0.7), near: 0.01, range: f64::INFINITY }
    }

    /// Chi-square of counts in bins that should be equally full.
    fn chi_square(values: impl Iterator<Item = f64>, bins: usize) -> f64 {
        let mut counts = vec![0_usize; bins];
        for value in values {
            counts[((value * bins as f64) as usize).min(bins - 1)] += 1;
        }
        let expected = counts.iter().sum::<usize>() as f64 / bins as f64;
        counts.iter().map(|&count| (count as f64 - expected).powi(2) / expected).sum()
    }

    /// Over a plane at height h the weight within a radius r is pi ln(1 + r^2/h^2), all around alike. Two triangles
    /// make the floor, ten thousand times as wide as the light is high; a ceiling twice as far gets its share.
    #[test]
    fn density_is_area_over_distance_squared() {
        let light = DVec3::new(3.0, 1.0, -2.0);
        let view = view(light);
        let mut scene = sheet(DVec3::new(-1e4, 0.0, -1e4), DVec3::X * 2e4, DVec3::Z * 2e4);
        scene.extend(sheet(DVec3::new(-1e4, 3.0, -1e4), DVec3::X * 2e4, DVec3::Z * 2e4));
        let reference = Reference::new(&scene, None, light);
        let receivers = sample_receivers(&reference, &view, 100_000, 7);
        assert_eq!(receivers.iter().filter(|receiver| receiver.counts(light)).count(), 100_000);
        let reach = 30.0;
        let weight = |r: f64, h: f64| (1.0 + (r / h).powi(2)).ln();
        let within = |h: f64, floor: bool| {
            let relative: Vec<DVec3> = receivers
                .iter()
                .filter(|receiver| (receiver.triangle < 2) == floor)
                .map(|receiver| receiver.relative(light))
                .filter(|x| x.x.hypot(x.z) < reach)
                .collect();
            let radii = relative.iter().map(|x| weight(x.x.hypot(x.z), h) / weight(reach, h));
            // The 99.99th percentile of chi-square with 19 degrees of freedom is 50.8.
            assert!(chi_square(radii, 20) < 51.0);
            let turns = relative.iter().map(|x| 0.5 + x.z.atan2(x.x) / std::f64::consts::TAU);
            assert!(chi_square(turns, 20) < 51.0);
            relative.len() as f64
        };
        let share = within(1.0, true) / within(2.0, false);
        let expected = weight(reach, 1.0) / weight(reach, 2.0);
        assert!((share / expected - 1.0).abs() < 0.03, "{share} {expected}");
    }

    #[test]
    fn receivers_lie_where_they_may() {
        let light = DVec3::new(1e3, 2e3, -5e2);
        let view = View { near: 0.5, range: 3.0, ..view(light) };
        let mut random = Pcg64::new(1, 1);
        let mut scene: Vec<_> = (0..500).map(|_| [(); 3].map(|()| light + random_vector(&mut random) * 4.0)).collect();
        scene.push([light; 3]);
        scene.extend(sheet(light, DVec3::X, DVec3::Y));
        let reference = Reference::new(&scene, None, light);
        let receivers = sample_receivers(&reference, &view, 20_000, 3);
        assert_eq!(receivers.iter().filter(|receiver| receiver.counts(light)).count(), 20_000);
        assert!(receivers.last().is_some_and(|receiver| receiver.counts(light)));
        let grazing = receivers.len() - 20_000;
        assert!((200..2000).contains(&grazing), "{grazing}");
        for receiver in &receivers {
            let relative = receiver.relative(light);
            let (x, _) = view.to_hemisphere(relative);
            assert!(paraboloid::homogeneous_w(x) >= 0.5 && x.length() <= 3.0);
            let cosine = reference.normal(receiver.triangle).dot(relative.normalize()).abs();
            assert!(cosine > 0.0 && (receiver.incidence(light) - cosine).abs() < 1e-6);
            assert_eq!(receiver.counts(light), receiver.incidence(light) > 0.02);
            assert!(reference.height(relative, receiver.triangle).abs() <= receiver.rounding + 1e-12);
            assert!(receiver.rounding < 2e-4);
        }
    }

    #[test]
    fn the_same_seed_draws_the_same_receivers() {
        let reference = Reference::new(&box_triangles(DVec3::NEG_ONE, DVec3::ONE), None, DVec3::ZERO);
        let draw = |seed| sample_receivers(&reference, &view(DVec3::ZERO), 100, seed);
        assert_eq!(draw(1), draw(1));
        assert_ne!(draw(1), draw(2));
    }

    #[test]
    fn a_scene_without_surfaces_to_light_has_no_receivers() {
        let edge_on = [DVec3::X, DVec3::X * 2.0, DVec3::new(1.0, 0.0, 1.0)];
        for scene in [vec![], vec![edge_on], vec![[DVec3::X; 3]]] {
            let reference = Reference::new(&scene, None, DVec3::ZERO);
            assert!(sample_receivers(&reference, &view(DVec3::ZERO), 10, 1).is_empty());
        }
    }

    /// How many of 1000 receivers lie on the sheet beside a floor that faces the light, half as many if both are alike.
    fn on_sheet(faces_light: bool, double_sided: bool) -> usize {
        let floor = |y: f64| sheet(DVec3::new(-1.0, y, -1.0), DVec3::Z * 2.0, DVec3::X * 2.0);
        // Upward, away from the light.
        let mut beside = floor(1.0);
        if faces_light {
            beside.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        let reference = Reference::new(&[floor(-1.0), beside].concat(), None, DVec3::ZERO).with_double_sided(vec![
            false,
            false,
            double_sided,
            double_sided,
        ]);
        let receivers = sample_receivers(&reference, &view(DVec3::ZERO), 1000, 1);
        assert!(
            receivers.iter().all(|receiver| receiver.incidence(DVec3::ZERO) > 0.0),
            "the normal is on the lit side"
        );
        receivers.iter().filter(|receiver| receiver.triangle >= 2).count()
    }

    #[test]
    fn a_wall_seen_from_behind_counts_for_nothing() {
        assert_eq!(on_sheet(false, false), 0);
        assert!((400..600).contains(&on_sheet(true, false)));
    }

    #[test]
    fn a_double_sided_sheet_counts_on_both_sides() {
        assert!([true, false].into_iter().all(|faces_light| (400..600).contains(&on_sheet(faces_light, true))));
    }

    /// A square over a floor: dark is what lies in its central projection.
    #[test]
    fn truth_is_the_projected_shadow() {
        for offset in [DVec3::ZERO, DVec3::new(1e5, 2e4, -3e4)] {
            let light = offset + DVec3::Y;
            let view = view(light);
            let mut scene = sheet(offset + DVec3::new(-8.0, -1.0, -8.0), DVec3::X * 16.0, DVec3::Z * 16.0);
            scene.extend(sheet(offset + DVec3::new(-0.5, 0.0, -0.5), DVec3::X, DVec3::Z));
            let reference = Reference::new(&scene, None, light);
            let receivers = sample_receivers(&reference, &view, 20_000, 5);
            let lit = truth(&receivers, &reference, &view);
            let mut dark = 0;
            for (receiver, lit) in receivers.iter().zip(lit) {
                let x = receiver.relative(light);
                let distance = x.x.abs().max(x.z.abs()) - 1.0;
                if receiver.triangle >= 2 {
                    assert!(lit, "{x}");
                } else if distance.abs() > 0.02 {
                    assert_eq!(lit, distance > 0.0, "{x}");
                    dark += usize::from(!lit);
                }
            }
            assert!(dark > 500);
        }
    }

    #[test]
    fn distance_to_a_triangle_is_that_of_its_nearest_point() {
        let mut random = Pcg64::seed_from_u64(8);
        for _ in 0..200 {
            let corners = [(); 3].map(|()| random_vector(&mut random) * 3.0 + DVec3::splat(0.5));
            let steps = 100;
            let mut nearest = f64::INFINITY;
            for i in 0..=steps {
                for j in 0..=steps - i {
                    let point = interpolate(&corners, f64::from(i) / f64::from(steps), f64::from(j) / f64::from(steps));
                    nearest = nearest.min(point.length());
                }
            }
            let distance = distance_to_triangle(&corners);
            assert!(distance <= nearest + 1e-12 && nearest < distance + 0.1, "{distance} {nearest}");
        }
    }
}
