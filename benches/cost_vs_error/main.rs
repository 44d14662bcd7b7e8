//! Cost against error: this library and other ways to make a point light's shadow map, over scenes and resolutions.
//!
//! `cargo bench --bench cost_vs_error`, or `./dev bench`; `-- --help` says what can be chosen.

mod arguments;
mod figures;
mod pictures;
mod report;

use anyhow::{Context, bail, ensure};
use arguments::Arguments;
use dual_paraboloid::PointLight;
use dual_paraboloid::compare::baselines::DeviceScene;
use dual_paraboloid::compare::cost::{Origin, OwnErrors, Plan, Rule, SceneCosts, Subject, orientations};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::lookup_cost::Screens;
use dual_paraboloid::compare::measure::{
    Judge, Pixels, Truth, choose_camera, choose_light, find_scene, is_made_in_code,
};
use dual_paraboloid::compare::scene::{Camera, Scene};
use dual_paraboloid::compare::shot::Shot;
use dual_paraboloid::compare::text::one_line;
use dual_paraboloid::compare::timing::Timer;
use dual_paraboloid::compare::walk::IdealWalks;
use figures::{Figures, Measured, main_resolution};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

fn main() -> ExitCode {
    match run(&Arguments::read()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cost_vs_error: {}", one_line(format!("{error:#}")));
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if let Some(folder) = &arguments.out {
        std::fs::create_dir_all(folder).with_context(|| format!("can't make the folder {}", folder.display()))?;
    }
    let figures = if arguments.merge.is_empty() {
        measure_all(arguments)?
    } else {
        Figures::merge(Measured::read_all(&arguments.merge)?)?
    };
    println!("{}", report::summary(&figures));
    if let Some(folder) = &arguments.out {
        println!("written to {}: {}", folder.display(), write(folder, &figures)?.join(", "));
    }
    Ok(())
}

/// Measures all scenes; what ends early leaves the figures of those that it got to.
fn measure_all(arguments: &Arguments) -> anyhow::Result<Figures> {
    let names = arguments.scene_names()?;
    let features =
        wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS | wgpu::Features::MULTIVIEW;
    let gpu = Gpu::new(features)?;
    let most = gpu.most_receivers();
    ensure!(u64::from(arguments.samples) <= most, "--samples can be {most} at most on {}", gpu.name());
    let (width, height) = arguments.camera;
    ensure!(u64::from(width) * u64::from(height) <= most, "--camera can have {most} pixels at most on {}", gpu.name());
    let timer = Timer::new(&gpu);
    let (plan, left_out) = plan(arguments, &gpu);
    let mut figures = Figures::new(arguments.conditions(timer.clock()), left_out);
    eprintln!("{} scenes on {} (times: {})", names.len(), gpu.name(), timer.clock());
    let bar = progress(names.len() * arguments.rules.len() * arguments.resolution.len());
    let bench = Bench { arguments, gpu: &gpu, timer: &timer, plan, bar };
    for name in &names {
        bench.measure(name, &mut figures)?;
    }
    bench.bar.finish_and_clear();
    if figures.scenes.is_empty() {
        bail!("nothing could be measured: {}", figures.left_out.join("; "));
    }
    Ok(figures)
}

/// What is measured at each resolution, and which methods the device can't do.
fn plan(arguments: &Arguments, gpu: &Gpu) -> (Plan, Vec<String>) {
    let methods = arguments.methods.iter().copied().filter(|method| method.is_available(gpu)).collect();
    let left_out =
        arguments.methods.iter().filter_map(|method| Some(format!("{method}: left out: {}", method.left_out(gpu)?)));
    let plan = Plan {
        methods,
        main: main_resolution(&arguments.resolution),
        runs: arguments.runs as usize,
        most: arguments.seconds,
    };
    (plan, left_out.collect())
}

/// What all scenes are measured with.
struct Bench<'a> {
    arguments: &'a Arguments,
    gpu: &'a Gpu,
    timer: &'a Timer<'a>,
    plan: Plan,
    bar: ProgressBar,
}

/// A scene to be measured, and what is the same under all rules.
struct Setting<'a> {
    scene: Scene,
    /// As it is, if it has holes.
    with_holes: Option<Scene>,
    origin: Origin,
    light: PointLight,
    camera: Camera,
    /// What the camera sees, once a rule needed it.
    screens: Option<Screens<'a>>,
}

