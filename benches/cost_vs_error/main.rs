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
use dual_paraboloid::compare::cost::{Origin, Plan, Rule, SceneCosts, Subject, orientations};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::lookup_cost::Screens;
use dual_paraboloid::compare::measure::{Judge, Truth, choose_camera, choose_light, find_scene, is_made_in_code};
use dual_paraboloid::compare::scene::{Camera, Scene};
use dual_paraboloid::compare::shot::Shot;
use dual_paraboloid::compare::text::one_line;
use dual_paraboloid::compare::timing::Timer;
use figures::{Figures, main_resolution};
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
    let names = arguments.scene_names()?;
    let features =
        wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS | wgpu::Features::MULTIVIEW;
    let gpu = Gpu::new(features)?;
    let most = gpu.most_receivers();
    ensure!(u64::from(arguments.samples) <= most, "--samples can be {most} at most on {}", gpu.name());
    if let Some(folder) = &arguments.out {
        std::fs::create_dir_all(folder).with_context(|| format!("can't make the folder {}", folder.display()))?;
    }
    let timer = Timer::new(&gpu);
    let (plan, left_out) = plan(arguments, &gpu);
    let mut figures = Figures {
        adapter: gpu.name(),
        clock: timer.clock(),
        samples: arguments.samples,
        orientations: arguments.orientations,
        seed: arguments.seed,
        runs: arguments.runs,
        screens: arguments.screens.clone(),
        resolutions: arguments.resolution.clone(),
        main: main_resolution(&arguments.resolution),
        scenes: Vec::new(),
        left_out,
    };
    eprintln!("{} scenes on {} (times: {})", names.len(), gpu.name(), timer.clock());
    let bar = progress(names.len() * arguments.rules.len() * arguments.resolution.len());
    let bench = Bench { arguments, gpu: &gpu, timer: &timer, plan, bar };
    let mut written = Vec::new();
    for name in &names {
        bench.measure(name, &mut figures)?;
        // What ends early leaves the scenes that it got to.
        if !figures.scenes.is_empty() {
            written = write(arguments, &figures)?;
        }
    }
    bench.bar.finish_and_clear();
    if figures.scenes.is_empty() {
        bail!("nothing could be measured: {}", figures.left_out.join("; "));
    }
    println!("{}", report::summary(&figures));
    if let Some(folder) = &arguments.out {
        println!("written to {}: {}", folder.display(), written.join(", "));
    }
    Ok(())
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
        most: Duration::from_secs(arguments.seconds.into()),
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
            let started = Instant::now();
            let measured = self.gpu.attempt(|| self.costs(&mut setting, rule));
            match measured.map_err(Into::into).and_then(|costs| costs) {
                Ok(costs) => {
                    let seconds = started.elapsed().as_secs_f64();
                    self.bar.suspend(|| eprintln!("{}, {rule}: measured in {seconds:.1} s", costs.scene));
                    let of = |what| format!("{}, {rule}: {what}", costs.scene);
                    figures.left_out.extend(costs.left_out.iter().map(of));
                    figures.scenes.push(costs);
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

    fn costs(&self, setting: &mut Setting<'a>, rule: Rule) -> anyhow::Result<SceneCosts> {
        let name = setting.scene.name.clone();
        let message = |what: &str| self.bar.set_message(format!("{name}, {rule}: {what}"));
        message("casters");
        let light = setting.light;
        let casters = DeviceScene::new(self.gpu, &setting.scene, rule.sides())?;
        message("the truth");
        let (samples, seed) = (self.arguments.samples as usize, self.arguments.seed);
        let truth = Truth::with_sides(&setting.scene, &light, rule.sides(), samples, seed);
        ensure!(truth.counted() > 0, "its light reaches no surface");
        let orientations = orientations(self.arguments.orientations as usize, seed);
        let turned = PointLight { orientation: orientations[0], ..light };
        let judge = Judge::new(self.gpu, turned, &truth);
        let triangles = setting.scene.triangle_count();
        let origin = setting.origin;
        message("the camera's view");
        let screens = setting.screens(self.gpu, &truth, rule, &self.arguments.screens);
        let mut subject = Subject { gpu: self.gpu, timer: self.timer, casters, light, orientations, judge, screens };
        let (mut costs, mut left_out) = (Vec::new(), Vec::new());
        for &pair in &self.arguments.resolution {
            message(&format!("R = {pair}"));
            let (more, without) = subject.costs(&self.plan, pair)?;
            costs.extend(more);
            left_out.extend(without);
            self.bar.inc(1);
        }
        Ok(SceneCosts { scene: name.clone(), origin, triangles, rule, costs, left_out })
    }
}

fn setting<'a>(name: &str) -> anyhow::Result<Setting<'a>> {
    // The other methods know no holes.
    let scene = find_scene(name)?.without_holes();
    let (light, choice) = choose_light(&scene, None, None);
    let camera = choose_camera(&scene, &light, choice);
    let origin = if is_made_in_code(name) { Origin::Code } else { Origin::File };
    Ok(Setting { origin, light, camera, screens: None, scene })
}

/// A bar on stderr; indicatif shows it on a terminal only.
fn progress(steps: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:32} {percent:>3} %  {elapsed}  {msg}");
    let bar = ProgressBar::new(steps as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

/// Writes what was asked for, and returns the names of the files in the folder.
fn write(arguments: &Arguments, figures: &Figures) -> anyhow::Result<Vec<String>> {
    if let Some(path) = &arguments.json {
        write_file(path, &format!("{:#}\n", figures.to_json()))?;
    }
    let Some(folder) = &arguments.out else { return Ok(Vec::new()) };
    let pictures = pictures::write_all(folder, figures)?;
    let links: String = pictures.iter().map(|name| format!("\n![{name}]({name})\n")).collect();
    let text = format!("{}{links}{}", report::summary(figures), report::details(figures));
    write_file(&folder.join("report.md"), &text)?;
    Ok(["report.md".to_owned()].into_iter().chain(pictures).collect())
}

fn write_file(path: &Path, text: &str) -> anyhow::Result<()> {
    std::fs::write(path, text).with_context(|| format!("can't write {}", path.display()))
}
