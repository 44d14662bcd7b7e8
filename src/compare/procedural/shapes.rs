//! Triangle meshes of simple shapes, in object space.
//!
//! All but [`quad`] are closed: every edge has two triangles, which meet in bit-equal positions. Triangles are
//! counter-clockwise seen from outside (right-handed), normals point outwards. Every mesh has material 0.

use std::{collections::HashMap, f64::consts::TAU};

use glam::{Affine3A, DVec3, Vec3};

use crate::compare::scene::SceneMesh;

/// A parallelogram of two triangles with a corner at `corner` and the sides `u` and `v`; it faces along `u` × `v`.
#[must_use]
pub fn quad(corner: Vec3, u: Vec3, v: Vec3) -> SceneMesh {
    let corners = [corner, corner + u, corner + u + v, corner + v];
    let mut mesh = SceneMesh { normals: Some(Vec::new()), ..SceneMesh::default() };
    push_face(&mut mesh, &corners, u.cross(v).normalize());
    mesh
}

/// An axis-aligned box of 12 triangles from `low` to `high`, which must be larger in every coordinate.
#[must_use]
pub fn cuboid(low: Vec3, high: Vec3) -> SceneMesh {
    let mut mesh = SceneMesh { normals: Some(Vec::new()), ..SceneMesh::default() };
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for upper in [false, true] {
            let corner = |along_u: bool, along_v: bool| {
                let mut corner = low;
                for (axis, is_high) in [(axis, upper), (u, along_u), (v, along_v)] {
                    corner[axis] = if is_high { high[axis] } else { low[axis] };
                }
                corner
            };
            let mut corners = [corner(false, false), corner(true, false), corner(true, true), corner(false, true)];
            let mut normal = Vec3::ZERO;
            normal[axis] = if upper { 1.0 } else { -1.0 };
            if !upper {
                corners.reverse();
            }
            push_face(&mut mesh, &corners, normal);
        }
    }
    mesh
}

/// A regular tetrahedron of 4 triangles, its corners at distance `radius` (positive) from the origin.
#[must_use]
pub fn tetrahedron(radius: f32) -> SceneMesh {
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let corners = corners.map(|corner| Vec3::from(corner) * (radius / 3.0_f32.sqrt()));
    let mut mesh = SceneMesh { normals: Some(Vec::new()), ..SceneMesh::default() };
    for [a, b, c] in [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]] {
        let face = [corners[a], corners[b], corners[c]];
        push_face(&mut mesh, &face, (face[0] + face[1] + face[2]).normalize());
    }
    mesh
}

