//! The floor at a resolution: a map whose every texel centre was ray-cast, and the lookup in double precision.
//!
//! What [`Lookup`] gets wrong on an [`IdealMap`] is owed to the resolution and to the lookup's own rule. What the
//! library gets wrong beyond that is owed to the library.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::reference::{Reference, View};
use crate::paraboloid::double as paraboloid;

/// In [`IdealMap::triangles`]: no caster in that direction.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// Size of a pair of maps. Both hemispheres lie side by side in one image of `2R x R` texels, the front at columns
/// `0..R`, the back at `R..2R`, row 0 on top (map coordinate v up, rows down).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapGeometry {
    /// Texels along one side of one hemisphere's map, R.
    pub resolution: u32,
    /// Width of the guard band in map coordinates, g: the map reaches from `-(1 + g)` to `1 + g`.
    pub guard: f64,
}

impl MapGeometry {
    /// Side of a texel in map coordinates, `2 (1 + g)/R`.
    #[must_use]
    pub fn texel(&self) -> f64 {
        2.0 * (1.0 + self.guard) / f64::from(self.resolution)
    }

    /// Number of texels of the pair, both whole squares.
    #[must_use]
    pub fn texels(&self) -> usize {
        2 * self.resolution as usize * self.resolution as usize
    }

    /// Map coordinates of the centre of the texel in column `i` and row `j` of its hemisphere's map.
    #[must_use]
    pub fn centre(&self, i: u32, j: u32) -> DVec2 {
        let half = 0.5 * f64::from(self.resolution);
        DVec2::new(f64::from(i) + 0.5 - half, half - f64::from(j) - 0.5) * self.texel()
    }

    /// Where map coordinates lie in their hemisphere's map, in texels from its upper left corner.
    #[must_use]
    pub fn position(&self, p: DVec2) -> DVec2 {
        let half = 0.5 * f64::from(self.resolution);
        DVec2::splat(half) + DVec2::new(p.x, -p.y) / self.texel()
    }

    /// Index of a texel in the image of the pair.
    #[must_use]
    pub fn index(&self, back: bool, i: u32, j: u32) -> usize {
        let r = self.resolution as usize;
        2 * r * j as usize + r * usize::from(back) + i as usize
    }

    /// Hemisphere, column and row of a texel of the image of the pair: undoes [`MapGeometry::index`].
    #[must_use]
    pub fn texel_at(&self, index: usize) -> (bool, u32, u32) {
        let r = self.resolution as usize;
        let (row, column) = (index / (2 * r), index % (2 * r));
        (column >= r, (column % r) as u32, row as u32)
    }

    /// Whether map coordinates lie in the disc that a map holds, guard band included.
    #[must_use]
    pub fn in_disc(&self, p: DVec2) -> bool {
        p.length() <= 1.0 + self.guard
    }
}

/// A pair of maps, ray-cast at its texel centres.
pub struct IdealMap {
    /// What of the light's surroundings the image shows.
    pub geometry: MapGeometry,
    /// For each texel of the image, the depth `near / w` of the nearest caster, 0 where there is none and outside the
    /// disc. Casters beyond the light's range are in it.
    pub depths: Vec<f64>,
    /// For each texel the triangle that was hit, or [`NO_TRIANGLE`].
    pub triangles: Vec<u32>,
}

/// Casts a ray through each texel centre of both discs, guard bands included.
#[must_use]
pub fn ideal_map(reference: &Reference, view: &View, geometry: MapGeometry) -> IdealMap {
    let (depths, triangles) = (0..geometry.texels())
        .into_par_iter()
        .map(|index| {
            let (back, i, j) = geometry.texel_at(index);
            ideal_texel(reference, view, &geometry, back, geometry.centre(i, j))
        })
        .unzip();
    IdealMap {
        geometry,
        depths,
        triangles,
    }
}

