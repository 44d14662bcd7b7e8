//! All methods at one resolution of one scene.

use std::time::{Duration, Instant};

use super::{Cost, LookupError, Stages};
use crate::compare::baselines::{Baseline, Budget, DeviceScene, Method};
use crate::compare::gpu::Gpu;
use crate::compare::measure::Judge;
use crate::compare::timing::{Rounds, Timer, Times};
use crate::{Error, Stage};

/// The fewest runs of a step that would take too long.
const FEWEST_RUNS: usize = 5;

/// What is measured at each resolution.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    /// Methods that the device can do.
    pub methods: Vec<Method>,
    /// How large cubes are.
    pub budgets: Vec<Budget>,
    /// How often each map is made for its time.
    pub runs: usize,
    /// How long that may take at one resolution, all methods together; then there are fewer runs, but at least five.
    pub most: Duration,
}

/// A scene with its light, ready to be measured.
pub struct Subject<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// Measures on that device.
    pub timer: &'a Timer<'a>,
    /// The casters.
    pub casters: DeviceScene,
    /// Judges maps of the light, by a truth under the same rule for sides as the casters'.
    pub judge: Judge<'a>,
}

/// A method at a size.
struct Contender {
    budget: Budget,
    side: u32,
    baseline: Baseline,
    errors: Vec<LookupError>,
}

impl Subject<'_> {
    /// Measures all methods against a pair of `pair` texels across each map, their times interleaved. Returns also
    /// what was left out, for what reason.
    ///
    /// # Errors
    /// [`Error::InvalidLight`].
    pub fn costs(&mut self, plan: &Plan, pair: u32) -> Result<(Vec<Cost>, Vec<String>), Error> {
        let (mut contenders, left_out) = self.contenders(plan, pair);
        for contender in &mut contenders {
            contender.errors = self.errors(&mut contender.baseline)?;
        }
        // Recordings that stop early come last.
        let whole = (0..contenders.len()).map(|index| (index, Stage::Rasterise));
        let mut ways: Vec<(usize, Stage)> = whole.collect();
        let own = contenders.iter().position(|contender| contender.baseline.method() == Method::Paraboloid);
        ways.extend(own.into_iter().flat_map(|index| [(index, Stage::Cull), (index, Stage::Resolve)]));
        let (times, runs) = self.times(plan, &mut contenders, &ways)?;
        let stages = own.map(|index| stages(&times[index], &times[contenders.len()..]));
        let costs = contenders.into_iter().zip(&times).map(|(contender, times)| {
            let stages = stages.filter(|_| contender.baseline.method() == Method::Paraboloid);
            contender.cost(pair, times, runs, stages)
        });
        Ok((costs.collect(), left_out))
    }

    fn contenders(&self, plan: &Plan, pair: u32) -> (Vec<Contender>, Vec<String>) {
        let (mut contenders, mut left_out) = (Vec::new(), Vec::new());
        for &method in &plan.methods {
            // A pair has as many texels as itself whatever is kept equal.
            let budgets = if method.is_cube() { &plan.budgets } else { &[Budget::EqualTexels][..] };
            for &budget in budgets {
                let side = method.side(pair, budget);
                match Baseline::new(&self.gpu.device, method, side) {
                    Ok(baseline) => contenders.push(Contender { budget, side, baseline, errors: Vec::new() }),
                    Err(error) => left_out.push(error.to_string()),
                }
            }
        }
        (contenders, left_out)
    }

    fn errors(&mut self, baseline: &mut Baseline) -> Result<Vec<LookupError>, Error> {
        let mut errors = Vec::new();
        for &lookup in baseline.method().lookups() {
            let answers = self.judge.answers(baseline, lookup, &mut self.casters)?;
            errors.extend(answers.map(|answers| {
                let wrong_ppm = self.judge.truth().wrong_ppm(&answers.values);
                LookupError { lookup, wrong_ppm, bias: answers.bias }
            }));
        }
        Ok(errors)
    }

    /// Times of all ways, and in how many runs.
    fn times(
        &mut self,
        plan: &Plan,
        contenders: &mut [Contender],
        ways: &[(usize, Stage)],
    ) -> Result<(Vec<Times>, usize), Error> {
        let (gpu, light, mut failed) = (self.gpu, *self.judge.light(), None);
        let mut record = |way: usize, encoder: &mut wgpu::CommandEncoder| {
            let (index, stage) = ways[way];
            let baseline = &mut contenders[index].baseline;
            baseline.stop_after(stage);
            let recorded = baseline.record(&gpu.device, &gpu.queue, encoder, &mut self.casters, &light);
            failed = failed.take().or(recorded.err());
        };
        // The first round makes pipelines and room; the second tells how long one takes.
        self.timer.interleaved(ways.len(), Rounds { warm_up: 0, measured: 1 }, &mut record);
        let started = Instant::now();
        self.timer.interleaved(ways.len(), Rounds { warm_up: 0, measured: 1 }, &mut record);
        let runs = affordable_runs(plan, started.elapsed());
        let times = self.timer.interleaved(ways.len(), Rounds { warm_up: 1, measured: runs }, &mut record);
        failed.map_or(Ok((times, runs)), Err)
    }
}

impl Contender {
    fn cost(self, pair: u32, times: &Times, runs: usize, stages: Option<Stages>) -> Cost {
        Cost {
            method: self.baseline.method(),
            budget: self.budget,
            pair,
            side: self.side,
            texels: self.baseline.texels(),
            bytes: self.baseline.memory(),
            gpu: times.gpu,
            cpu: times.cpu,
            runs,
            errors: self.errors,
            stages,
        }
    }
}

fn affordable_runs(plan: &Plan, round: Duration) -> usize {
    let affordable = plan.most.as_secs_f64() / round.as_secs_f64().max(1e-9);
    plan.runs.min((affordable as usize).max(FEWEST_RUNS))
}

/// What each stage adds, from the times of all stages and of those that stop after the first and the second.
fn stages(all: &Times, early: &[Times]) -> Stages {
    let [route, split, depth] = [&early[0], &early[1], all].map(|times| times.gpu.median);
    Stages { route, split: split.saturating_sub(route), depth: depth.saturating_sub(split) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_rounds_are_run_less_often() {
        let plan = Plan { methods: vec![], budgets: vec![], runs: 20, most: Duration::from_secs(4) };
        let runs = |milliseconds| affordable_runs(&plan, Duration::from_millis(milliseconds));
        assert_eq!([runs(0), runs(100), runs(400), runs(4000)], [20, 20, 10, 5]);
        let few = Plan { runs: 1, ..plan };
        assert_eq!(affordable_runs(&few, Duration::from_secs(9)), 1);
    }
}
