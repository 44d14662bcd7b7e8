//! Errors of any method's map, by one rule.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::{Quat, Vec3};

use super::Truth;
use super::bias::{Grid, Score};
use crate::compare::baselines::{Baseline, Bias, DeviceScene, Lookup, Method};
use crate::compare::error_figures::{
    FilterError, MapError, ShadowError, distance_to_triangle, filter_error, map_error,
};
use crate::compare::gpu::{Evaluator, Gpu};
use crate::compare::ideal::{IdealMap, MapGeometry};
use crate::{Error, Filter, PointLight};

/// Receivers by which a bias is searched for, at most: every n-th of all.
const SAMPLE: usize = 100_000;

/// The best of the search, among which and the default all receivers decide.
const FINALISTS: usize = 8;

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
    /// The bias that was found best; `None` of lookups whose bias is fixed.
    pub bias: Option<Bias>,
    /// The map as it was judged; the paraboloid's alone.
    pub stored: Vec<f32>,
}

/// What a lookup answered at a truth's receivers.
pub struct Answers {
    /// From 0 (dark) to 1 (lit), one a receiver.
    pub values: Vec<f32>,
    /// The bias that was found best; `None` of lookups whose bias is fixed.
    pub bias: Option<Bias>,
}

/// Asks and judges lookups in the maps of one light of one scene.
pub struct Judge<'a> {
    gpu: &'a Gpu,
    light: PointLight,
    truth: &'a Truth,
    inputs: Vec<(Vec3, Vec3)>,
    /// Those that were needed so far: all maps that a lookup reads are bound alike.
    evaluators: HashMap<(Lookup, Asked), Evaluator>,
    /// Those that were found so far, by the method whose map is the same and the map's width.
    biases: HashMap<(Method, u32, Lookup), Bias>,
}

/// Which receivers are asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Asked {
    All,
    /// Every n-th, [`SAMPLE`] or a little more.
    Sample,
}

impl<'a> Judge<'a> {
    /// For maps of the light that the truth is of.
    #[must_use]
    pub fn new(gpu: &'a Gpu, light: PointLight, truth: &'a Truth) -> Self {
        Self { gpu, light, truth, inputs: truth.inputs(), evaluators: HashMap::new(), biases: HashMap::new() }
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
        let (map, error) = truth.ideal(geometry);
        let stored: Vec<f32> = self.gpu.read_texture(baseline.map(), 0);
        let kernel = if lookup == Lookup::Filtered { self.light.filter } else { Filter::Sharp };
        Ok(Some(Judged {
            map: Some(map_error(&stored, &map, &truth.reference, &truth.view)),
            shadow: truth.judge(&values),
            filter: Some(filter_error(truth, &values, &geometry, kernel)),
            ideal: Some((map, error)),
            bias,
            stored,
        }))
    }

    /// Records a method's map and asks the lookup. `None` for a lookup that doesn't read the map. A lookup whose bias may
    /// be chosen gets the one with the fewest wrong answers in this map, and keeps it. A 16-bit cube gets the nearest
    /// surface's distance, and keeps that.
    ///
    /// # Errors
    /// [`Error::InvalidLight`].
    pub fn answers(
        &mut self,
        baseline: &mut Baseline,
        lookup: Lookup,
        scene: &mut DeviceScene,
    ) -> Result<Option<Answers>, Error> {
        if !baseline.method().is_read_by(lookup) {
            return Ok(None);
        }
        if baseline.method() == Method::Cube16 {
            baseline.set_nearest(self.nearest_surface());
        }
        self.record(baseline, scene)?;
        let bias = self.find_bias(baseline, lookup);
        Ok(self.ask(baseline, lookup, Asked::All).map(|values| Answers { values, bias }))
    }

