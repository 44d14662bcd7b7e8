//! All figures of all methods.

use crate::arguments::{Arguments, Entry, Rule};
use anyhow::{anyhow, bail};
use dual_paraboloid::compare::area_light::{SoftError, shares_of_sphere, soft_error};
use dual_paraboloid::compare::baselines::{Baseline, DeviceScene, Lookup};
use dual_paraboloid::compare::error_figures::{CreaseError, Receiver, ShadowError};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::measure::{Judge, Judged, PixelErrors, Pixels};
use dual_paraboloid::compare::timing::{Rounds, Summary, Timer};
use dual_paraboloid::compare::walk::{IdealWalks, STEPS};
use dual_paraboloid::{Filter, PointLight};
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
    /// What the rule says of the ray-cast map; the paraboloid's alone.
    pub ideal: Option<ShadowError>,
    /// In lit creases, if the scene has any.
    pub crease: Option<CreaseError>,
    /// At the camera's pixels, if any shows a lit side.
    pub pixels: Option<PixelErrors>,
    /// Beside the frozen yardstick; the paraboloid's alone.
    pub votes: Option<Votes>,
    /// Against a ray-traced sphere of light, where that is what the lookup means to show.
    pub soft: Option<SoftError>,
    pub time: Option<Summary>,
}

/// What [`VotesV1`](dual_paraboloid::compare::votes_v1::VotesV1) decides on the ray-cast map.
#[derive(Clone, Copy)]
pub struct Votes {
    /// Its wrong decisions.
    pub wrong_ppm: f64,
    /// Where it and the method decide differently.
    pub disagree_ppm: f64,
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
            let baseline = Baseline::new(&gpu.device, entry.method, resolution)?;
            Ok(Measured {
                entry,
                resolution,
                baseline,
                judged: None,
                ideal: None,
                crease: None,
                pixels: None,
                votes: None,
                soft: None,
                time: None,
            })
        })
        .collect()
}

/// Judges each method's shadows. A step of the bar for each.
pub fn find_errors(
    judge: &mut Judge,
    rule: Rule,
    walks: &IdealWalks,
    pixels: &Pixels,
    measured: &mut [Measured],
    scene: &mut DeviceScene,
    bar: &ProgressBar,
) -> anyhow::Result<()> {
    for one in measured {
        bar.set_message(format!("errors of {}", one.entry.name()));
        if let Some(lookup) = one.entry.judged(rule) {
            one.judged = judge.judge(&mut one.baseline, lookup, scene)?;
            find_more(judge, pixels, one, lookup);
            let ideal = one.judged.as_ref().and_then(|judged| judged.ideal.as_ref());
            one.ideal = ideal.map(|(map, votes)| match rule {
                Rule::Votes => *votes,
                Rule::Exact => judge.truth().judge(&walks.shadows(judge.truth(), map, STEPS)),
            });
        }
        bar.inc(1);
    }
    Ok(())
}

/// The errors in creases, at pixels and beside the yardstick, with the map and the bias that were judged.
fn find_more(judge: &Judge, pixels: &Pixels, one: &mut Measured, lookup: Lookup) {
    let (gpu, truth) = (judge.gpu(), judge.truth());
    if let Some(values) = one.baseline.shadow_values(gpu, lookup, &truth.inputs()) {
        one.crease = truth.crease_error(&values);
        one.votes = one.judged.as_ref().and_then(|judged| judged.ideal.as_ref()).map(|(map, _)| {
            let votes = truth.votes_v1(map);
            Votes { wrong_ppm: truth.wrong_ppm(&votes), disagree_ppm: truth.disagree_ppm(&values, &votes) }
        });
    }
    one.pixels = pixels.errors(gpu, &one.baseline, lookup);
    one.soft = find_soft_error(judge, &one.baseline, lookup);
}

/// Errors against the sphere, at the first [`SOFT_SAMPLES`] receivers that count.
fn find_soft_error(judge: &Judge, baseline: &Baseline, lookup: Lookup) -> Option<SoftError> {
    let (Filter::Soft { light_radius, .. }, Lookup::Filtered) = (judge.light().filter, lookup) else { return None };
    let truth = judge.truth();
    let counted = truth.receivers.iter().filter(|receiver| receiver.counts(truth.view.position));
    let receivers: Vec<Receiver> = counted.take(SOFT_SAMPLES).copied().collect();
    let inputs: Vec<_> = receivers.iter().map(|receiver| (receiver.position, receiver.normal)).collect();
    let values = baseline.shadow_values(judge.gpu(), lookup, &inputs)?;
    let radius = f64::from(light_radius);
    Some(soft_error(&values, &shares_of_sphere(&receivers, &truth.reference, &truth.view, radius, SOFT_RAYS)))
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
