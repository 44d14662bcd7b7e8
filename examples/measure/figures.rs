//! All figures of all methods.

use crate::arguments::{Arguments, Entry};
use anyhow::{anyhow, bail};
use dual_paraboloid::compare::area_light::{SoftError, shares_of_sphere, soft_error};
use dual_paraboloid::compare::baselines::{Baseline, DeviceScene, Lookup};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::measure::{Judge, Judged};
use dual_paraboloid::compare::timing::{Rounds, Summary, Timer};
use dual_paraboloid::{Filter, PointLight, PointShadowsDescriptor};
use indicatif::ProgressBar;

/// Rounds that don't count, before the measured ones.
const WARM_UP: usize = 3;
/// Receivers at which the sphere of a soft light is ray-traced, and rays to it.
const SOFT_SAMPLES: usize = 20_000;
const SOFT_RAYS: usize = 256;

/// One method with its map and its figures.
pub struct Measured {
    pub entry: Entry,
    pub resolution: u32,
    pub baseline: Baseline,
    pub judged: Option<Judged>,
    /// Against a ray-traced sphere of light, where that is what the lookup means to show.
    pub soft: Option<SoftError>,
    pub time: Option<Summary>,
}

/// Maps of all methods, without figures yet.
pub fn prepare(gpu: &Gpu, arguments: &Arguments) -> anyhow::Result<Vec<Measured>> {
    arguments
        .methods
        .iter()
        .map(|&entry| {
            let name = entry.name();
            if let Some(reason) = entry.method.left_out(gpu) {
                bail!("{name} is left out: {reason}");
            }
            let resolution = entry.side(arguments);
            let tolerance = arguments.tolerance.unwrap_or(PointShadowsDescriptor::default().tolerance);
            let baseline = Baseline::with_tolerance(&gpu.device, entry.method, resolution, tolerance)?;
            Ok(Measured { entry, resolution, baseline, judged: None, soft: None, time: None })
        })
        .collect()
}

/// Judges each method's shadows. A step of the bar for each.
pub fn find_errors(
    judge: &mut Judge,
    measured: &mut [Measured],
    scene: &mut DeviceScene,
    bar: &ProgressBar,
) -> anyhow::Result<()> {
    for one in measured {
        bar.set_message(format!("errors of {}", one.entry.name()));
        if let Some(lookup) = one.entry.judged() {
            one.judged = judge.judge(&mut one.baseline, lookup, scene)?;
            one.soft = find_soft_error(judge, &one.baseline, lookup);
        }
        bar.inc(1);
    }
    Ok(())
}

/// Errors against the sphere, at the first [`SOFT_SAMPLES`] receivers.
fn find_soft_error(judge: &Judge, baseline: &Baseline, lookup: Lookup) -> Option<SoftError> {
    let (Filter::Soft { light_radius, .. }, Lookup::Filtered) = (judge.light().filter, lookup) else { return None };
    let truth = judge.truth();
    let receivers = &truth.receivers[..truth.receivers.len().min(SOFT_SAMPLES)];
    let values = baseline.shadow_values(judge.gpu(), lookup, &truth.inputs()[..receivers.len()])?;
    let radius = f64::from(light_radius);
    Some(soft_error(&values, &shares_of_sphere(receivers, &truth.reference, &truth.view, radius, SOFT_RAYS)))
}

/// Times all methods that have a time, interleaved. A step of the bar for each map made.
pub fn find_times(
    timer: &Timer,
    gpu: &Gpu,
    measured: &mut [Measured],
    scene: &mut DeviceScene,
    light: &PointLight,
    runs: usize,
    bar: &ProgressBar,
) -> anyhow::Result<()> {
    bar.set_message("times");
    let mut timed: Vec<&mut Measured> = measured.iter_mut().filter(|one| one.entry.is_timed()).collect();
    let mut failed = None;
    let rounds = Rounds { warm_up: WARM_UP, measured: runs };
    let times = timer.interleaved(timed.len(), rounds, |way, encoder| {
        let recorded = timed[way].baseline.record(&gpu.device, &gpu.queue, encoder, scene, light);
        failed = failed.take().or(recorded.err());
        bar.inc(1);
    });
    for (one, times) in timed.into_iter().zip(times) {
        one.time = Some(times.gpu);
    }
    failed.map_or(Ok(()), |error| Err(anyhow!(error)))
}

/// Steps of the bar that [`find_times`] takes.
pub fn time_steps(arguments: &Arguments) -> usize {
    arguments.methods.iter().filter(|entry| entry.is_timed()).count() * (WARM_UP + arguments.runs as usize)
}
