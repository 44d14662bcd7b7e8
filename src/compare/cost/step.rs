//! All methods at one resolution of one scene.

use std::time::{Duration, Instant};

use glam::Quat;

use super::{Bytes, Cost, LookupCost, ScreenTime, Stages, TurnedErrors, turned_errors};
use crate::compare::baselines::{Baseline, Budget, DeviceScene, Lookup, Method};
use crate::compare::gpu::Gpu;
use crate::compare::lookup_cost::{PassStage, Question, Screens};
use crate::compare::measure::Judge;
use crate::compare::timing::{Rounds, Summary, Timer, Times};
use crate::{Error, PointLight, Stage};

/// The fewest runs of a step that would take too long.
const FEWEST_RUNS: usize = 5;

/// What is measured at each resolution.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    /// Methods that the device can do.
    pub methods: Vec<Method>,
    /// Resolution of the pair at which there are cubes of equal side too; at all others their texels are equal.
    pub main: u32,
    /// How often each map is made, and each pass drawn, for its time.
    pub runs: usize,
    /// How long that may take at one resolution, all methods together; then there are fewer runs, but at least five.
    pub most: Duration,
}

/// A scene with its light, ready to be measured.
pub struct Subject<'a, 'gpu> {
    /// The device.
    pub gpu: &'gpu Gpu,
    /// Measures on that device.
    pub timer: &'a Timer<'a>,
    /// The casters.
    pub casters: DeviceScene,
    /// The light, by whose own orientation times are taken: along the world's axes, as engines have their cubes.
    pub light: PointLight,
    /// Those in which maps are made for their errors, beginning with the judge's.
    pub orientations: Vec<Quat>,
    /// Judges maps of the light in the first orientation, by a truth under the same rule for sides as the casters'.
    pub judge: Judge<'a>,
    /// What a camera sees, for the time of lookups.
    pub screens: &'a mut Screens<'gpu>,
}

/// A method at a size.
struct Contender {
    budget: Budget,
    side: u32,
    baseline: Baseline,
    lookups: Vec<LookupCost>,
}

/// A pass that is timed.
#[derive(Clone, Copy)]
struct Pass {
    contender: usize,
    lookup: usize,
    screen: usize,
    stage: PassStage,
}

impl Subject<'_, '_> {
    /// Measures all methods against a pair of `pair` texels across each map, their times interleaved. Returns also
    /// what was left out, for what reason.
    ///
    /// Methods whose maps are [the same](Method::same_map) share the errors and the times of lookups, which are
    /// measured in the first one's.
    ///
    /// # Errors
    /// [`Error::InvalidLight`].
    pub fn costs(&mut self, plan: &Plan, pair: u32) -> Result<(Vec<Cost>, Vec<String>), Error> {
        let (mut contenders, left_out) = self.contenders(plan, pair);
        let firsts = firsts(&contenders);
        for (index, contender) in contenders.iter_mut().enumerate() {
            if firsts[index] == index {
                contender.lookups = self.lookups(&mut contender.baseline)?;
            }
        }
        // Recordings that stop early come last.
        let whole = (0..contenders.len()).map(|index| (index, Stage::Rasterise));
        let mut ways: Vec<(usize, Stage)> = whole.collect();
        let own = contenders.iter().position(|contender| contender.baseline.method() == Method::Paraboloid);
        ways.extend(own.into_iter().flat_map(|index| EARLY.map(|stage| (index, stage))));
        let (times, runs) = self.map_times(plan, &mut contenders, &ways)?;
        let stages = own.map(|index| stages(&times[index], &times[contenders.len()..]));
        self.time_passes(plan, &mut contenders)?;
        let lookups: Vec<Vec<LookupCost>> = contenders.iter().map(|contender| contender.lookups.clone()).collect();
        let costs = contenders.into_iter().enumerate().map(|(index, contender)| {
            let method = contender.baseline.method();
            let read = |of: &&LookupCost| method.lookups().contains(&of.lookup);
            Cost {
                method,
                budget: contender.budget,
                pair,
                side: contender.side,
                texels: contender.baseline.texels(),
                bytes: Bytes::of(&contender.baseline, &self.casters),
                gpu: times[index].gpu,
                cpu: times[index].cpu,
                runs,
                lookups: lookups[firsts[index]].iter().filter(read).cloned().collect(),
                stages: stages.filter(|_| method == Method::Paraboloid),
            }
        });
        Ok((costs.collect(), left_out))
    }

    fn contenders(&self, plan: &Plan, pair: u32) -> (Vec<Contender>, Vec<String>) {
        let (mut contenders, mut left_out) = (Vec::new(), Vec::new());
        for &method in &plan.methods {
            // A pair has as many texels as itself whatever is kept equal.
            let both = method.is_cube() && pair == plan.main;
            let budgets = if both { &[Budget::EqualTexels, Budget::EqualSide][..] } else { &[Budget::EqualTexels] };
            for &budget in budgets {
                let side = method.side(pair, budget);
                match Baseline::new(&self.gpu.device, method, side) {
                    Ok(baseline) => contenders.push(Contender { budget, side, baseline, lookups: Vec::new() }),
                    Err(error) => left_out.push(error.to_string()),
                }
            }
        }
        (contenders, left_out)
    }

    /// Errors of all lookups in one method's map, over all orientations.
    fn lookups(&mut self, baseline: &mut Baseline) -> Result<Vec<LookupCost>, Error> {
        let all = turned_errors(&mut self.judge, baseline, &mut self.casters, &self.orientations)?;
        let samples = self.judge.truth().counted();
        let cost = |(lookup, errors): (Lookup, TurnedErrors)| LookupCost {
            lookup,
            wrong_ppm: errors.mean(),
            wrong_front_ppm: errors.front_mean(),
            wrong_ppm_by_orientation: errors.wrong_ppm,
            samples,
            bias: errors.bias,
            screens: Vec::new(),
        };
        Ok(all.into_iter().map(cost).collect())
    }

