//! Errors of any method's map, by one rule.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::{DVec3, Quat, Vec3};
use rayon::prelude::*;

use super::Truth;
use super::bias::{Grid, Score};
use crate::compare::baselines::{Baseline, Bias, DeviceScene, Lookup, Method};
use crate::compare::error_figures::{
    FilterError, MapError, Receiver, ShadowError, distance_to_triangle, filter_error, map_error, per_million,
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
    /// Whether the light reaches those that count: of all, of the sample, and of those on fronts.
    expected: [Vec<Option<bool>>; 3],
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
        let all: Vec<Option<bool>> =
            truth.counts().iter().zip(&truth.lit).map(|(of, lit)| of.then_some(*lit)).collect();
        let sample = all.iter().copied().step_by(Asked::Sample.step(all.len())).collect();
        let on_front = |receiver: &Receiver| truth.reference.shows_front(receiver.triangle, DVec3::ZERO);
        let fronts = truth.receivers.par_iter().zip(&all).map(|(receiver, lit)| lit.filter(|_| on_front(receiver)));
        let fronts = fronts.collect();
        let (inputs, expected) = (truth.inputs(), [all, sample, fronts]);
        Self { gpu, light, truth, inputs, expected, evaluators: HashMap::new(), biases: HashMap::new() }
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
        let bias = self.fit(baseline, &[lookup], scene)?[0];
        Ok(self.ask(baseline, lookup, Asked::All, <[f32]>::to_vec).map(|values| Answers { values, bias }))
    }

    /// Records a method's map, and gives lookups that read it their best bias: those that [`Self::answers`] finds.
    ///
    /// # Errors
    /// [`Error::InvalidLight`].
    pub fn fit(
        &mut self,
        baseline: &mut Baseline,
        lookups: &[Lookup],
        scene: &mut DeviceScene,
    ) -> Result<Vec<Option<Bias>>, Error> {
        if baseline.method() == Method::Cube16 {
            baseline.set_nearest(self.nearest_surface());
        }
        self.record(baseline, scene, self.light.orientation)?;
        Ok(lookups.iter().map(|&lookup| self.find_bias(baseline, lookup)).collect())
    }

    /// Records a method's map in another orientation than the light's; the bias of its lookups stays as it is.
    ///
    /// # Errors
    /// [`Error::InvalidLight`].
    pub fn record(&self, baseline: &mut Baseline, scene: &mut DeviceScene, orientation: Quat) -> Result<(), Error> {
        let light = PointLight { orientation, ..self.light };
        let Gpu { device, queue, .. } = self.gpu;
        self.gpu.submit(|encoder| baseline.record(device, queue, encoder, scene, &light))
    }

    /// Wrong answers of a lookup in a map as it is, as [`Truth::wrong_ppm`] has them, and the same on fronts alone, without
    /// the backs of double-sided surfaces. `None` for a lookup that doesn't read the map.
    pub fn wrong_ppm(&mut self, baseline: &Baseline, lookup: Lookup) -> Option<[f64; 2]> {
        let expected = std::mem::take(&mut self.expected);
        let ppm = |lit: &[Option<bool>], values: &[f32]| {
            per_million(Score::new(values, lit).wrong, lit.par_iter().flatten().count())
        };
        let [all, _, fronts] = &expected;
        let wrong = self.ask(baseline, lookup, Asked::All, |values| [all, fronts].map(|lit| ppm(lit, values)));
        self.expected = expected;
        wrong
    }

    /// Does something with what a lookup answers in a map as it is.
    fn ask<R>(
        &mut self,
        baseline: &Baseline,
        lookup: Lookup,
        asked: Asked,
        use_answers: impl FnOnce(&[f32]) -> R,
    ) -> Option<R> {
        let evaluator = match self.evaluators.entry((lookup, asked)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                let inputs: Vec<(Vec3, Vec3)> =
                    self.inputs.iter().copied().step_by(asked.step(self.inputs.len())).collect();
                place.insert(baseline.evaluator(self.gpu, lookup, &inputs)?)
            }
        };
        baseline.with_answers(self.gpu, lookup, evaluator, use_answers)
    }

    /// How wrong a lookup is in a map as it is.
    fn score(&mut self, baseline: &Baseline, lookup: Lookup, asked: Asked) -> Option<Score> {
        let expected = std::mem::take(&mut self.expected);
        let of_asked = match asked {
            Asked::All => &expected[0],
            Asked::Sample => &expected[1],
        };
        let score = self.ask(baseline, lookup, asked, |values| Score::new(values, of_asked));
        self.expected = expected;
        score
    }

    /// How wrong a lookup is with a bias; the worst without any answer.
    fn score_of(&mut self, baseline: &mut Baseline, lookup: Lookup, bias: Bias, asked: Asked) -> Score {
        baseline.set_bias(&self.gpu.queue, lookup, bias);
        self.score(baseline, lookup, asked).unwrap_or(Score::WORST)
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
        let mut found = grid.search(|bias| self.score_of(baseline, lookup, bias, Asked::Sample));
        found.truncate(FINALISTS);
        found.extend(lookup.default_bias());
        let scored = found.into_iter().map(|bias| (bias, self.score_of(baseline, lookup, bias, Asked::All)));
        scored.min_by(|a, b| a.1.compare(&b.1)).map_or_else(Bias::default, |(bias, _)| bias)
    }

    /// Distance from the light to the nearest surface, in world units.
    fn nearest_surface(&self) -> f32 {
        let distances = self.truth.reference.triangles().par_iter().map(distance_to_triangle);
        // NaN, of triangles of no area, is passed over.
        distances.reduce(|| f64::from(self.light.range), f64::min) as f32
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
