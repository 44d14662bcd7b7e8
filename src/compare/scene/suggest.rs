//! Where to put a light and a camera in a scene that says nothing about either.
//!
//! Rays are cast by brute force at the scene's largest triangles: walls and floors decide what is a room, and small
//! details don't. A few thousand of them sort out the candidates; the shortlist is judged against many more.

use std::f32::consts::{FRAC_PI_3, FRAC_PI_4, TAU};

use glam::Vec3;

use super::{Camera, Scene};

/// Triangles looked at, about, before the largest are chosen.
const EXAMINED: usize = 200_000;
/// Triangles of each instance that are looked at however many there are, so that no wall is missed.
const EXAMINED_PER_INSTANCE: usize = 16;
/// Largest triangles that the shortlist is judged against.
const FINE: usize = 30_000;
/// Largest triangles that all candidates are judged against.
const COARSE: usize = 2_000;
const CANDIDATES: usize = 128;
/// How far past the scene's main box candidates reach, in diagonals: a single object is lit from outside.
const MARGIN: f32 = 0.12;
const SHORTLIST: usize = 6;
const RAYS: usize = 48;
/// Share of directions that hit something, from which on a point counts as indoors.
const ENCLOSED: f32 = 0.7;
/// Directions that rise or fall by less meet the walls of a room: the sine of the angle.
const WALL_HEIGHT: f32 = 0.4;
/// How far behind the light a camera is put, as shares of the way to the wall.
const BEHIND: [f32; 2] = [0.7, 0.4];
/// How far past the scene's main box a view from outside still frames what there is, in diagonals.
const FRAME_MARGIN: f32 = 0.3;
/// Triangles that a view from outside is judged by, about.
const LIT: usize = 600;
/// Width over height of the pictures that views are made for.
const ASPECT: f32 = 1.6;

/// A coarse stand-in for a scene.
struct Sketch {
    /// World-space corners, front faces counter-clockwise; the [`COARSE`] largest come first.
    triangles: Vec<[Vec3; 3]>,
    /// World-space box that holds most of the triangles: without the far ends of a lone ground plane.
    low: Vec3,
    high: Vec3,
}

/// What a point sees around it.
struct View {
    /// Share of directions in 0..=1 that hit a triangle.
    hit: f32,
    /// Share of directions in 0..=1 that hit the back of one first.
    back: f32,
    /// Smallest distance met.
    clearance: f32,
}

