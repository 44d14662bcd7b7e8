//! What maps ought to be, in double precision: every triangle is asked at every texel's centre.

use crate::claims::MARGIN;
use crate::common::{Map, Texel, mesh_of};
use crate::hard_cases::scene;
use dual_paraboloid::PointLight;
use dual_paraboloid::compare::measure::Truth;
use dual_paraboloid::compare::reference::{Reference, View};
use dual_paraboloid::compare::scene::Scene;
use dual_paraboloid::paraboloid::double as paraboloid;
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// How far a stored depth may be off, relatively.
pub const DEPTH_ERROR: f64 = 5e-7;

/// How much farther it may be off for planes seen edge-on, in proportion to the inverse sines of the angles between the plane
/// and the directions of the texel and of the nearest corner.
pub const EDGE_ON_ERROR: f64 = 2e-7;

/// How far beyond the tip of a needle, in texels, its planes may still take a texel's centre as inside: however small the
/// margin, a sharp enough tip reaches far with it.
const TIP: f64 = 32.0;

/// Texels along a side of the tiles that share a list of triangles.
const TILE: u32 = 16;

/// A triangle in light space.
#[derive(Debug)]
pub struct Cone {
    triangle: u32,
    /// Directions of the corners.
    corners: [DVec3; 3],
    /// Unit normals, inward, of the planes through the light and an edge.
    edges: [DVec3; 3],
    /// The depth at a texel's scaled direction is the product with this.
    plane: DVec3,
    /// Sine of the angle between the plane and the direction of the corner that is nearest to the light.
    incidence: f64,
    /// Least and greatest depth in each hemisphere, as `depth_limits` in the shader has them.
    limits: [[f64; 2]; 2],
    /// Direction of its middle, and the angle within which all of it is.
    axis: DVec3,
    radius: f64,
}

impl Cone {
    /// `corners` are relative to the light, along the world's axes. None if the light is in the triangle's plane.
    pub fn new(triangle: u32, corners: &[DVec3; 3], view: &View) -> Option<Self> {
        let [a, b, c] = *corners;
        let normal = (b - a).cross(c - a);
        let nearest = [a, b, c].into_iter().min_by(|a, b| a.length().total_cmp(&b.length()))?;
        let distance = normal.dot(nearest);
        let incidence = distance.abs() / (normal.length() * nearest.length());
        // Less is beyond double precision.
        if incidence.is_nan() || incidence < 1e-14 {
            return None;
        }
        let turn = view.orientation.inverse();
        let edge = |a: DVec3, b: DVec3| (turn * (a.cross(b) * distance.signum())).try_normalize();
        let directions = [a, b, c].map(|p| turn * p.normalize());
        let axis = directions.iter().sum::<DVec3>().try_normalize().unwrap_or(directions[0]);
        let radius = directions.iter().map(|d| d.angle_between(axis)).fold(0.0, f64::max);
        Some(Self {
            triangle,
            corners: directions,
            edges: [edge(a, b)?, edge(b, c)?, edge(c, a)?],
            plane: turn * normal * (view.near / distance),
            incidence,
            limits: [false, true]
                .map(|back| limits([a, b, c].map(|p| paraboloid::to_hemisphere(turn * p, back)), view.near)),
            axis,
            // A cap of more than half of the sphere needn't hold the edges.
            radius: if radius < 1.5 { radius } else { PI },
        })
    }

    /// Depth at a scaled direction.
    pub fn depth(&self, q: DVec3) -> f64 {
        self.plane.dot(q)
    }

    /// Sine of the angle by which a direction is inside of all edges; negative outside.
    pub fn inside(&self, d: DVec3) -> f64 {
        self.edges.iter().map(|e| e.dot(d)).fold(f64::MAX, f64::min)
    }

    /// How far a direction is from the triangle, about as an angle; 0 inside.
    fn distance(&self, d: DVec3) -> f64 {
        if self.inside(d) >= 0.0 {
            return 0.0;
        }
        let distance = |i: usize| {
            let (e, a, b) = (self.edges[i], self.corners[i], self.corners[(i + 1) % 3]);
            let turn = e.cross(a).dot(b);
            let beside_the_edge = turn * e.cross(a).dot(d) >= 0.0 && turn * b.cross(e).dot(d) >= 0.0;
            if beside_the_edge { e.dot(d).abs() } else { d.distance(a).min(d.distance(b)) }
        };
        (0..3).map(distance).fold(f64::MAX, f64::min)
    }

