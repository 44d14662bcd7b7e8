//! The paraboloid mapping: directions of one hemisphere to the unit disc and back.
//!
//! *Hemisphere space* is light space (world minus the light's position, rotated by the inverse of its
//! orientation) for the front, and light space turned half a circle about Y for the back, so that the
//! hemisphere's axis is +Z in both and winding is kept. A point `X` of it lies at the *map coordinates*
//! `p = X.xy / w` with `w = |X| + X.z`: the unit disc holds the hemisphere, the axis is at the origin, and
//! the mapping is a homogeneous projection, stereographic and therefore conformal.
//!
//! Every function stands a second time in `shaders/paraboloid.wgsl`, with the prefix `dp_` and the same
//! arithmetic; the tests run both. The functions here are in single precision, like the shader's;
//! [`double`] has the same ones in double precision.
//!
//! Sources: Heidrich and Seidel, *View-independent environment maps* (1998), section 3, for the
//! parameterisation; Brabec, Annen and Seidel, *Shadow mapping for hemispherical and omnidirectional light
//! sources* (2002), section 3, for its use with shadows. The homogeneous form, the quadratic of a plane and
//! the circle of an edge follow from `X = w (u, v, (1 - r^2)/2)`, with `r = |p|`.

macro_rules! mapping {
    ($float:ident, $vec2:ident, $vec3:ident, $vec4:ident) => {
        use glam::{swizzles::*, $vec2, $vec3, $vec4};

        /// A vertex whose direction is farther than this from the hemisphere's axis, as the cosine of the
        /// angle (120 degrees), can't belong to a triangle that the hardware draws and that touches the disc, since
        /// none of its edges is longer than [`LONGEST_EDGE`] and the guard band ends before 98 degrees.
        pub const BEHIND: $float = -0.5;

        /// The longest edge, in map coordinates, of casters that the hardware draws (20 degrees on the axis, 10 at the
        /// rim), however little it bends: keeps triangles around the axis behind out of the map.
        pub const LONGEST_EDGE: $float = 0.17;

        /// Light space to hemisphere space and back: the identity for the front, half a turn about Y for
        /// the back.
        #[must_use]
        pub fn to_hemisphere(light_space: $vec3, back: bool) -> $vec3 {
            if back { $vec3::new(-light_space.x, light_space.y, -light_space.z) } else { light_space }
        }

        /// Whether a point of light space belongs to the back hemisphere. The seam (`z = 0`) is the front's.
        #[must_use]
        pub fn is_back(light_space: $vec3) -> bool {
            light_space.z < 0.0
        }

        /// The homogeneous coordinate `|X| + X.z` of a point of hemisphere space, in world units: at most
        /// `2 |X|`, zero only on the axis behind. Free of cancellation in every direction.
        #[must_use]
        pub fn homogeneous_w(x: $vec3) -> $float {
            let length = x.length();
            if x.z < 0.0 { x.xy().dot(x.xy()) / (length - x.z) } else { length + x.z }
        }

        /// Hemisphere space to map coordinates. Points of the hemisphere land in the unit disc; the axis
        /// behind goes to infinity, and is put at 1e18 like the light itself: never infinite, never NaN.
        #[must_use]
        pub fn project(x: $vec3) -> $vec2 {
            let w = homogeneous_w(x);
            if w > 0.0 { x.xy() / w } else { $vec2::new(1e18, 0.0) }
        }

        /// Map coordinates to the point of hemisphere space that has `w = 1`. Its length is `(1 + r^2)/2`.
        #[must_use]
        pub fn unproject_scaled(p: $vec2) -> $vec3 {
            $vec3::new(p.x, p.y, 0.5 - 0.5 * p.dot(p))
        }

        /// Map coordinates to the unit direction in hemisphere space, without a square root.
        #[must_use]
        pub fn unproject(p: $vec2) -> $vec3 {
            unproject_scaled(p) * (2.0 / (1.0 + p.dot(p)))
        }

        /// Clip position (WebGPU: x, y in [-w, w], z in [0, w]) of a point of hemisphere space.
        ///
        /// `scale` is the share of the map's half-width that the unit disc's radius takes, `1/(1 + g)` with
        /// the guard band `g`. After the divide the depth is `near / w`: reversed, 1 near the light, 0 at
        /// infinity. Points far behind the hemisphere (below [`BEHIND`]) are put outside the depth range, so
        /// that triangles around the axis behind are clipped away in place of covering the whole map.
        #[must_use]
        pub fn clip_position(x: $vec3, near: $float, scale: $float) -> $vec4 {
            let length = x.length();
            let w = homogeneous_w(x);
            let z = if x.z < BEHIND * length { 2.0 * length } else { near };
            $vec4::new(x.x * scale, x.y * scale, z, w)
        }

        /// The depth that the map stores for a point of hemisphere space: `near / w`, in (0, 1] for what
        /// isn't clipped; `near` in world units.
        #[must_use]
        pub fn depth(x: $vec3, near: $float) -> $float {
            near / homogeneous_w(x)
        }

        /// The depth of the plane `dot(normal, X) = distance` at map coordinates `p`: a quadratic in `p`,
        /// exact for every direction. Zero or negative where the ray doesn't meet the plane; infinite for a
        /// plane through the light. `normal` need not have unit length.
        #[must_use]
        pub fn plane_depth(normal: $vec3, distance: $float, p: $vec2, near: $float) -> $float {
            (near / distance) * normal.dot(unproject_scaled(p))
        }

        /// Solid angle per unit of map area at `p`, in steradians: `4 / (1 + r^2)^2`, 4 on the axis and 1 at
        /// the rim.
        #[must_use]
        pub fn solid_angle_density(p: $vec2) -> $float {
            let a = 2.0 / (1.0 + p.dot(p));
            a * a
        }

        /// The angle, in radians, that a texel spans at `p`, when a texel is `texel` wide in map coordinates
        /// (`2 (1 + g)/R` for R texels across a map with guard band `g`). Isotropic: the mapping is
        /// conformal.
        #[must_use]
        pub fn texel_angle(p: $vec2, texel: $float) -> $float {
            texel * 2.0 / (1.0 + p.dot(p))
        }

        /// Circle of the map that holds the edge between two points of hemisphere space, as centre and
        /// radius, at least 1, in map coordinates. The radius is infinite for an edge in a plane through the axis.
        #[must_use]
        pub fn edge_arc(a: $vec3, b: $vec3) -> ($vec2, $float) {
            let n = a.cross(b).normalize_or_zero();
            (n.xy() / n.z, 1.0 / n.z.abs())
        }

        /// The angle, in radians, that an edge may span anywhere in the disc for its chord to miss its arc by at most a
        /// `tolerance` in texels, of which there are `texels` per unit of map coordinates. An underestimate except at the rim.
        #[must_use]
        pub fn angle_limit(texels: $float, tolerance: $float) -> $float {
            (8.0 * tolerance / texels).sqrt().min(2.0)
        }
    };
}

mapping!(f32, Vec2, Vec3, Vec4);

/// The mapping in double precision: what the tests hold the single one against, and what the ray-cast
/// reference uses.
pub mod double {
    mapping!(f64, DVec2, DVec3, DVec4);
}