pub(super) fn light(scene: &Scene) -> Vec3 {
    let Some(sketch) = Sketch::of(scene) else {
        return Vec3::ZERO;
    };
    let directions = sphere_directions(RAYS);
    let diagonal = (sketch.high - sketch.low).length();
    let low = sketch.low - MARGIN * diagonal;
    let size = sketch.high - sketch.low + 2.0 * MARGIN * diagonal;
    let score = |point: Vec3, triangles: &[[Vec3; 3]]| {
        let view = View::of(triangles, point, &directions);
        // A clearance past a quarter of the scene is no further gain, or every light would end up in the sky.
        let room = (view.clearance / (0.25 * diagonal)).min(1.0);
        room * (0.05 + view.hit) * (1.0 - view.back).powi(4)
    };
    let candidates = (0..CANDIDATES).map(|k| low + size * low_discrepancy(k));
    let mut ranked: Vec<_> = candidates.map(|point| (score(point, sketch.coarse()), point)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let shortlist = ranked.iter().take(SHORTLIST).map(|&(_, point)| (score(point, &sketch.triangles), point));
    shortlist.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(Vec3::ZERO, |(_, point)| point)
}

pub(super) fn camera(scene: &Scene, light: Vec3) -> Camera {
    let unseen = Camera { eye: light + Vec3::Z, target: light, fov_y: FRAC_PI_4 };
    let Some(sketch) = Sketch::of(scene) else { return unseen };
    let judged = if sketch.is_indoors(light) { sketch.inside(light) } else { sketch.outside(light, scene) };
    // The first of equals, so that a scene in which nothing is lit is seen from the usual side.
    judged
        .into_iter()
        .reduce(|best, next| if next.0 > best.0 { next } else { best })
        .map_or(unseen, |(_, camera)| camera)
}

impl Sketch {
    /// `None` for a scene without triangles.
    fn of(scene: &Scene) -> Option<Self> {
        let mut sampled = sample(scene);
        let (low, high) = main_box(&sampled)?;
        largest_first(&mut sampled, FINE);
        sampled.truncate(FINE);
        largest_first(&mut sampled, COARSE);
        Some(Self { triangles: sampled, low, high })
    }

    fn coarse(&self) -> &[[Vec3; 3]] {
        &self.triangles[..self.triangles.len().min(COARSE)]
    }

    fn size(&self) -> f32 {
        (self.high - self.low).length()
    }

    /// How far one can look from `origin`, within the size of the scene.
    fn free(&self, origin: Vec3, direction: Vec3) -> f32 {
        let size = self.size();
        first_hit(&self.triangles, origin, direction).map_or(size, |(distance, _)| distance.min(size))
    }

    /// Whether there are walls around a point; a room may lack its roof.
    fn is_indoors(&self, point: Vec3) -> bool {
        let mut level = sphere_directions(3 * RAYS);
        level.retain(|direction| direction.y.abs() < WALL_HEIGHT);
        let share_of = |directions: &[Vec3]| View::of(&self.triangles, point, directions).hit;
        share_of(&level) >= ENCLOSED || share_of(&sphere_directions(RAYS)) >= ENCLOSED
    }

    /// Views past the light from behind it, all around, with how good they are.
    fn inside(&self, light: Vec3) -> Vec<(f32, Camera)> {
        let lowered = Vec3::Y * (0.25 * self.free(light, Vec3::NEG_Y));
        let toward = |k: usize| {
            let (sin, cos) = (TAU * k as f32 / 16.0).sin_cos();
            let direction = Vec3::new(cos, 0.0, sin);
            let (ahead, behind) = (self.free(light, direction), self.free(light, -direction));
            BEHIND.map(|share| Camera {
                eye: light - direction * (share * behind),
                target: light + direction * (0.5 * ahead) - lowered,
                fov_y: FRAC_PI_3,
            })
        };
        (0..16).flat_map(toward).map(|camera| (self.interest(&camera, light), camera)).collect()
    }

    /// How much a view shows, and how much of that lit: more is better, far things count more than near ones.
    fn interest(&self, camera: &Camera, light: Vec3) -> f32 {
        let ahead = (camera.target - camera.eye).normalize_or(Vec3::NEG_Z);
        let right = ahead.cross(Vec3::Y).normalize_or(Vec3::X);
        let up = right.cross(ahead);
        let half = (0.5 * camera.fov_y).tan();
        let shown = |k: usize| {
            let (x, y) = ((k % 6) as f32 / 5.0 - 0.5, (k / 6) as f32 / 3.0 - 0.5);
            let direction = (ahead + (right * x * ASPECT + up * y) * (1.6 * half)).normalize();
            // What is seen from behind is seldom drawn.
            let Some((distance, true)) = first_hit(&self.triangles, camera.eye, direction) else { return 0.0 };
            let lit = self.is_lit(camera.eye + direction * (0.999 * distance), light);
            (distance / self.size()).sqrt().min(1.0) * if lit { 1.0 } else { 0.4 }
        };
        (0..24).map(shown).sum()
    }

    /// Whether nothing is between a point and the light.
    fn is_lit(&self, point: Vec3, light: Vec3) -> bool {
        let hits = |triangle| intersect(point, light - point, triangle).is_some_and(|(share, _)| share < 0.999);
        !self.triangles.iter().any(hits)
    }

    /// Views from all around with the scene and its lights in the frame, the usual one first, with how much of the lit
    /// surfaces they face.
    fn outside(&self, light: Vec3, scene: &Scene) -> Vec<(f32, Camera)> {
        let margin = FRAME_MARGIN * self.size();
        let is_near = |point: &Vec3| point.cmpge(self.low - margin).all() && point.cmple(self.high + margin).all();
        let mut points: Vec<Vec3> = self.triangles.iter().map(center).filter(is_near).collect();
        points.push(light);
        points.extend(scene.lights.iter().map(|light| light.position));
        let faces: Vec<Vec3> =
            self.lit_faces(light).into_iter().filter(|(point, _)| is_near(point)).map(|f| f.1).collect();
        let from = |(elevation, k): (f32, usize)| {
            let (sin, cos) = (0.5 + TAU * k as f32 / 8.0).sin_cos();
            let direction = Vec3::new(sin, elevation, cos).normalize();
            let seen = faces.iter().map(|face| face.dot(direction).max(0.0)).sum();
            (seen, framed(&points, direction, self.size()))
        };
        let elevations = [0.4, 0.15, -0.3].into_iter();
        elevations.flat_map(|elevation| (0..8).map(move |k| (elevation, k))).map(from).collect()
    }

    /// Centres and areas, along the normals, of the lit ones among some hundred triangles.
    fn lit_faces(&self, light: Vec3) -> Vec<(Vec3, Vec3)> {
        let some = self.triangles.iter().step_by(self.triangles.len().div_ceil(LIT).max(1));
        let faces = some.filter_map(|triangle| {
            let [a, b, c] = triangle;
            let (middle, area) = (center(triangle), (b - a).cross(c - a) / 2.0);
            let above = middle + (light - middle) * 1e-3;
            (area.dot(light - middle) > 0.0 && self.is_lit(above, light)).then_some((middle, area))
        });
        faces.collect()
    }
}

fn center([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (a + b + c) / 3.0
}

/// The nearest view toward `-direction` that has all points in its frame.
fn framed(points: &[Vec3], direction: Vec3, size: f32) -> Camera {
    let right = Vec3::Y.cross(direction).normalize_or(Vec3::X);
    let up = direction.cross(right);
    let tangent = (FRAC_PI_4 / 2.0).tan() * 0.92;
    // Each side of the frame is a plane through the eye; the farthest point out decides where it has to be.
    let farthest = |normal: Vec3| points.iter().map(|point| point.dot(normal)).fold(f32::MIN, f32::max);
    let between = |axis: Vec3, tangent: f32| {
        let (more, less) = (farthest(axis + direction * tangent), farthest(direction * tangent - axis));
        ((more - less) / 2.0, (more + less) / (2.0 * tangent))
    };
    let (x, along_x) = between(right, tangent * ASPECT);
    let (y, along_y) = between(up, tangent);
    // Not within the nearest point, even if the scene is as flat as a wall seen from its side.
    let along = along_x.max(along_y).max(farthest(direction) + 0.05 * size);
    let middle = (farthest(direction) - farthest(-direction)) / 2.0;
    let eye = right * x + up * y + direction * along;
    Camera { eye, target: eye - direction * (along - middle).max(1e-3 * size.max(1e-3)), fov_y: FRAC_PI_4 }
}

impl View {
    fn of(triangles: &[[Vec3; 3]], point: Vec3, directions: &[Vec3]) -> Self {
        let hits = directions.iter().filter_map(|&direction| first_hit(triangles, point, direction));
        let mut view = Self { hit: 0.0, back: 0.0, clearance: f32::MAX };
        let share = 1.0 / directions.len() as f32;
        for (distance, front) in hits {
            view.hit += share;
            view.back += if front { 0.0 } else { share };
            view.clearance = view.clearance.min(distance);
        }
        view
    }
}

/// Distance along the unit `direction`, and whether the front is hit.
fn first_hit(triangles: &[[Vec3; 3]], origin: Vec3, direction: Vec3) -> Option<(f32, bool)> {
    let hits = triangles.iter().filter_map(|triangle| intersect(origin, direction, triangle));
    hits.min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Brings the `count` largest triangles to the front.
fn largest_first(triangles: &mut [[Vec3; 3]], count: usize) {
    let area = |[a, b, c]: &[Vec3; 3]| (b - a).cross(c - a).length_squared();
    if triangles.len() > count {
        triangles.select_nth_unstable_by(count, |a, b| area(b).total_cmp(&area(a)));
    }
}

/// Triangles spread evenly over the scene, front faces counter-clockwise.
fn sample(scene: &Scene) -> Vec<[Vec3; 3]> {
    let sparse = scene.triangle_count().div_ceil(EXAMINED).max(1);
    let mut out = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh];
        let stride = sparse.min((mesh.triangle_count() / EXAMINED_PER_INSTANCE).max(1));
        let world = |index: u32| instance.transform.transform_point3(mesh.positions[index as usize].into());
        // A mirrored instance turns its triangles inside out.
        let [second, third] = if instance.transform.matrix3.determinant() < 0.0 { [2, 1] } else { [1, 2] };
        let corners = mesh.indices.chunks_exact(3).step_by(stride);
        out.extend(corners.map(|corner| [world(corner[0]), world(corner[second]), world(corner[third])]));
    }
    out
}

/// Per axis, where the middle 96 % of the triangles' centres lie; `None` without triangles.
fn main_box(triangles: &[[Vec3; 3]]) -> Option<(Vec3, Vec3)> {
    let centers = triangles.iter().map(center);
    let mut along: [Vec<f32>; 3] = Default::default();
    for center in centers {
        (0..3).for_each(|axis| along[axis].push(center[axis]));
    }
    let (mut low, mut high) = (Vec3::ZERO, Vec3::ZERO);
    for (axis, along) in along.iter_mut().enumerate() {
        along.sort_unstable_by(f32::total_cmp);
        let trimmed = along.len() / 50;
        low[axis] = *along.get(trimmed)?;
        high[axis] = along[along.len() - 1 - trimmed];
    }
    Some((low, high))
}

/// Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997), both sides.
fn intersect(origin: Vec3, direction: Vec3, [a, b, c]: &[Vec3; 3]) -> Option<(f32, bool)> {
    let (edge_b, edge_c) = (b - a, c - a);
    let p = direction.cross(edge_c);
    let det = edge_b.dot(p);
    if det == 0.0 {
        return None;
    }
    let to_origin = origin - a;
    let u = to_origin.dot(p) / det;
    let q = to_origin.cross(edge_b);
    let v = direction.dot(q) / det;
    let distance = edge_c.dot(q) / det;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some((distance, det > 0.0))
}

/// Point `k` of Roberts' R3 sequence in the unit cube: the powers of the inverse of the root of x⁴ = x + 1.
fn low_discrepancy(k: usize) -> Vec3 {
    let k = k as f32 + 0.5;
    Vec3::new(k * 0.819_172_5, k * 0.671_043_6, k * 0.549_700_5).fract()
}

/// A Fibonacci spiral of unit vectors.
fn sphere_directions(count: usize) -> Vec<Vec3> {
    let golden_angle = TAU * 0.381_966;
    let direction = |k: usize| {
        let y = 1.0 - (2 * k + 1) as f32 / count as f32;
        let (sin, cos) = (golden_angle * k as f32).sin_cos();
        let r = (1.0 - y * y).sqrt();
        Vec3::new(r * cos, y, r * sin)
    };
    (0..count).map(direction).collect()
}