    /// Relative error of a stored depth, beyond a tip of the nearest that the corners allow.
    fn depth_error(&self, depth: f64, stored: f64, back: bool, off: f64) -> f64 {
        let [farthest, nearest] = self.limits[usize::from(back)];
        let error = |depth: f64| (stored / depth - 1.0).abs();
        if off > 0.0 { error(depth).min(error(depth.clamp(farthest, nearest))) } else { error(depth) }
    }

    /// How far the depth at a direction may be off, relatively, if the direction is off by an angle.
    pub fn tolerance(&self, d: DVec3, off: f64) -> f64 {
        let grazing = self.plane.dot(d).abs() / self.plane.length();
        DEPTH_ERROR + (EDGE_ON_ERROR + 2.0 * off) * (1.0 / self.incidence + 1.0 / grazing)
    }

    /// Whether it may cover anything within an angle of a direction.
    fn touches(&self, d: DVec3, angle: f64) -> bool {
        let away = -angle.min(1.5).sin();
        (angle > 1.5 || self.edges.iter().all(|e| e.dot(d) >= away))
            && (self.radius + angle > 3.0 || self.axis.dot(d) >= (self.radius + angle).cos())
    }
}

/// Least and greatest depth of a triangle of hemisphere space.
fn limits(corners: [DVec3; 3], near: f64) -> [f64; 2] {
    let (places, depths) = (corners.map(paraboloid::project), corners.map(|x| paraboloid::depth(x, near)));
    let extent = places[0].max(places[1]).max(places[2]) - places[0].min(places[1]).min(places[2]);
    let shortening = 2.2 * extent.length_squared();
    if shortening >= 0.5 {
        return [0.0, f64::MAX];
    }
    let nearest = depths.into_iter().fold(0.0, f64::max) / (1.0 - shortening);
    [depths.into_iter().fold(nearest, f64::min), nearest]
}

/// A scene around a light.
pub struct Twin {
    reference: Arc<Reference>,
    view: View,
    cones: Vec<Cone>,
}

/// How a map differs from its twin.
#[derive(Debug, Clone, Copy, Default)]
pub struct Judgement {
    /// Texels that were judged, and how many of them aren't empty.
    pub texels: usize,
    pub covered: usize,
    /// Texels that are empty where a triangle covers their centre, that aren't where none does, and that show another
    /// triangle than the nearest.
    pub holes: usize,
    pub phantoms: usize,
    pub wrong: usize,
    /// How far from an edge's plane, in texels, the farthest of those is. Infinite if no triangle near by has such a depth.
    pub margin: f64,
    /// The one it is.
    pub worst: Option<Texel>,
    /// Largest relative error of depth, in shares of what is allowed.
    pub depth_error: f64,
    /// The same where planes are seen at more than a degree or so, relative.
    pub plain_depth_error: f64,
}

impl Judgement {
    fn and(self, other: Self) -> Self {
        let worst = if other.margin > self.margin { other.worst } else { self.worst };
        Self {
            texels: self.texels + other.texels,
            covered: self.covered + other.covered,
            holes: self.holes + other.holes,
            phantoms: self.phantoms + other.phantoms,
            wrong: self.wrong + other.wrong,
            margin: self.margin.max(other.margin),
            worst,
            depth_error: self.depth_error.max(other.depth_error),
            plain_depth_error: self.plain_depth_error.max(other.plain_depth_error),
        }
    }

    /// Panics unless at most the margin says which triangle is seen.
    pub fn assert_exact(&self, name: &str) {
        assert!(self.margin <= MARGIN, "{name}: {self:?}");
    }
}

/// What a triangle is to a texel.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Solid {
    Yes,
    No,
    /// The edge of a hole is near.
    Perhaps,
}

impl Twin {
    pub fn new(scene: &Scene, light: &PointLight) -> Self {
        let Truth { reference, view, .. } = Truth::new(scene, light, 0, 1);
        let cone = |(number, corners): (u32, &[DVec3; 3])| Cone::new(number, corners, &view);
        let cones = (0..).zip(reference.triangles()).filter_map(cone).collect();
        Self { reference, view, cones }
    }

    /// Of triangles without shared vertices.
    pub fn of_soup(triangles: &[[Vec3; 3]], light: &PointLight) -> Self {
        Self::new(&scene([mesh_of(triangles)]), light)
    }

    /// Both discs with their guard bands, less one texel.
    pub fn judge(&self, map: &Map) -> Judgement {
        let across = map.resolution.div_ceil(TILE);
        let tiles: Vec<(bool, u32, u32)> = (0..2 * across * across)
            .map(|tile| (tile >= across * across, tile % across, tile / across % across))
            .collect();
        tiles
            .into_par_iter()
            .map(|(back, x, y)| self.judge_tile(map, back, x, y))
            .reduce(Judgement::default, Judgement::and)
    }

