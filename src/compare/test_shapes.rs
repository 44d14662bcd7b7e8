//! Shapes that the tests of this module share.

use glam::DVec3;
use rand::Rng;
use rand_pcg::Pcg64;

pub fn random_vector(random: &mut Pcg64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)))
}

pub fn random_direction(random: &mut Pcg64) -> DVec3 {
    loop {
        let v = random_vector(random);
        if v.length() > 0.1 {
            return v.normalize();
        }
    }
}

/// A box's twelve triangles.
pub fn box_triangles(min: DVec3, max: DVec3) -> Vec<[DVec3; 3]> {
    let corner = |i: usize| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { min[axis] } else { max[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        .iter()
        .flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]])
        .map(|t| t.map(corner))
        .collect()
}

/// A parallelogram's two triangles: one corner and two sides.
pub fn sheet(corner: DVec3, one: DVec3, other: DVec3) -> Vec<[DVec3; 3]> {
    vec![[corner, corner + one, corner + one + other], [corner, corner + one + other, corner + other]]
}
