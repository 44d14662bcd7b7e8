//! The insides of closed pieces, which nobody outside sees.

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;

use crate::chunks::ClosedPiece;

/// For each triangle (relative to the light), whether the side that faces the light is the inside of a closed piece
/// that the light is outside of.
///
/// # Panics
/// When there is not one entry of `pieces` a triangle.
pub(super) fn hidden_sides(triangles: &[[DVec3; 3]], pieces: &[Option<ClosedPiece>]) -> Vec<bool> {
    assert!(pieces.len() == triangles.len(), "one entry of `pieces` a triangle");
    let closed = (0..).zip(pieces).filter_map(|(triangle, piece)| Some((triangle, (*piece)?)));
    let mut members: Vec<(usize, ClosedPiece)> = closed.collect();
    members.sort_by_key(|(_, piece)| piece.triangle);
    let members: Vec<&[_]> = members.chunk_by(|(_, one), (_, other)| one.triangle == other.triangle).collect();
    let hidden = members.into_par_iter().filter(|members| {
        let corners = members.iter().map(|(triangle, _)| &triangles[*triangle]);
        !holds_light(corners)
    });
    let hidden = hidden.flat_map_iter(|members| {
        let inside_faces_light =
            |(triangle, piece): &&(usize, ClosedPiece)| faces_light(&triangles[*triangle]) == piece.inside_out;
        members.iter().filter(inside_faces_light).map(|(triangle, _)| *triangle)
    });
    let mut result = vec![false; triangles.len()];
    hidden.collect::<Vec<_>>().into_iter().for_each(|triangle| result[triangle] = true);
    result
}

/// Whether a triangle's front faces the light.
fn faces_light(corners: &[DVec3; 3]) -> bool {
    (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(corners[0]) < 0.0
}

/// Whether the light, at the origin, is inside a closed piece: where the piece winds around it.
fn holds_light<'a>(triangles: impl Iterator<Item = &'a [DVec3; 3]> + Clone) -> bool {
    let corners = triangles.clone().flatten();
    let bounds = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = corners.fold(bounds, |(low, high), &corner| (low.min(corner), high.max(corner)));
    let within_bounds = low.cmple(DVec3::ZERO).all() && high.cmpge(DVec3::ZERO).all();
    // A whole number of turns of 2 tau but for rounding, unless the light is on the surface.
    within_bounds && (triangles.map(solid_angle).sum::<f64>() / (2.0 * TAU)).round() != 0.0
}

/// Solid angle of a triangle seen from the origin, in steradians; negative from in front. Van Oosterom and Strackee,
/// "The solid angle of a plane triangle", 1983.
fn solid_angle(&[a, b, c]: &[DVec3; 3]) -> f64 {
    let [la, lb, lc] = [a, b, c].map(DVec3::length);
    2.0 * a.cross(b).dot(c).atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::test_shapes::box_triangles;

    #[test]
    fn a_box_s_sides_are_solid_angles_of_a_sixth() {
        for triangle in box_triangles(DVec3::NEG_ONE, DVec3::ONE) {
            assert!((solid_angle(&triangle).abs() - TAU / 6.0).abs() < 1e-12);
        }
    }
}