impl<'a> Setting<'a> {
    /// Casts the camera's rays, in the truth's triangles where all of them are there.
    fn screens(&mut self, gpu: &'a Gpu, truth: &Truth, rule: Rule, sizes: &[(u32, u32)]) -> &mut Screens<'a> {
        self.screens.get_or_insert_with(|| {
            let shots = match rule {
                Rule::DoubleSided => {
                    let shot = |&(width, height)| Shot::of(&truth.reference, &self.camera, width, height);
                    sizes.iter().map(shot).collect()
                }
                Rule::Culled => Shot::take_sizes(&self.scene, &self.camera, sizes),
            };
            Screens::new(gpu, &shots, &self.light)
        })
    }
}

impl<'a> Bench<'a> {
    /// Measures a scene under all rules. What the device can't do is left out, and `figures` says so.
    fn measure(&self, name: &str, figures: &mut Figures) -> anyhow::Result<()> {
        self.bar.set_message(format!("{name}: the scene"));
        let mut setting = setting(name)?;
        for &rule in &self.arguments.rules {
            let mut clock = Clock::new();
            let measured = self.gpu.attempt(|| self.costs(&mut setting, rule, &mut clock));
            match measured.map_err(Into::into).and_then(|costs| costs) {
                Ok(costs) => {
                    self.bar.suspend(|| eprintln!("{}, {rule}: {}", costs.scene, clock.text()));
                    let conditions = figures.conditions.clone();
                    let measured = Measured { adapter: self.gpu.name(), conditions, costs };
                    if let Some(folder) = &self.arguments.out {
                        measured.write(folder)?;
                    }
                    figures.add(measured);
                }
                Err(error) => {
                    let (scene, why) = (&setting.scene.name, one_line(format!("{error:#}")));
                    self.bar.suspend(|| eprintln!("{scene}, {rule}: left out: {why}"));
                    figures.left_out.push(format!("{scene}, {rule}: {why}"));
                }
            }
        }
        Ok(())
    }

    fn costs(&self, setting: &mut Setting<'a>, rule: Rule, clock: &mut Clock) -> anyhow::Result<SceneCosts> {
        let name = setting.scene.name.clone();
        let message = |what: &str| self.bar.set_message(format!("{name}, {rule}: {what}"));
        message("the casters");
        let light = setting.light;
        let casters = DeviceScene::new(self.gpu, &setting.scene, rule.sides())?;
        message("the truth");
        let (samples, seed) = (self.arguments.samples as usize, self.arguments.seed);
        let truth = Truth::with_sides(&setting.scene, &light, rule.sides(), samples, seed);
        ensure!(truth.counted() > 0, "its light reaches no surface");
        clock.lap("truth");
        let orientations = orientations(self.arguments.orientations as usize, seed);
        let turned = PointLight { orientation: orientations[0], ..light };
        let judge = Judge::new(self.gpu, turned, &truth);
        let triangles = setting.scene.triangle_count();
        let origin = setting.origin;
        message("the camera's view");
        let screens = setting.screens(self.gpu, &truth, rule, &self.arguments.screens);
        clock.lap("view");
        let mut subject = Subject { gpu: self.gpu, timer: self.timer, casters, light, orientations, judge, screens };
        let (mut costs, mut left_out) = (Vec::new(), Vec::new());
        for &pair in &self.arguments.resolution {
            message(&format!("R = {pair}"));
            let (more, without) = subject.costs(&self.plan, pair)?;
            costs.extend(more);
            left_out.extend(without);
            self.bar.inc(1);
        }
        clock.lap("methods");
        message("this library's errors");
        let mut casters = subject.casters;
        let own = match rule {
            Rule::DoubleSided => self.own_errors(setting, &truth, &mut casters)?,
            Rule::Culled => Vec::new(),
        };
        clock.lap("own errors");
        Ok(SceneCosts { scene: name.clone(), origin, triangles, rule, costs, own, left_out })
    }