/// Depth and triangle that a map should hold at map coordinates `p`.
fn ideal_texel(reference: &Reference, view: &View, geometry: &MapGeometry, back: bool, p: DVec2) -> (f64, u32) {
    if !geometry.in_disc(p) {
        return (0.0, NO_TRIANGLE);
    }
    let d = paraboloid::unproject(p);
    reference
        .nearest(view.to_world(d, back), view.clip_distance(d))
        .map_or((0.0, NO_TRIANGLE), |hit| {
            (paraboloid::depth(d * hit.t, view.near), hit.triangle)
        })
}

/// The lookup of `shaders/lookup.wgsl` in double precision: the same steps under the same names.
#[derive(Clone, Copy, Debug)]
pub struct Lookup {
    /// Where the light looks from.
    pub view: View,
    /// Size of the maps.
    pub geometry: MapGeometry,
    /// Depth bias k: how far the receiver is moved toward the light, in texel footprints at the receiver. Too little
    /// shows as acne on curved casters, too much as peter-panning.
    pub bias: f64,
}

/// Bounds of the ratio between the depths of the receiver's plane at a texel centre and at the receiver, against
/// planes that are seen edge-on.
pub const PLANE_RATIO: (f64, f64) = (0.25, 4.0);

/// A receiver in the map of its hemisphere.
struct Located {
    back: bool,
    /// Map coordinates.
    p: DVec2,
    /// Depth of the receiver, `near / w`.
    depth: f64,
    /// Geometric normal in hemisphere space.
    normal: DVec3,
}

impl Lookup {
    /// How much of the light reaches a point of the world, from 0 (shadow) to 1 (lit), by the bilinear filter over the
    /// four nearest texels. `stored` gives the depth in a texel of the image of the pair; `normal` is the receiver's
    /// geometric normal in the world, of any length and either sign.
    #[must_use]
    pub fn shadow(&self, stored: impl Fn(usize) -> f64, position: DVec3, normal: DVec3) -> f64 {
        let receiver = self.locate(position, normal);
        let reference_depth = self.biased_depth(&receiver);
        self.sample(stored, &receiver, reference_depth)
    }

    fn locate(&self, position: DVec3, normal: DVec3) -> Located {
        let (x, back) = self.view.to_hemisphere(position - self.view.position);
        let normal = paraboloid::to_hemisphere(self.view.orientation.inverse() * normal, back);
        Located {
            back,
            p: paraboloid::project(x),
            depth: paraboloid::depth(x, self.view.near),
            normal,
        }
    }

    /// The receiver's depth, moved toward the light by the bias.
    fn biased_depth(&self, receiver: &Located) -> f64 {
        receiver.depth / (1.0 - self.bias * paraboloid::texel_angle(receiver.p, self.geometry.texel()))
    }

    /// Compares each of the four texels with the receiver's plane at that texel's centre.
    fn sample(&self, stored: impl Fn(usize) -> f64, receiver: &Located, reference_depth: f64) -> f64 {
        let at = self.geometry.position(receiver.p) - 0.5;
        let base = at.floor();
        let fraction = at - base;
        let mut lit = 0.0;
        for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let last = f64::from(self.geometry.resolution - 1);
            let texel = (base + DVec2::new(dx, dy)).clamp(DVec2::ZERO, DVec2::splat(last));
            let (i, j) = (texel.x as u32, texel.y as u32);
            let reference = reference_depth * plane_ratio(receiver, self.geometry.centre(i, j));
            if stored(self.geometry.index(receiver.back, i, j)) <= reference {
                let weight = DVec2::new(1.0 - dx, 1.0 - dy) + fraction * DVec2::new(2.0 * dx - 1.0, 2.0 * dy - 1.0);
                lit += weight.x * weight.y;
            }
        }
        lit
    }
}

/// Depth of the receiver's plane at map coordinates `q`, relative to its depth at the receiver.
fn plane_ratio(receiver: &Located, q: DVec2) -> f64 {
    let at_receiver = receiver.normal.dot(paraboloid::unproject_scaled(receiver.p));
    let at_texel = receiver.normal.dot(paraboloid::unproject_scaled(q));
    // A light in the receiver's plane has no ratio (0/0): any will do.
    let ratio = if at_receiver == 0.0 {
        1.0
    } else {
        at_texel / at_receiver
    };
    ratio.clamp(PLANE_RATIO.0, PLANE_RATIO.1)
}