    /// [`Self::answers`] with the maps turned to another orientation, with the bias that the
    /// baseline has since. `None` for a lookup that doesn't read the map.
    ///
    /// # Errors
    /// [`Error::InvalidLight`].
    pub fn answers_turned(
        &mut self,
        baseline: &mut Baseline,
        lookup: Lookup,
        scene: &mut DeviceScene,
        orientation: Quat,
    ) -> Result<Option<Vec<f32>>, Error> {
        if !baseline.method().is_read_by(lookup) {
            return Ok(None);
        }
        let turned = PointLight { orientation, ..self.light };
        let Gpu { device, queue, .. } = self.gpu;
        self.gpu.submit(|encoder| baseline.record(device, queue, encoder, scene, &turned))?;
        Ok(self.ask(baseline, lookup, Asked::All))
    }

    fn record(&self, baseline: &mut Baseline, scene: &mut DeviceScene) -> Result<(), Error> {
        let Gpu { device, queue, .. } = self.gpu;
        self.gpu.submit(|encoder| baseline.record(device, queue, encoder, scene, &self.light))
    }

    /// What a lookup answers in a map as it is.
    fn ask(&mut self, baseline: &Baseline, lookup: Lookup, asked: Asked) -> Option<Vec<f32>> {
        let evaluator = match self.evaluators.entry((lookup, asked)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                let inputs: Vec<(Vec3, Vec3)> =
                    self.inputs.iter().copied().step_by(asked.step(self.inputs.len())).collect();
                place.insert(baseline.evaluator(self.gpu, lookup, &inputs)?)
            }
        };
        baseline.answers(self.gpu, evaluator)
    }

    /// How wrong a lookup is with a bias.
    fn score(&mut self, baseline: &mut Baseline, lookup: Lookup, bias: Bias, asked: Asked) -> Option<Score> {
        baseline.set_bias(&self.gpu.queue, lookup, bias);
        let values = self.ask(baseline, lookup, asked)?;
        let truth = self.truth;
        let asked = truth.counts().iter().zip(&truth.lit).step_by(asked.step(self.inputs.len()));
        let counted = asked.zip(values).filter(|((counts, _), _)| **counts);
        let (values, lit): (Vec<f32>, Vec<bool>) = counted.map(|((_, lit), value)| (value, *lit)).unzip();
        Some(Score::new(&values, lit.into_iter()))
    }

    /// Sets and returns the best bias of a lookup in a recorded map; `None` for lookups whose bias is fixed.
    fn find_bias(&mut self, baseline: &mut Baseline, lookup: Lookup) -> Option<Bias> {
        let reach = self.inputs.iter().map(|(at, _)| at.distance(self.light.position)).fold(0.0, f32::max);
        let grid = Grid::new(lookup, reach)?;
        let map = (baseline.method().same_map(), baseline.map().width(), lookup);
        let bias = match self.biases.get(&map) {
            Some(known) => *known,
            None => self.search(baseline, lookup, &grid),
        };
        self.biases.insert(map, bias);
        baseline.set_bias(&self.gpu.queue, lookup, bias);
        Some(bias)
    }

    fn search(&mut self, baseline: &mut Baseline, lookup: Lookup, grid: &Grid) -> Bias {
        let worst = Score::WORST;
        let mut found = grid.search(|bias| self.score(baseline, lookup, bias, Asked::Sample).unwrap_or(worst));
        found.truncate(FINALISTS);
        found.extend(lookup.default_bias());
        let scored =
            found.into_iter().map(|bias| (bias, self.score(baseline, lookup, bias, Asked::All).unwrap_or(worst)));
        scored.min_by(|a, b| a.1.compare(&b.1)).map_or_else(Bias::default, |(bias, _)| bias)
    }

    /// Distance from the light to the nearest surface, in world units.
    fn nearest_surface(&self) -> f32 {
        let distances = self.truth.reference.triangles().iter().map(distance_to_triangle);
        // NaN, of triangles of no area, is passed over.
        distances.fold(f64::from(self.light.range), f64::min) as f32
    }
}

impl Asked {
    /// How far apart the receivers are that are asked, of so many.
    fn step(self, receivers: usize) -> usize {
        match self {
            Self::All => 1,
            Self::Sample => (receivers / SAMPLE).max(1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_spread_over_all_receivers() {
        assert_eq!([5, 100_000, 199_999, 1_000_000].map(|all| Asked::Sample.step(all)), [1, 1, 1, 10]);
        assert_eq!(Asked::All.step(1_000_000), 1);
    }
}
