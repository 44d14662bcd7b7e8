//! Closed shells leave no texel empty.

use crate::common::{map, soup};
use dual_paraboloid::{PointLight, Sides};
use glam::{Quat, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// Edges shorter than this aren't cut: the triangles still go from a millionth of a map to half of it. With shorter
/// ones, or many more cuts, llvmpipe 22.3 leaves about one texel in ten million empty, where a sliver thinner than its
/// grid of 1/256 texel passes a texel's centre.
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

#[test]
fn shells_have_no_holes_in_any_orientation() {
    let mut rng = Pcg64::seed_from_u64(5);
    for turn in 0..50 {
        let triangles = shell([0, 20, 300, 1500][turn % 4], &mut rng);
        let mut casters = soup(&triangles, Sides::Auto);
        let orientation = Quat::from_xyzw(
            rng.random_range(-1.0..1.0f32),
            rng.random_range(-1.0..1.0),
            rng.random_range(-1.0..1.0),
            rng.random_range(-1.0..1.0),
        )
        .normalize();
        let light = PointLight { orientation, ..Default::default() };
        for resolution in [64, 200, 512] {
            let map = map(&mut casters, light, resolution);
            let holes: Vec<_> = map.discs().filter(|texel| texel.depth == 0.0).collect();
            assert!(holes.is_empty(), "shell {turn} at {resolution}: {} holes, as at {:?}", holes.len(), holes[0]);
        }
    }
}