    /// This library's errors by all definitions, with the scene's holes: `truth` and `casters` are without any.
    fn own_errors(
        &self,
        setting: &Setting,
        truth: &Truth,
        casters: &mut DeviceScene,
    ) -> anyhow::Result<Vec<OwnErrors>> {
        let Arguments { samples, seed, camera: (width, height), .. } = *self.arguments;
        let (gpu, light, with_holes) = (self.gpu, &setting.light, &setting.with_holes);
        let mut holed = with_holes.as_ref().map(|scene| {
            let truth = Truth::new(scene, light, samples as usize, seed);
            anyhow::Ok((truth, DeviceScene::new(gpu, scene, Rule::DoubleSided.sides())?))
        });
        let (truth, casters) = match &mut holed {
            None => (truth, casters),
            Some(Ok((truth, casters))) => (&*truth, casters),
            Some(Err(error)) => bail!("{error:#}"),
        };
        let scene = with_holes.as_ref().unwrap_or(&setting.scene);
        let pixels = Pixels::new(truth, scene, &setting.camera, width, height);
        let walks = IdealWalks::new(scene);
        let find = |&resolution: &u32| Ok(OwnErrors::find(gpu, truth, &walks, &pixels, casters, light, resolution)?);
        self.arguments.own.iter().map(find).collect()
    }
}

/// What the steps of a scene took, for whoever waits.
struct Clock {
    last: Instant,
    laps: Vec<(&'static str, Duration)>,
}

impl Clock {
    fn new() -> Self {
        Self { last: Instant::now(), laps: Vec::new() }
    }

    fn lap(&mut self, what: &'static str) {
        self.laps.push((what, self.last.elapsed()));
        self.last = Instant::now();
    }

    fn text(&self) -> String {
        let all: Duration = self.laps.iter().map(|lap| lap.1).sum();
        let laps = self.laps.iter().map(|(what, time)| format!("{what} {:.1}", time.as_secs_f64()));
        format!("measured in {:.1} s: {}", all.as_secs_f64(), laps.collect::<Vec<_>>().join(", "))
    }
}

fn setting<'a>(name: &str) -> anyhow::Result<Setting<'a>> {
    let scene = find_scene(name)?;
    // The other methods know no holes.
    let (scene, with_holes) = if scene.has_holes() { (scene.without_holes(), Some(scene)) } else { (scene, None) };
    let (light, choice) = choose_light(&scene, None, None);
    let camera = choose_camera(&scene, &light, choice);
    let origin = if is_made_in_code(name) { Origin::Code } else { Origin::File };
    Ok(Setting { origin, light, camera, screens: None, scene, with_holes })
}

/// A bar on stderr; indicatif shows it on a terminal only.
fn progress(steps: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:32} {percent:>3} %  {elapsed}  {msg}");
    let bar = ProgressBar::new(steps as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Writes tables and pictures to a folder, and returns the names of the files.
fn write(folder: &Path, figures: &Figures) -> anyhow::Result<Vec<String>> {
    let pictures = pictures::write_all(folder, figures)?;
    let links: String = pictures.iter().map(|name| format!("\n![{name}]({name})\n")).collect();
    let cost = format!("{}{links}{}", report::summary(figures), report::details(figures));
    let texts = [
        ("cost.md", cost),
        ("errors.md", report::errors(figures)),
        ("exact.md", report::exact(figures)),
        ("readme.md", report::readme(figures)),
    ];
    for (name, text) in &texts {
        let path = folder.join(name);
        std::fs::write(&path, text).with_context(|| format!("can't write {}", path.display()))?;
    }
    Ok(texts.iter().map(|(name, _)| (*name).to_owned()).chain(pictures).collect())
}
