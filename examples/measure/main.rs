//! Measures how wrong a scene's shadows are against a ray-cast truth, and how long their maps take. See README.md
//! beside this file.

mod arguments;
mod figures;
#[path = "../render/filter.rs"]
mod filter;
mod pictures;
mod report;
#[path = "../render/map.rs"]
mod truth_depth;

use anyhow::{anyhow, ensure};
use arguments::{Arguments, Rule};
use clap::Parser;
use dual_paraboloid::compare::baselines::{DeviceScene, Method};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::measure::{Judge, Pixels, Truth, choose_camera, choose_light, find_scene};
use dual_paraboloid::compare::text::{grouped, one_line};
use dual_paraboloid::compare::timing::Timer;
use dual_paraboloid::compare::walk::IdealWalks;
use dual_paraboloid::{PointLight, Sides};
use filter::FilterName;
use indicatif::{ProgressBar, ProgressStyle};
use report::Common;
use std::process::ExitCode;
use std::time::Duration;

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("measure: {}", one_line(error));
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let mut scene = find_scene(&arguments.scene)?;
    let others = arguments.methods.iter().any(|entry| entry.method != Method::Paraboloid);
    if others && scene.has_holes() {
        println!("holes      left out, since methods other than paraboloid know none");
        scene = scene.without_holes();
    }
    let (light, choice) = choose_light(&scene, arguments.light, arguments.range);
    let light = PointLight { filter: arguments.filter.with(arguments.light_radius, light.range), ..light };
    light.validate()?;
    ensure!(
        arguments.rule == Rule::Exact || arguments.filter == FilterName::Sharp,
        "--rule votes is of --filter sharp: the other filters have votes of their own"
    );
    let gpu = Gpu::new(
        wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS | wgpu::Features::MULTIVIEW,
    )?;
    let most = gpu.most_receivers();
    ensure!(u64::from(arguments.samples) <= most, "--samples can be {most} at most on {}", gpu.name());
    let [width, height] = arguments.size.0;
    ensure!(u64::from(width) * u64::from(height) <= most, "--size can have {most} pixels at most on {}", gpu.name());
    if let Some(folder) = &arguments.pictures {
        std::fs::create_dir_all(folder)
            .map_err(|error| anyhow!("can't make the folder {}: {error}", folder.display()))?;
    }
    let timer = Timer::new(&gpu);
    let camera = choose_camera(&scene, &light, choice);
    let at = light.position;
    println!("adapter    {} (times: {})", gpu.name(), timer.clock());
    println!("scene      {}: {} triangles", scene.name, grouped(scene.triangle_count()));
    println!("light      at {},{},{}, range {:.4}, near {:.3e} ({choice})", at.x, at.y, at.z, light.range, light.near);
    println!("camera     at {}, to {}, {width} x {height}", camera.eye, camera.target);
    println!("filter     {:?}", light.filter);

    let mut measured = figures::prepare(&gpu, arguments)?;
    let mut casters = DeviceScene::new(&gpu, &scene, Sides::Auto)?;
    let bar = progress(2 + measured.len() + figures::time_steps(arguments));
    bar.set_message("the truth");
    let truth = Truth::new(&scene, &light, arguments.samples as usize, arguments.seed);
    ensure!(
        truth.receivers.iter().any(|receiver| receiver.counts(truth.view.position)),
        "the light at {},{},{} reaches no surface of {} that faces it",
        at.x,
        at.y,
        at.z,
        scene.name
    );
    let points = truth.receivers.len();
    ensure!(points as u64 <= most, "{points} points with those that graze, {most} at most on {}", gpu.name());
    bar.inc(1);
    let pixels = Pixels::new(&truth, &scene, &camera, width, height);
    bar.inc(1);
    let mut judge = Judge::new(&gpu, light, &truth);
    let walks = IdealWalks::new(&scene);
    figures::find_errors(&mut judge, arguments.rule, &walks, &pixels, &mut measured, &mut casters, &bar)?;
    figures::find_times(&timer, &gpu, &mut measured, &mut casters, &light, arguments.runs as usize, &bar)?;
    bar.finish_and_clear();

    println!();
    report::print_table(&measured);
    if let Some(path) = &arguments.json {
        let common = Common {
            scene: scene.name.clone(),
            triangles: scene.triangle_count(),
            adapter: gpu.name(),
            runs: arguments.runs,
        };
        report::write_json(path, &common, &measured)?;
    }
    if let Some(folder) = &arguments.pictures {
        pictures::write_all(folder, &gpu, &scene, &camera, &truth, arguments.rule, &measured)?;
    }
    Ok(())
}

/// A bar on stderr; indicatif shows it on a terminal only.
fn progress(steps: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:32} {percent:>3} %  {elapsed}  {msg}");
    let bar = ProgressBar::new(steps as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
