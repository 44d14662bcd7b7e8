//! Errors of any method's map, by one rule.

use glam::Vec3;

use super::Truth;
use crate::compare::baselines::{Baseline, ConstantBias, DeviceScene, Lookup};
use crate::compare::error_figures::{MapError, ShadowError, map_error};
use crate::compare::gpu::Gpu;
use crate::compare::ideal::{IdealMap, MapGeometry};
use crate::{Error, PointLight};

/// The constant biases that are tried for [`Lookup::VertexWarp`], in distances of the farthest receiver from the light:
/// four to a decade.
pub const BIASES: [f32; 17] = [
    1.0e-5, 1.78e-5, 3.16e-5, 5.62e-5, 1.0e-4, 1.78e-4, 3.16e-4, 5.62e-4, 1.0e-3, 1.78e-3, 3.16e-3, 5.62e-3, 1.0e-2,
    1.78e-2, 3.16e-2, 5.62e-2, 1.0e-1,
];

/// What a method's errors are.
pub struct Judged {
    /// Of the map's texels; the paraboloid's alone.
    pub map: Option<MapError>,
    /// Of the lookup's answers.
    pub shadow: ShadowError,
    /// The ray-cast map and the errors of the lookup on it; the paraboloid's alone.
    pub ideal: Option<(IdealMap, ShadowError)>,
    /// The bias that was the best of [`BIASES`], in world units; the vertex warp's alone.
    pub bias: Option<f32>,
    /// The map as it was judged; the paraboloid's alone.
    pub stored: Vec<f32>,
}

/// Records a method's map and judges what the lookup answers, as [`answers`] has it. Wrong answers of a cube are far
/// from a boundary by the texels of the pair with as many texels ([`pair_of_equal_texels`]).
///
/// # Errors
/// [`Error::InvalidLight`].
pub fn judge(
    gpu: &Gpu,
    baseline: &mut Baseline,
    lookup: Lookup,
    scene: &mut DeviceScene,
    light: &PointLight,
    truth: &Truth,
) -> Result<Option<Judged>, Error> {
    let Some(Answers { values, bias }) = answers(gpu, baseline, lookup, scene, light, truth)? else { return Ok(None) };
    let Some(shadows) = baseline.shadows() else {
        let shadow = truth.judge(&values, &pair_of_equal_texels(baseline.texels()));
        return Ok(Some(Judged { map: None, shadow, ideal: None, bias, stored: Vec::new() }));
    };
    let guard = f64::from(shadows.half_width()) - 1.0;
    let geometry = MapGeometry { resolution: shadows.maps().height(), guard };
    let (map, error) = truth.ideal(geometry, f64::from(shadows.tolerance()));
    let stored: Vec<f32> = gpu.read_texture(baseline.map(), 0);
    Ok(Some(Judged {
        map: Some(map_error(&stored, &map, &truth.reference, &truth.view)),
        shadow: truth.judge(&values, &geometry),
        ideal: Some((map, error)),
        bias,
        stored,
    }))
}

/// The pair without guard bands that has about as many texels: itself for a pair, `sqrt(3) C` across for a cube of C.
#[must_use]
pub fn pair_of_equal_texels(texels: u64) -> MapGeometry {
    MapGeometry { resolution: ((texels as f64 / 2.0).sqrt().round() as u32).max(1), guard: 0.0 }
}

/// What a lookup answered at a truth's receivers.
pub struct Answers {
    /// From 0 (dark) to 1 (lit), one a receiver.
    pub values: Vec<f32>,
    /// The bias that was the best of [`BIASES`], in world units; the vertex warp's alone.
    pub bias: Option<f32>,
}

/// Records a method's map and asks the lookup. `None` for a lookup that doesn't read the map. The vertex warp gets
/// the bias of [`BIASES`] with the fewest wrong answers, and keeps it; the cubes keep the bias they have.
///
/// # Errors
/// [`Error::InvalidLight`].
pub fn answers(
    gpu: &Gpu,
    baseline: &mut Baseline,
    lookup: Lookup,
    scene: &mut DeviceScene,
    light: &PointLight,
    truth: &Truth,
) -> Result<Option<Answers>, Error> {
    let mut trial = Trial { gpu, baseline, lookup, scene, light, truth, inputs: truth.inputs() };
    let bias = if lookup == Lookup::VertexWarp { trial.find_bias()? } else { None };
    Ok(trial.answers()?.map(|values| Answers { values, bias }))
}

struct Trial<'a> {
    gpu: &'a Gpu,
    baseline: &'a mut Baseline,
    lookup: Lookup,
    scene: &'a mut DeviceScene,
    light: &'a PointLight,
    truth: &'a Truth,
    inputs: Vec<(Vec3, Vec3)>,
}

impl Trial<'_> {
    /// Records the map and asks the lookup.
    fn answers(&mut self) -> Result<Option<Vec<f32>>, Error> {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let mut recorded = Ok(());
        self.gpu.submit(|encoder| {
            recorded = self.baseline.record(device, queue, encoder, self.scene, self.light);
        });
        recorded?;
        Ok(self.baseline.shadow_values(self.gpu, self.lookup, &self.inputs))
    }

    /// Tries all biases, and sets and returns the best.
    fn find_bias(&mut self) -> Result<Option<f32>, Error> {
        let distances = self.inputs.iter().map(|(position, _)| position.distance(self.light.position));
        let reach = distances.fold(0.0, f32::max);
        let mut best: Option<(f64, f32)> = None;
        for share in BIASES {
            let depth = share * reach;
            self.baseline.set_bias(ConstantBias { depth, normal: 0.0 });
            let Some(values) = self.answers()? else { return Ok(None) };
            let wrong = self.truth.wrong_ppm(&values);
            if best.is_none_or(|(least, _)| wrong < least) {
                best = Some((wrong, depth));
            }
        }
        let bias = best.map(|(_, depth)| depth);
        self.baseline.set_bias(ConstantBias { depth: bias.unwrap_or_default(), normal: 0.0 });
        Ok(bias)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_texels() {
        assert_eq!(pair_of_equal_texels(2 * 512 * 512).resolution, 512);
        assert_eq!(pair_of_equal_texels(6 * 296 * 296).resolution, 513);
        assert_eq!(pair_of_equal_texels(0).resolution, 1);
    }
}