/// A sphere around the origin of 20 · 4^`subdivisions` triangles of nearly equal size, from an icosahedron.
///
/// # Panics
///
/// If `subdivisions` is above 10, which would be 21 million triangles.
#[must_use]
pub fn icosphere(radius: f32, subdivisions: u32) -> SceneMesh {
    assert!(subdivisions <= 10, "icosphere of {subdivisions} subdivisions: use 10 at most");
    let (mut points, mut triangles) = icosahedron();
    for _ in 0..subdivisions {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        let split = |&[a, b, c]: &[u32; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.iter().flat_map(split).collect();
    }
    SceneMesh {
        positions: points.iter().map(|&point| (point * f64::from(radius)).as_vec3().to_array()).collect(),
        normals: Some(points.iter().map(|point| point.as_vec3().to_array()).collect()),
        indices: triangles.into_flattened(),
        ..SceneMesh::default()
    }
}

fn icosahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points = Vec::new();
    for (a, b) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        points.extend([DVec3::new(a, b, 0.0), DVec3::new(0.0, a, b), DVec3::new(b, 0.0, a)].map(DVec3::normalize));
    }
    // Of all triples, a face is one whose corners are an edge apart; that length is 1.05 on the unit sphere.
    let near = |a: u32, b: u32| points[a as usize].distance(points[b as usize]) < 1.1;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let [pa, pb, pc] = [a, b, c].map(|k| points[k as usize]);
                    let outwards = (pb - pa).cross(pc - pa).dot(pa) > 0.0;
                    triangles.push(if outwards { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    (points, triangles)
}

/// A sphere around the origin, with its poles on the y axis, of 2 · `slices` · (`stacks` - 1) triangles.
///
/// # Panics
///
/// If `slices` is below 3 or `stacks` below 2.
#[must_use]
pub fn uv_sphere(radius: f32, slices: u32, stacks: u32) -> SceneMesh {
    displaced_sphere(slices, stacks, |direction| direction * f64::from(radius))
}

/// A sphere like [`uv_sphere`] with `shape` applied to each unit vector; normals follow the triangles.
///
/// # Panics
///
/// If `slices` is below 3 or `stacks` below 2.
#[must_use]
pub fn displaced_sphere(slices: u32, stacks: u32, shape: impl Fn(DVec3) -> DVec3) -> SceneMesh {
    assert!(slices >= 3 && stacks >= 2, "sphere of {slices} slices and {stacks} stacks: use 3 and 2 at least");
    let mut points = vec![DVec3::Y];
    for stack in 1..stacks {
        let (ring, y) = (TAU / 2.0 * f64::from(stack) / f64::from(stacks)).sin_cos();
        points.extend((0..slices).map(|slice| {
            let (sin, cos) = (TAU * f64::from(slice) / f64::from(slices)).sin_cos();
            DVec3::new(ring * cos, y, -ring * sin)
        }));
    }
    points.push(DVec3::NEG_Y);
    let at = |stack: u32, slice: u32| 1 + (stack - 1) * slices + slice % slices;
    let last = points.len() as u32 - 1;
    let mut indices = Vec::new();
    for slice in 0..slices {
        indices.extend([0, at(1, slice), at(1, slice + 1)]);
        for stack in 1..stacks - 1 {
            let [a, b] = [at(stack, slice), at(stack, slice + 1)];
            let [c, d] = [at(stack + 1, slice), at(stack + 1, slice + 1)];
            indices.extend([a, c, d, a, d, b]);
        }
        indices.extend([at(stacks - 1, slice), last, at(stacks - 1, slice + 1)]);
    }
    smooth(points.into_iter().map(|point| shape(point).as_vec3()).collect(), indices)
}

/// An upright prism of 4 · `sides` - 4 triangles around the y axis, from y = 0 to `height`, shaded as round.
///
/// # Panics
///
/// If `sides` is below 3.
#[must_use]
pub fn cylinder(radius: f32, height: f32, sides: u32) -> SceneMesh {
    assert!(sides >= 3, "cylinder of {sides} sides: use 3 at least");
    let outwards: Vec<Vec3> = (0..sides)
        .map(|side| {
            let (sin, cos) = (TAU * f64::from(side) / f64::from(sides)).sin_cos();
            DVec3::new(cos, 0.0, -sin).as_vec3()
        })
        .collect();
    let ring = |y: f32| outwards.iter().map(move |&direction| direction * radius + Vec3::Y * y);
    let mut mesh = SceneMesh { normals: Some(Vec::new()), ..SceneMesh::default() };
    push_face(&mut mesh, &ring(height).collect::<Vec<_>>(), Vec3::Y);
    push_face(&mut mesh, &ring(0.0).rev().collect::<Vec<_>>(), Vec3::NEG_Y);
    let base = mesh.positions.len() as u32;
    mesh.positions.extend(ring(0.0).chain(ring(height)).map(|position| position.to_array()));
    mesh.normals.get_or_insert_default().extend(outwards.iter().chain(&outwards).map(Vec3::to_array));
    for side in 0..sides {
        let [a, b] = [base + side, base + (side + 1) % sides];
        mesh.indices.extend([a, b, b + sides, a, b + sides, a + sides]);
    }
    mesh
}

/// A ring around the y axis of 2 · `segments` · `sides` triangles: a circle of radius `minor` swept along one of
/// radius `major`, which must be larger.
///
/// # Panics
///
/// If `segments` or `sides` is below 3.
#[must_use]
pub fn torus(major: f32, minor: f32, segments: u32, sides: u32) -> SceneMesh {
    sweep(segments, sides, |along, around| {
        let ((sin, cos), (rise, reach)) = (along.sin_cos(), around.sin_cos());
        let outwards = DVec3::new(cos, 0.0, -sin);
        outwards * (f64::from(major) + f64::from(minor) * reach) + DVec3::Y * (f64::from(minor) * rise)
    })
}

/// A (2, 3) torus knot with a rippled surface, about 3.3 · `radius` wide, of 2 · `segments` · `sides` triangles.
///
/// # Panics
///
/// If `segments` or `sides` is below 3.
#[must_use]
pub fn torus_knot(radius: f32, segments: u32, sides: u32) -> SceneMesh {
    let radius = f64::from(radius);
    let path = |angle: f64| {
        let ((sin, cos), (rise, reach)) = ((2.0 * angle).sin_cos(), (3.0 * angle).sin_cos());
        DVec3::new(cos, 0.0, -sin) * (radius * (1.0 + 0.42 * reach)) + DVec3::Y * (radius * 0.42 * rise)
    };
    sweep(segments, sides, |along, around| {
        let center = path(along);
        let tangent = (path(along + 1e-4) - path(along - 1e-4)).normalize();
        // The middle of the torus under the path lies beside the tangent everywhere, so this frame never flips.
        let outwards = DVec3::new(center.x, 0.0, center.z).normalize();
        let side = (outwards - tangent * outwards.dot(tangent)).normalize();
        let up = tangent.cross(side);
        let ripple = 1.0 + 0.10 * (24.0 * along + 2.0 * around).sin() + 0.05 * (5.0 * around - 18.0 * along).sin();
        let (sin, cos) = around.sin_cos();
        center + (side * cos - up * sin) * (0.2 * radius * ripple)
    })
}

/// A closed surface over two angles in 0..2π: `point(along, around)`, outwards on the right of `along` × `around`.
fn sweep(segments: u32, sides: u32, point: impl Fn(f64, f64) -> DVec3) -> SceneMesh {
    assert!(segments >= 3 && sides >= 3, "sweep of {segments} segments and {sides} sides: use 3 of each at least");
    let angle = |k: u32, count: u32| TAU * f64::from(k) / f64::from(count);
    let grid = (0..segments).flat_map(|segment| (0..sides).map(move |side| (segment, side)));
    let at = |segment: u32, side: u32| segment % segments * sides + side % sides;
    let quad = |(segment, side)| {
        let [a, b] = [at(segment, side), at(segment + 1, side)];
        let [c, d] = [at(segment + 1, side + 1), at(segment, side + 1)];
        [a, b, c, a, c, d]
    };
    let position = |(segment, side)| point(angle(segment, segments), angle(side, sides)).as_vec3();
    smooth(grid.clone().map(position).collect(), grid.flat_map(quad).collect())
}

/// Adds `part`, placed by `transform` (which must not mirror), to `mesh`; both need normals or both none.
pub fn append(mesh: &mut SceneMesh, part: &SceneMesh, transform: Affine3A) {
    let base = mesh.positions.len() as u32;
    let place = |&position: &[f32; 3]| transform.transform_point3(position.into()).to_array();
    mesh.positions.extend(part.positions.iter().map(place));
    if let Some(normals) = &part.normals {
        let to_normal = transform.matrix3.inverse().transpose();
        let turn = |&normal: &[f32; 3]| (to_normal * Vec3::from(normal)).normalize_or_zero().to_array();
        mesh.normals.get_or_insert_default().extend(normals.iter().map(turn));
    }
    mesh.indices.extend(part.indices.iter().map(|index| base + index));
}

/// Adds a convex flat polygon, counter-clockwise, as a fan with vertices of its own.
fn push_face(mesh: &mut SceneMesh, corners: &[Vec3], normal: Vec3) {
    let base = mesh.positions.len() as u32;
    mesh.positions.extend(corners.iter().map(Vec3::to_array));
    mesh.normals.get_or_insert_default().resize(mesh.positions.len(), normal.to_array());
    for k in 1..corners.len() as u32 - 1 {
        mesh.indices.extend([base, base + k, base + k + 1]);
    }
}

/// A mesh whose vertex normals are the area-weighted mean of the triangles around them.
fn smooth(positions: Vec<Vec3>, indices: Vec<u32>) -> SceneMesh {
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for corner in indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|k| positions[corner[k] as usize]);
        for &index in corner {
            normals[index as usize] += (b - a).cross(c - a);
        }
    }
    SceneMesh {
        positions: positions.iter().map(Vec3::to_array).collect(),
        normals: Some(normals.iter().map(|normal| normal.normalize_or_zero().to_array()).collect()),
        indices,
        ..SceneMesh::default()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    fn shapes() -> Vec<(&'static str, SceneMesh, usize)> {
        vec![
            ("cuboid", cuboid(Vec3::new(-1.0, 0.0, 2.0), Vec3::new(1.0, 3.0, 2.5)), 12),
            ("tetrahedron", tetrahedron(0.7), 4),
            ("icosphere", icosphere(2.0, 3), 1280),
            ("uv_sphere", uv_sphere(2.0, 14, 8), 196),
            ("cylinder", cylinder(0.5, 3.0, 16), 60),
            ("torus", torus(1.0, 0.2, 12, 6), 144),
            ("torus_knot", torus_knot(1.0, 400, 24), 19_200),
        ]
    }

    fn corner(mesh: &SceneMesh, at: usize) -> Vec3 {
        mesh.positions[mesh.indices[at] as usize].into()
    }

    #[test]
    fn triangle_counts_are_those_documented() {
        for (name, mesh, count) in shapes() {
            assert_eq!(mesh.triangle_count(), count, "{name}");
        }
        assert_eq!(quad(Vec3::ZERO, Vec3::X, Vec3::Y).triangle_count(), 2);
    }

    #[test]
    fn solids_are_closed_over_bit_equal_positions() {
        for (name, mesh, _) in shapes() {
            let bits = |at: usize| corner(&mesh, at).to_array().map(f32::to_bits);
            let mut edges = HashSet::new();
            for first in (0..mesh.indices.len()).step_by(3) {
                for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                    assert!(edges.insert((bits(first + a), bits(first + b))), "{name}: an edge runs twice one way");
                }
            }
            let open = edges.iter().filter(|(a, b)| !edges.contains(&(*b, *a))).count();
            assert_eq!(open, 0, "{name}: open edges");
        }
    }

    #[test]
    fn solids_face_outwards_and_normals_agree() {
        for (name, mesh, _) in shapes() {
            let normals = mesh.normals.as_ref().expect("all shapes have normals");
            let mut volume = 0.0;
            for first in (0..mesh.indices.len()).step_by(3) {
                let [a, b, c] = [0, 1, 2].map(|k| corner(&mesh, first + k));
                volume += a.dot(b.cross(c)) / 6.0;
                for k in 0..3 {
                    let normal = Vec3::from(normals[mesh.indices[first + k] as usize]);
                    assert!((normal.length() - 1.0).abs() < 1e-5, "{name}: normal {normal}");
                    assert!(normal.dot((b - a).cross(c - a)) > 0.0, "{name}: normal against its triangle");
                }
            }
            assert!(volume > 0.0, "{name}: volume {volume}");
        }
    }

    #[test]
    fn quad_faces_along_the_cross_product() {
        let mesh = quad(Vec3::ONE, Vec3::X * 2.0, Vec3::Z);
        let [a, b, c] = [0, 1, 2].map(|k| corner(&mesh, k));
        assert_eq!((b - a).cross(c - a).normalize(), Vec3::NEG_Y);
    }
}
