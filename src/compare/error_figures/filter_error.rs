//! What a filter makes of surfaces that have nothing to filter: acne, and light under contacts.

use rayon::prelude::*;
use serde::Serialize;

use super::shadow_error::{FAR_TEXELS, is_even_within};
use super::{Receiver, per_million};
use crate::Filter;
use crate::compare::area_light::shares_of_sphere;
use crate::compare::ideal::MapGeometry;
use crate::compare::measure::Truth;
use crate::paraboloid::double as paraboloid;

/// Answers from this on count as lit, and from 1 less this on as not dark.
pub const LIT: f32 = 0.99;

/// Rays to the sphere of a soft light.
const RAYS: usize = 256;

/// The sphere is taken this much larger, since the taps at a kernel's rim reach a texel farther.
const LARGER: f64 = 1.25;

/// Figures about answers where everything within the filter's kernel is lit, or dark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FilterError {
    /// Answers below [`LIT`] where all is lit, in parts per million of the receivers that count.
    pub acne_ppm: f64,
    /// Answers above 1 - [`LIT`] where all is dark, in parts per million of the receivers that count.
    pub underlight_ppm: f64,
}

/// Figures about `values`, what a lookup with this filter answered in a map of this geometry at the truth's receivers.
///
/// All within the kernel is lit, or dark, where no boundary and no neighbouring face of a crease is within its reach;
/// what filters make of creases is the [`CreaseError`](super::CreaseError). With [`Filter::Soft`] the receiver sees all of
/// a sphere a quarter larger, or nothing, and the reach is that of the four texels, and in the dark that of the penumbra
/// of what the ray from the light's middle meets first. Only receivers that count are judged.
///
/// # Panics
/// When there are not as many values as receivers.
#[must_use]
pub fn filter_error(truth: &Truth, values: &[f32], geometry: &MapGeometry, filter: Filter) -> FilterError {
    assert_eq!(values.len(), truth.receivers.len(), "the lists differ in length");
    let light = truth.view.position;
    let judged = truth.receivers.par_iter().zip(&truth.lit).zip(values);
    let judged = judged.filter(|((receiver, _), _)| receiver.counts(light));
    let samples = judged.clone().count();
    let wrong = judged.filter(|&((receiver, lit), value)| {
        let suspect = if *lit { *value < LIT } else { *value > 1.0 - LIT };
        suspect && is_even(truth, receiver, *lit, geometry, filter)
    });
    let wrong: Vec<bool> = wrong.map(|((_, lit), _)| *lit).collect();
    let acne = wrong.iter().filter(|lit| **lit).count();
    FilterError { acne_ppm: per_million(acne, samples), underlight_ppm: per_million(wrong.len() - acne, samples) }
}

/// Whether everything within the kernel is as lit, or as dark, as the receiver.
fn is_even(truth: &Truth, receiver: &Receiver, lit: bool, geometry: &MapGeometry, filter: Filter) -> bool {
    let Truth { view, reference, .. } = truth;
    let reach = reach(truth, receiver, geometry, filter);
    if !is_even_within(reach, receiver, lit, reference, view, geometry) {
        return false;
    }
    let Filter::Soft { light_radius, .. } = filter else { return true };
    let seen = shares_of_sphere(&[*receiver], reference, view, LARGER * f64::from(light_radius), RAYS);
    seen == [if lit { 1.0 } else { 0.0 }]
}

/// How far from the receiver the farthest texel may be that has a say, in texels.
fn reach(truth: &Truth, receiver: &Receiver, geometry: &MapGeometry, filter: Filter) -> f64 {
    let relative = receiver.relative(truth.view.position);
    let disc = |radius: f64| {
        let (x, _) = truth.view.to_hemisphere(relative);
        let rim = (0.5 * (x.normalize().z.acos() + radius)).tan() - paraboloid::project(x).length();
        FAR_TEXELS + rim / geometry.texel()
    };
    match filter {
        Filter::Hard | Filter::Sharp => FAR_TEXELS,
        Filter::Pcf3 => 2.0 * FAR_TEXELS,
        Filter::Pcf5 => 3.0 * FAR_TEXELS,
        Filter::Disc { radius, .. } => disc(radius.into()),
        Filter::Soft { light_radius, .. } => {
            let distance = relative.length();
            let hit = truth.reference.nearest(relative / distance, truth.view.near);
            let gap = hit.map_or(0.0, |hit| (1.0 / hit.t - 1.0 / distance).max(0.0));
            disc((f64::from(light_radius) * gap).min(Filter::WIDEST.into()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PointLight;
    use crate::compare::measure::light_for;
    use crate::compare::procedural::shapes::quad;
    use crate::compare::scene::{Scene, SceneInstance};
    use glam::{Affine3A, Vec3};

    /// A wall and a sheet before half of it.
    fn truth() -> Truth {
        let wall = quad(Vec3::new(-3.0, -3.0, 3.0), Vec3::Y * 6.0, Vec3::X * 6.0);
        let sheet = quad(Vec3::new(0.0, -3.0, 1.5), Vec3::Y * 6.0, Vec3::X * 3.0);
        let instances = (0..2).map(|mesh| SceneInstance { mesh, transform: Affine3A::IDENTITY }).collect();
        let scene = Scene { meshes: vec![wall, sheet], instances, ..Scene::default() };
        let light: PointLight = light_for(&scene, Vec3::ZERO);
        Truth::new(&scene, &light, 4000, 1)
    }

    /// Answers that are all wrong count but for those whose kernel meets the edge: the fewer the wider it is.
    #[test]
    fn kernels_that_meet_an_edge_are_spared() {
        let truth = truth();
        let geometry = MapGeometry { resolution: 512, guard: 0.02 };
        let wrong: Vec<f32> = truth.lit.iter().map(|lit| if *lit { 0.0 } else { 1.0 }).collect();
        let disc = |radius| Filter::Disc { radius, taps: 1 };
        let filters = [Filter::Sharp, Filter::Pcf5, disc(0.05), Filter::soft(0.3), disc(0.3)];
        let errors = filters.map(|filter| filter_error(&truth, &wrong, &geometry, filter));
        for (error, wider) in errors.iter().zip(&errors[1..]) {
            assert!(error.acne_ppm > wider.acne_ppm && error.underlight_ppm >= wider.underlight_ppm, "{errors:?}");
        }
        assert!(errors[0].acne_ppm + errors[0].underlight_ppm > 950_000.0, "{errors:?}");
        let right: Vec<f32> = truth.lit.iter().map(|lit| if *lit { LIT } else { 1.0 - LIT }).collect();
        assert_eq!(filter_error(&truth, &right, &geometry, Filter::Sharp), FilterError::default());
    }
}
