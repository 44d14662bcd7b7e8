//! Closed shells leave no texel empty.

use crate::common::{Rasteriser, soup, tunings};
use crate::hard_cases::orientation;
use dual_paraboloid::{PointLight, Sides};
use glam::Vec3;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// Edges shorter than this aren't cut.
const SHORTEST: f32 = 1e-3;

/// A closed surface around the origin, star-shaped, of triangles of wildly mixed sizes: an octahedron whose edges
/// are cut at random places, most often where one was just cut, and whose vertices are then moved along their rays.
pub fn shell(cuts: usize, rng: &mut Pcg64) -> Vec<[Vec3; 3]> {
    let mut vertices = vec![Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let mut triangles: Vec<[usize; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..cuts {
        let recent = triangles.len().min(12);
        let pick = if rng.random_bool(0.7) {
            triangles.len() - 1 - rng.random_range(0..recent)
        } else {
            rng.random_range(0..triangles.len())
        };
        let turn = rng.random_range(0..3);
        let (a, b) = (triangles[pick][turn], triangles[pick][(turn + 1) % 3]);
        if vertices[a].distance(vertices[b]) < SHORTEST {
            continue;
        }
        vertices.push(vertices[a].lerp(vertices[b], rng.random_range(0.2..0.8)));
        let middle = vertices.len() - 1;
        for t in (0..triangles.len()).rev() {
            let has = |v| triangles[t].contains(&v);
            if has(a) && has(b) {
                let with = |from: usize| triangles[t].map(|v| if v == from { middle } else { v });
                let halves = [with(a), with(b)];
                triangles[t] = halves[0];
                triangles.push(halves[1]);
            }
        }
    }
    for vertex in &mut vertices {
        *vertex = vertex.normalize() * rng.random_range(1.0..3.0);
    }
    triangles.into_iter().map(|t| t.map(|v| vertices[v])).collect()
}

/// Tunings by which an invocation of a software device may have more to do than llvmpipe lets it: that ends loops after
/// 65,535 rounds in all.
fn is_too_much(tuning: &str, resolution: u32) -> bool {
    resolution > 200
        && tuning.starts_with("software's")
        && (tuning.ends_with("all small") || tuning.ends_with("one record"))
}

#[test]
fn shells_have_no_holes_in_any_orientation() {
    let mut rng = Pcg64::seed_from_u64(5);
    for (resolution, rounds) in [(64, 12), (200, 4), (512, 1)] {
        let mut rasterisers = Rasteriser::all(tunings(), resolution);
        rasterisers.retain(|rasteriser| !is_too_much(rasteriser.name, resolution));
        let count = rasterisers.len();
        for number in 0..rounds * count {
            let mut casters = soup(&shell([0, 20, 300, 1500][number % 4], &mut rng), Sides::Auto);
            let light = PointLight { orientation: orientation(&mut rng), ..Default::default() };
            // In the end each tuning has drawn shells of all sizes.
            let rasteriser = &mut rasterisers[(number + number / count) % count];
            let map = rasteriser.map(&mut casters, light);
            let holes: Vec<_> = map.discs().filter(|texel| texel.depth == 0.0).collect();
            let name = format!("shell {number} at {resolution}, {}", rasteriser.name);
            assert!(holes.is_empty(), "{name}: {} holes, as at {:?}", holes.len(), holes[0]);
        }
    }
}