    /// Times of all ways to make maps, and in how many runs.
    fn map_times(
        &mut self,
        plan: &Plan,
        contenders: &mut [Contender],
        ways: &[(usize, Stage)],
    ) -> Result<(Vec<Times>, usize), Error> {
        let (gpu, light, casters, mut failed) = (self.gpu, self.light, &mut self.casters, None);
        let times = timed(self.timer, plan, ways.len(), |way, encoder| {
            let (index, stage) = ways[way];
            let baseline = &mut contenders[index].baseline;
            baseline.stop_after(gpu, stage);
            let recorded = baseline.record(&gpu.device, &gpu.queue, encoder, casters, &light);
            failed = failed.take().or(recorded.err());
        });
        failed.map_or(Ok(times), Err)
    }

    /// Times all lookups that have errors, over all screens.
    fn time_passes(&mut self, plan: &Plan, contenders: &mut [Contender]) -> Result<(), Error> {
        let (gpu, light, casters) = (self.gpu, self.light, &mut self.casters);
        for contender in contenders.iter_mut() {
            // The recordings that were timed last may have stopped early.
            contender.baseline.stop_after(gpu, Stage::Rasterise);
            let baseline = &mut contender.baseline;
            gpu.submit(|encoder| baseline.record(&gpu.device, &gpu.queue, encoder, casters, &light))?;
        }
        let sizes = self.screens.sizes();
        let mut passes = Vec::new();
        for (index, contender) in contenders.iter().enumerate() {
            for (number, of) in contender.lookups.iter().enumerate() {
                for stage in PassStage::ALL {
                    self.screens.prepare(Question::Lookup(of.lookup), stage, &contender.baseline);
                    let pass = |screen| Pass { contender: index, lookup: number, screen, stage };
                    passes.extend((0..sizes.len()).map(pass));
                }
            }
        }
        let (screens, read) = (&*self.screens, &*contenders);
        let (times, _) = timed(self.timer, plan, passes.len(), |way, encoder| {
            let Pass { contender, lookup, screen, stage } = passes[way];
            let Contender { baseline, lookups, .. } = &read[contender];
            screens.record(encoder, screen, Question::Lookup(lookups[lookup].lookup), stage, baseline);
        });
        for (pass, times) in passes.iter().zip(times) {
            let screens = &mut contenders[pass.contender].lookups[pass.lookup].screens;
            if screens.is_empty() {
                *screens = sizes.iter().map(|size| ScreenTime::unknown(*size)).collect();
            }
            *screens[pass.screen].of_mut(pass.stage) = times.gpu;
        }
        Ok(())
    }
}

/// For each contender the first whose map is the same.
fn firsts(contenders: &[Contender]) -> Vec<usize> {
    let map = |contender: &Contender| (contender.baseline.method().same_map(), contender.side);
    let first = |of: &Contender| contenders.iter().position(|other| map(other) == map(of)).unwrap_or(0);
    contenders.iter().map(first).collect()
}

/// Times of all ways, and in how many runs: as many as the plan has time for.
fn timed(
    timer: &Timer,
    plan: &Plan,
    ways: usize,
    mut record: impl FnMut(usize, &mut wgpu::CommandEncoder),
) -> (Vec<Times>, usize) {
    // The first round makes pipelines and room; the second tells how long one takes.
    timer.interleaved(ways, Rounds { warm_up: 0, measured: 1 }, &mut record);
    let started = Instant::now();
    timer.interleaved(ways, Rounds { warm_up: 0, measured: 1 }, &mut record);
    let runs = affordable_runs(plan, started.elapsed());
    (timer.interleaved(ways, Rounds { warm_up: 1, measured: runs }, &mut record), runs)
}

/// As many runs as take half of the plan's time: maps and passes have as much of it.
fn affordable_runs(plan: &Plan, round: Duration) -> usize {
    let affordable = 0.5 * plan.most.as_secs_f64() / round.as_secs_f64().max(1e-9);
    plan.runs.min((affordable as usize).max(FEWEST_RUNS))
}

/// The stages after which recordings stop early.
const EARLY: [Stage; 3] = [Stage::Cull, Stage::Number, Stage::Bin];

/// What each stage adds, from the times of all stages and of those that stop early.
fn stages(all: &Times, early: &[Times]) -> Stages {
    let [cull, number, bin, rasterise] = [&early[0], &early[1], &early[2], all].map(|times| times.gpu.median);
    Stages {
        cull,
        number: number.saturating_sub(cull),
        bin: bin.saturating_sub(number),
        rasterise: rasterise.saturating_sub(bin),
    }
}

impl ScreenTime {
    /// A screen of which no pass was timed.
    fn unknown((width, height): (u32, u32)) -> Self {
        Self { width, height, compute: Summary::default(), fragment: Summary::default() }
    }

    fn of_mut(&mut self, stage: PassStage) -> &mut Summary {
        match stage {
            PassStage::Compute => &mut self.compute,
            PassStage::Fragment => &mut self.fragment,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_rounds_are_run_less_often() {
        let plan = Plan { methods: vec![], main: 1024, runs: 20, most: Duration::from_secs(8) };
        let runs = |milliseconds| affordable_runs(&plan, Duration::from_millis(milliseconds));
        assert_eq!([runs(0), runs(100), runs(400), runs(4000)], [20, 20, 10, 5]);
        let few = Plan { runs: 1, ..plan };
        assert_eq!(affordable_runs(&few, Duration::from_secs(9)), 1);
    }
}
