//! The functions of `shaders/exact.wgsl` under the same names, in single and in double precision.

use super::{FLAT, LEVEL, OVER, ROUNDING, Surface};
use crate::compare::ideal::{BIAS, FADE, MapGeometry, NO_TRIANGLE, QUORUM, RAMP, SLOPE};
use crate::compare::reference::View;

macro_rules! twins {
    ($float:ident, $vec2:ident, $vec3:ident, $as_vec3:ident, $mapping:path) => {
        use super::*;
        use glam::{$vec2, $vec3};
        use $mapping as paraboloid;

        /// The ray from the light to a receiver as the third of three axes (Duff et al., "Building an Orthonormal Basis,
        /// Revisited", JCGT 2017). Seen along it a walk is one in the plane, with the receiver at the origin; what rounding
        /// loses is an angle, however small a triangle is.
        #[derive(Debug, Clone, Copy)]
        pub struct Frame {
            light: $vec3,
            ray: $vec3,
            s: $float,
            a: $float,
        }

        /// By the light's position in the world and a unit vector.
        #[must_use]
        pub fn walk_frame(light: $vec3, ray: $vec3) -> Frame {
            let s = if ray.z >= 0.0 { 1.0 } else { -1.0 };
            Frame { light, ray, s, a: -1.0 / (s + ray.z) }
        }

        /// A point of the world by these axes.
        #[must_use]
        pub fn walk_see(frame: &Frame, point: $vec3) -> $vec3 {
            let p = point - frame.light;
            let h = p.x * frame.ray.x + p.y * frame.ray.y;
            let k = frame.a * h - p.z;
            $vec3::new(p.x + frame.s * frame.ray.x * k, frame.s * p.y + frame.ray.y * k, h + frame.ray.z * p.z)
        }

        /// On which side of the plane through the light and the edge from `a` to `b` the ray runs: `(a x b).ray`.
        #[must_use]
        pub fn walk_side(a: $vec3, b: $vec3) -> $float {
            a.x * b.y - a.y * b.x
        }

        /// How far beside the edge the ray runs, by [`walk_side`].
        #[must_use]
        pub fn walk_beside(side: $float, a: $vec3, b: $vec3) -> $float {
            side / (b - a).truncate().length_squared().max(1e-30).sqrt()
        }

        /// How a walk ends.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum Walk {
            /// A triangle, by its number, crosses the ray at so many world units from the light.
            Covers {
                /// Above 0.
                distance: $float,
                /// The triangle's number.
                triangle: u32,
            },
            /// The surface ends before the ray.
            Off,
            /// No answer: too many steps, an edge that more than two triangles share, or casters that have changed.
            Lost,
        }

        /// Walks from a triangle over its neighbours towards the ray, over `steps` more triangles at most. Casters that have
        /// changed since the update number `made` aren't those that the map shows.
        #[must_use]
        pub fn walk_from(surface: &Surface, number: u32, made: u32, frame: &Frame, steps: u32) -> Walk {
            if !surface.is_as_of(number, made) {
                return Walk::Lost;
            }
            let see = |vertex: u32| walk_see(frame, surface.vertex(vertex).$as_vec3());
            let mut number = number;
            let mut triangle = surface.triangle(number);
            let [a, b, c] = triangle.corners.map(see);
            let (ab, bc, ca) = (walk_side(a, b), walk_side(b, c), walk_side(c, a));
            let volume = a.z * bc + b.z * ca + c.z * ab;
            // Walks go as if the triangle's front faced away from the light.
            let mut turned = volume < 0.0;
            let sides = [ab, bc, ca].map(|side| if turned { -side } else { side });
            if sides.iter().all(|&side| side >= 0.0) {
                return walk_end(volume.abs(), sides[0] + sides[1] + sides[2], number);
            }
            let seen = [a, b, c];
            let beside: [$float; 3] = std::array::from_fn(|k| walk_beside(sides[k], seen[k], seen[(k + 1) % 3]));
            let mut edge = if beside[1] < beside[0] { 1 } else { 0 };
            if beside[2] < beside[edge] {
                edge = 2;
            }
            let next = (edge + 1) % 3;
            // The edge from p to q is crossed: the ray runs so far on its other side.
            let (from, to) = if turned { (next, edge) } else { (edge, next) };
            let (mut p, mut q) = (seen[from], seen[to]);
            let (mut p_vertex, mut q_vertex) = (triangle.corners[from], triangle.corners[to]);
            let mut crossed = -sides[edge];
            let mut beyond = triangle.beyond[edge];
            for _ in 0..steps {
                if beyond & 3 == 3 {
                    break;
                }
                let chunk = (number >> 8).wrapping_add_signed(beyond as i32 >> 11);
                number = chunk << 8 | beyond >> 3 & 0xff;
                let entered = (beyond & 3) as usize;
                turned ^= beyond & 4 != 0;
                triangle = surface.triangle(number);
                let at = |k: usize| (entered + k) % 3;
                let (first, second) = (triangle.corners[entered], triangle.corners[at(1)]);
                let (p_here, q_here) = if turned { (first, second) } else { (second, first) };
                // Another chunk's, or where a deforming mesh may have come apart.
                if p_here != p_vertex || q_here != q_vertex {
                    (p_vertex, q_vertex) = (p_here, q_here);
                    (p, q) = (see(p_here), see(q_here));
                    crossed = walk_side(q, p);
                }
                let n_vertex = triangle.corners[at(2)];
                let n = see(n_vertex);
                let (pn, nq) = (walk_side(p, n), walk_side(n, q));
                let volume = q.z * pn + p.z * nq + n.z * crossed;
                // It faces the other way: what is behind it the first texel didn't see.
                if volume < 0.0 {
                    return Walk::Off;
                }
                if pn >= 0.0 && nq >= 0.0 {
                    return if crossed >= 0.0 { walk_end(volume, pn + nq + crossed, number) } else { Walk::Off };
                }
                let over_pn = walk_beside(pn, p, n) < walk_beside(nq, n, q);
                beyond = triangle.beyond[at(if over_pn == turned { 2 } else { 1 })];
                if over_pn {
                    (q, q_vertex, crossed) = (n, n_vertex, -pn);
                } else {
                    (p, p_vertex, crossed) = (n, n_vertex, -nq);
                }
            }
            if beyond == crate::neighbours::Beyond::NOTHING.0 { Walk::Off } else { Walk::Lost }
        }

        /// Where the ray crosses a triangle, by the triangle's volume with the light and the sum of its sides.
        fn walk_end(volume: $float, sides: $float, triangle: u32) -> Walk {
            if volume > 0.0 && sides > 0.0 { Walk::Covers { distance: volume / sides, triangle } } else { Walk::Off }
        }

        /// A light's pair of maps and the casters that they show.
        #[derive(Clone, Copy)]
        pub struct Exact<'a> {
            /// Where the light looks from.
            pub view: View,
            /// Size of the maps.
            pub geometry: MapGeometry,
            /// The lookup's bias along a surface's normal, in texel footprints.
            pub normal_bias: f64,
            /// How far receivers may lie from the casters' surface, along their normal, in world units.
            pub receiver_offset: f64,
            /// Number of the casters' update that the maps show.
            pub made: u32,
            /// Depth in each texel of the image of the pair.
            pub depths: &'a [$float],
            /// Triangle in each texel, or [`NO_TRIANGLE`].
            pub numbers: &'a [u32],
            /// The casters.
            pub surface: &'a Surface,
            /// Whether a triangle, by its number, has a hole in a unit direction from the light.
            pub is_hole: &'a (dyn Fn(u32, $vec3) -> bool + Sync),
            /// Triangles beyond the first that a walk looks at.
            pub steps: u32,
        }

        /// A receiver in the map of its hemisphere: `DpReceiver`.
        struct Located {
            position: $vec3,
            normal: $vec3,
            back: bool,
            distance: $float,
            w: $float,
            map: $vec2,
        }

        /// What is known of a receiver whose texels disagree: `DpWalkQuad`.
        #[derive(Debug, Clone, Copy)]
        struct Quad {
            /// [`NO_TRIANGLE`] where there is nothing to ask: no triangle, or the receiver's own surface.
            triangles: [u32; 4],
            /// Votes against.
            dark: [bool; 4],
            /// Votes that would do for a surface that is the receiver's own.
            level: [bool; 4],
            /// Whether a texel holds the receiver's own surface.
            own_seen: bool,
            /// Whether a texel that votes against has no triangle to ask.
            lost: bool,
            /// Bound of (receiver's distance / surface's distance - 1).
            over: $float,
            /// What is nearer than this to the light isn't in the map.
            nearest: $float,
            votes: $float,
        }

        /// What four texels decide, or what it takes to go on.
        enum First {
            Even($float),
            Mixed(Quad),
        }

        impl Exact<'_> {
            /// Share of the light that reaches `position`: 0 or 1 but where no triangle says. `normal` is the receiver's
            /// geometric normal, of any length and either sign; world space both.
            #[must_use]
            pub fn walk_shadow(&self, position: $vec3, normal: $vec3) -> $float {
                match self.walk_first(position, normal) {
                    First::Even(value) => value,
                    First::Mixed(quad) => self.walk_decide(position, &quad),
                }
            }

            /// Whether the four texels around a receiver leave it to their triangles.
            #[must_use]
            pub fn is_mixed(&self, position: $vec3, normal: $vec3) -> bool {
                matches!(self.walk_first(position, normal), First::Mixed(_))
            }

            fn light(&self) -> $vec3 {
                $vec3::from_array(self.view.position.to_array().map(|x| x as $float))
            }

            fn locate(&self, position: $vec3, normal: $vec3) -> Located {
                let rotate = |v: $vec3| {
                    let axis = |axis: glam::DVec3| {
                        let axis = self.view.orientation * axis;
                        $vec3::new(axis.x as $float, axis.y as $float, axis.z as $float).dot(v)
                    };
                    $vec3::new(axis(glam::DVec3::X), axis(glam::DVec3::Y), axis(glam::DVec3::Z))
                };
                let x = rotate(position - self.light());
                let back = paraboloid::is_back(x);
                let own = paraboloid::to_hemisphere(x, back);
                let distance = own.length();
                let w = distance + own.z;
                let map = own.truncate() / w;
                let normal = paraboloid::to_hemisphere(rotate(normal), back);
                Located { position: own, normal, back, distance, w, map }
            }

            /// Depth of the receiver's plane at map coordinates.
            fn plane_depth(&self, receiver: &Located, p: $vec2) -> $float {
                let near = self.view.near as $float;
                let own = near / receiver.w;
                let scale = near / receiver.normal.dot(receiver.position);
                if scale.is_nan() || scale.abs() >= 1e36 {
                    return own;
                }
                let depth = scale * receiver.normal.dot(paraboloid::unproject_scaled(p));
                depth.clamp(SLOPE.0 as $float * own, SLOPE.1 as $float * own)
            }

            fn walk_first(&self, position: $vec3, normal: $vec3) -> First {
                let receiver = self.locate(position, normal);
                if receiver.distance > self.view.range as $float {
                    return First::Even(1.0);
                }
                let (texels, weights) = self.neighbours(&receiver);
                let texel = self.geometry.texel() as $float;
                let footprint = paraboloid::texel_angle(receiver.map, texel);
                let along = receiver.normal.dot(receiver.position).abs();
                let grazing = if along > 0.0 {
                    (receiver.normal.length() * receiver.distance / along).clamp(1.0, 1e3)
                } else {
                    1e3
                };
                let farthest = position.abs().max(self.light().abs()).max_element();
                // Along the ray, over the receiver's distance.
                let offset = self.receiver_offset as $float * grazing / receiver.distance;
                let rounding = ROUNDING as $float * grazing * (3.0 + farthest / receiver.distance) + offset;
                let flat = FLAT as $float * grazing * footprint + rounding;
                let bias = BIAS as $float + self.normal_bias as $float * grazing + offset / footprint;
                let spread = 1.0 + grazing;
                let surely_dark = bias + RAMP as $float * spread;
                let margins =
                    texels.map(|(texel, centre)| self.depths[texel] / self.plane_depth(&receiver, centre) - 1.0);
                if margins.iter().all(|&margin| margin <= flat) {
                    return First::Even(1.0);
                }
                if margins.iter().all(|&margin| margin >= surely_dark * footprint) {
                    return First::Even(0.0);
                }
                let own = margins.map(|margin| margin.abs() <= flat);
                let margins = margins.map(|margin| margin / footprint);
                let dark = margins.map(|margin| margin > bias);
                let level = margins.map(|margin| margin <= bias && margin.abs() < LEVEL as $float * grazing);
                let numbers = texels.map(|(texel, _)| self.numbers[texel]);
                // Of the caller's own casters.
                let unnumbered = |k: &usize| numbers[*k] == NO_TRIANGLE && self.depths[texels[*k].0] > 0.0;
                let unnumbered = || (0..4).filter(unnumbered);
                First::Mixed(Quad {
                    triangles: std::array::from_fn(|k| if own[k] { NO_TRIANGLE } else { numbers[k] }),
                    dark,
                    level,
                    own_seen: own.contains(&true) || unnumbered().any(|k| level[k]),
                    lost: unnumbered().any(|k| dark[k]),
                    over: (OVER.0 as $float + OVER.1 as $float * grazing) * footprint + rounding,
                    nearest: self.view.near as $float * receiver.distance / receiver.w,
                    votes: votes(&margins, &weights, bias, spread),
                })
            }

            /// The four texels around a receiver: index in the image of the pair, map coordinates, bilinear weight.
            fn neighbours(&self, receiver: &Located) -> ([(usize, $vec2); 4], [$float; 4]) {
                let resolution = self.geometry.resolution;
                let half = 0.5 * resolution as $float;
                let texel = self.geometry.texel() as $float;
                let at = half + receiver.map * $vec2::new(1.0, -1.0) / texel - 0.5;
                let last = resolution.saturating_sub(2) as $float;
                let base = at.floor().clamp($vec2::ZERO, $vec2::splat(last));
                let f = (at - base).clamp($vec2::ZERO, $vec2::ONE);
                let neighbour = |(x, y): (u32, u32)| {
                    let (i, j) = ((base.x as u32 + x).min(resolution - 1), (base.y as u32 + y).min(resolution - 1));
                    let centre = $vec2::new(i as $float + 0.5 - half, half - j as $float - 0.5) * texel;
                    (self.geometry.index(receiver.back, i, j), centre)
                };
                let (columns, rows) = ([1.0 - f.x, f.x], [1.0 - f.y, f.y]);
                let places = [(0, 0), (1, 0), (0, 1), (1, 1)];
                (places.map(neighbour), places.map(|(x, y)| columns[x as usize] * rows[y as usize]))
            }

            fn walk_decide(&self, position: $vec3, quad: &Quad) -> $float {
                let relative = position - self.light();
                let distance = relative.length();
                let ray = relative / distance;
                let frame = walk_frame(self.light(), ray);
                let (mut own, mut lost) = (quad.own_seen, quad.lost);
                for k in 0..4 {
                    let number = quad.triangles[k];
                    if number == NO_TRIANGLE {
                        continue;
                    }
                    match walk_from(self.surface, number, self.made, &frame, self.steps) {
                        Walk::Covers { distance: reached, triangle } => {
                            if reached < quad.nearest || (self.is_hole)(triangle, ray) {
                                continue;
                            }
                            let margin = distance / reached - 1.0;
                            if margin > quad.over {
                                return 0.0;
                            }
                            own = true;
                        }
                        Walk::Off => {}
                        Walk::Lost => {
                            lost |= quad.dark[k];
                            own |= quad.level[k];
                        }
                    }
                }
                if own && !lost { 1.0 } else { quad.votes }
            }
        }

        /// The share of the light that four texels vote for by their margins, in texel footprints.
        fn votes(margins: &[$float; 4], weights: &[$float; 4], bias: $float, spread: $float) -> $float {
            let (mut lit, mut dark) = (0.0, 0.0);
            for (margin, weight) in margins.iter().zip(weights) {
                let before = (1.0 - margin / bias).max(0.0);
                let behind = 1.0 / (1.0 - margin.min(0.0) / (FADE as $float * spread));
                lit += weight * if *margin < 0.0 { behind } else { before };
                dark += weight * ((margin - bias) / (RAMP as $float * spread)).clamp(0.0, 1.0);
            }
            (1.0 - dark / (lit + dark).max(QUORUM as $float)).max(0.0)
        }
    };
}

/// In single precision, as shaders have it.
pub mod single {
    twins!(f32, Vec2, Vec3, to_owned, crate::paraboloid);
}

/// In double precision.
pub mod double {
    twins!(f64, DVec2, DVec3, as_dvec3, crate::paraboloid::double);
}