    /// Whether a ray through a texel's centre meets a triangle, holes or not.
    pub fn meets(&self, texel: &Texel) -> bool {
        let d = paraboloid::to_hemisphere(paraboloid::unproject(texel.p.as_dvec2()), texel.back);
        self.cones.iter().any(|cone| cone.inside(d) >= 0.0)
    }

    fn judge_tile(&self, map: &Map, back: bool, x: u32, y: u32) -> Judgement {
        let texel = f64::from(map.texel());
        let end = |tile: u32| (TILE * (tile + 1)).min(map.resolution);
        let places = (TILE * y..end(y)).flat_map(|j| (TILE * x..end(x)).map(move |i| (i, j)));
        let texels: Vec<Texel> = places
            .map(|(i, j)| map.texel_at(back, i, j))
            .filter(|texel| texel.p.length() <= map.half_width - map.texel())
            .collect();
        let direction = |texel: &Texel| paraboloid::to_hemisphere(paraboloid::unproject(texel.p.as_dvec2()), back);
        let Some(middle) = texels.get(texels.len() / 2).map(direction) else { return Judgement::default() };
        let reach = texels.iter().map(|t| direction(t).angle_between(middle)).fold(0.0, f64::max);
        let near: Vec<&Cone> = self.cones.iter().filter(|cone| cone.touches(middle, reach + 4.0 * texel)).collect();
        texels.iter().map(|t| self.judge_texel(t, &near, texel)).fold(Judgement::default(), Judgement::and)
    }

    fn judge_texel(&self, texel: &Texel, cones: &[&Cone], width: f64) -> Judgement {
        let p = texel.p.as_dvec2();
        let d = paraboloid::to_hemisphere(paraboloid::unproject(p), texel.back);
        let length = paraboloid::unproject_scaled(p).length();
        let angle = paraboloid::texel_angle(p, width);
        let stored = f64::from(texel.depth);
        let mut result = Judgement { texels: 1, covered: usize::from(stored > 0.0), ..Judgement::default() };
        // How far the texel's centre is at least from some triangle of its depth, and inside of some triangle before that.
        let (mut outside, mut inside) = (if stored > 0.0 { f64::INFINITY } else { 0.0 }, 0.0f64);
        let mut is_covered = false;
        for cone in cones {
            let z = cone.depth(d * length);
            if z <= 0.0 {
                continue;
            }
            let off = (-cone.inside(d)).max(0.0);
            let allowed = cone.tolerance(d, off);
            let error = cone.depth_error(z, stored, texel.back, off);
            let matches = stored > 0.0 && error <= allowed;
            if (!matches && (off > 0.0 || z < stored)) || (off > 0.0 && cone.distance(d) > TIP * angle) {
                continue;
            }
            let solid = self.solid(cone, d, angle);
            if solid == Solid::No || z > 1.0 + allowed {
                continue;
            }
            is_covered |= off == 0.0;
            if matches {
                outside = outside.min(off / angle);
                if off == 0.0 {
                    result.depth_error = result.depth_error.max(error / allowed);
                    if allowed < 50.0 * EDGE_ON_ERROR {
                        result.plain_depth_error = result.plain_depth_error.max(error);
                    }
                }
            } else if solid == Solid::Yes && z < 1.0 - allowed {
                inside = inside.max(cone.inside(d) / angle);
            }
        }
        result.margin = outside.max(inside);
        if result.margin > 0.0 {
            result.worst = Some(*texel);
            let count = match (stored > 0.0, is_covered) {
                (false, _) => &mut result.holes,
                (true, false) => &mut result.phantoms,
                (true, true) => &mut result.wrong,
            };
            *count += 1;
        }
        result
    }

    /// Whether a triangle has no hole in a direction, nor near by.
    fn solid(&self, cone: &Cone, d: DVec3, angle: f64) -> Solid {
        let is_hole = |d: DVec3| self.reference.is_hole(cone.triangle, self.view.orientation * d);
        let (across, along) = d.any_orthonormal_pair();
        let around = (0..8).map(|k| {
            let turn = DVec2::from_angle(TAU * f64::from(k) / 8.0) * (MARGIN * angle);
            d + across * turn.x + along * turn.y
        });
        let here = is_hole(d);
        match (here, around.map(is_hole).all(|other| other == here)) {
            (_, false) => Solid::Perhaps,
            (true, true) => Solid::No,
            (false, true) => Solid::Yes,
        }
    }
}
