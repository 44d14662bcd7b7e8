//! Errors of any method's map, by one rule.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::Vec3;

use super::Truth;
use crate::compare::baselines::{Baseline, ConstantBias, DeviceScene, Lookup};
use crate::compare::error_figures::{FilterError, MapError, ShadowError, filter_error, map_error};
use crate::compare::gpu::{Evaluator, Gpu};
use crate::compare::ideal::{IdealMap, MapGeometry};
use crate::{Error, Filter, PointLight};

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
    /// Of the lookup's answers where its whole kernel is lit or dark; the paraboloid's alone.
    pub filter: Option<FilterError>,
    /// The ray-cast map and the errors of the lookup on it; the paraboloid's alone.
    pub ideal: Option<(IdealMap, ShadowError)>,
    /// The bias that was the best of [`BIASES`], in world units; the vertex warp's alone.
    pub bias: Option<f32>,
    /// The map as it was judged; the paraboloid's alone.
    pub stored: Vec<f32>,
}

/// What a lookup answered at a truth's receivers.
pub struct Answers {
    /// From 0 (dark) to 1 (lit), one a receiver.
    pub values: Vec<f32>,
    /// The bias that was the best of [`BIASES`], in world units; the vertex warp's alone.
    pub bias: Option<f32>,
}

/// Asks and judges lookups in the maps of one light of one scene.
pub struct Judge<'a> {
    gpu: &'a Gpu,
    light: PointLight,
    truth: &'a Truth,
    inputs: Vec<(Vec3, Vec3)>,
    /// Those that were needed so far: all maps that a lookup reads are bound alike.
    evaluators: HashMap<Lookup, Evaluator>,
}

impl<'a> Judge<'a> {
    /// For maps of the light that the truth is of.
    #[must_use]
    pub fn new(gpu: &'a Gpu, light: PointLight, truth: &'a Truth) -> Self {
        Self { gpu, light, truth, inputs: truth.inputs(), evaluators: HashMap::new() }
    }

    /// The device.
    #[must_use]
    pub fn gpu(&self) -> &'a Gpu {
        self.gpu
    }

    /// The light.
    #[must_use]
    pub fn light(&self) -> &PointLight {
        &self.light
    }

    /// The truth.
    #[must_use]
    pub fn truth(&self) -> &'a Truth {
        self.truth
    }

    /// Records a method's map and judges what the lookup answers, as [`Self::answers`] has it.
    ///
    /// # Errors
    /// [`Error::InvalidLight`].
    pub fn judge(
        &mut self,
        baseline: &mut Baseline,
        lookup: Lookup,
        scene: &mut DeviceScene,
    ) -> Result<Option<Judged>, Error> {
        let truth = self.truth;
        let Some(Answers { values, bias }) = self.answers(baseline, lookup, scene)? else { return Ok(None) };
        let Some(shadows) = baseline.shadows() else {
            let shadow = truth.judge(&values);
            return Ok(Some(Judged { map: None, shadow, filter: None, ideal: None, bias, stored: Vec::new() }));
        };
        let guard = f64::from(shadows.half_width()) - 1.0;
        let geometry = MapGeometry { resolution: shadows.maps().height(), guard };
        let (map, error) = truth.ideal(geometry, f64::from(shadows.depth_tolerance()));
        let stored: Vec<f32> = self.gpu.read_texture(baseline.map(), 0);
        let kernel = if lookup == Lookup::Filtered { self.light.filter } else { Filter::Bilinear };
        Ok(Some(Judged {
            map: Some(map_error(&stored, &map, &truth.reference, &truth.view)),
            shadow: truth.judge(&values),
            filter: Some(filter_error(truth, &values, &geometry, kernel)),
            ideal: Some((map, error)),
            bias,
            stored,
        }))
    }

    /// Records a method's map and asks the lookup. `None` for a lookup that doesn't read the map. The vertex warp gets
    /// the bias of [`BIASES`] with the fewest wrong answers, and keeps it; the cubes keep the bias they have.
    ///
    /// # Errors
    /// [`Error::InvalidLight`].
    pub fn answers(
        &mut self,
        baseline: &mut Baseline,
        lookup: Lookup,
        scene: &mut DeviceScene,
    ) -> Result<Option<Answers>, Error> {
        let bias = if lookup == Lookup::VertexWarp { self.find_bias(baseline, scene)? } else { None };
        Ok(self.ask(baseline, lookup, scene)?.map(|values| Answers { values, bias }))
    }

    /// Records the map as it is set, and asks the lookup.
    fn ask(
        &mut self,
        baseline: &mut Baseline,
        lookup: Lookup,
        scene: &mut DeviceScene,
    ) -> Result<Option<Vec<f32>>, Error> {
        let Gpu { device, queue, .. } = self.gpu;
        let mut recorded = Ok(());
        self.gpu.submit(|encoder| recorded = baseline.record(device, queue, encoder, scene, &self.light));
        recorded?;
        let evaluator = match self.evaluators.entry(lookup) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => match baseline.evaluator(self.gpu, lookup, &self.inputs) {
                Some(evaluator) => place.insert(evaluator),
                None => return Ok(None),
            },
        };
        Ok(baseline.answers(self.gpu, evaluator))
    }

    /// Tries all biases of the vertex warp, and sets and returns the best.
    fn find_bias(&mut self, baseline: &mut Baseline, scene: &mut DeviceScene) -> Result<Option<f32>, Error> {
        let distances = self.inputs.iter().map(|(position, _)| position.distance(self.light.position));
        let reach = distances.fold(0.0, f32::max);
        let mut best: Option<(f64, f32)> = None;
        for share in BIASES {
            let depth = share * reach;
            baseline.set_bias(ConstantBias { depth, normal: 0.0 });
            let Some(values) = self.ask(baseline, Lookup::VertexWarp, scene)? else { return Ok(None) };
            let wrong = self.truth.wrong_ppm(&values);
            if best.is_none_or(|(least, _)| wrong < least) {
                best = Some((wrong, depth));
            }
        }
        let bias = best.map(|(_, depth)| depth);
        baseline.set_bias(ConstantBias { depth: bias.unwrap_or_default(), normal: 0.0 });
        Ok(bias)
    }
}
