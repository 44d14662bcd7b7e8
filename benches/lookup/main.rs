//! What a lookup costs on its own: passes over the whole screen that read recorded positions and normals.
//!
//! `cargo bench --bench lookup`; `-- --help` says what can be chosen.

mod lights;

use anyhow::Context;
use clap::Parser;
use dual_paraboloid::compare::cost::geometric_mean;
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::lookup_cost::{LookupBench, LookupTime, PassStage, Question};
use dual_paraboloid::compare::measure::{choose_camera, choose_light, find_scene, select_scenes};
use dual_paraboloid::compare::shot::Shot;
use dual_paraboloid::compare::text::{Table, one_line, parse_size};
use dual_paraboloid::compare::timing::{Rounds, Timer, milliseconds};
use serde::Serialize;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Time lookups over the whole screen.
#[derive(Parser)]
#[command(name = "lookup")]
struct Arguments {
    /// Scenes, separated by commas: made in code, files, or parts of the names of files in `DP_SCENES`
    #[arg(long, value_name = "NAME", value_delimiter = ',', default_value = "hall,many-small,dense-1m")]
    scenes: Vec<String>,
    /// Texels across each map of the pair; the cube has as many in all
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..))]
    resolution: u32,
    /// Pixels of the screens, separated by commas
    #[arg(long, value_name = "WxH", value_delimiter = ',', default_value = "1920x1080,3840x2160", value_parser = parse_size)]
    screens: Vec<(u32, u32)>,
    /// How often to time each pass
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
    /// Passes that are timed together
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    repeat: u32,
    /// Write the table
    #[arg(long, value_name = "FILE.md")]
    out: Option<PathBuf>,
    /// Write the figures
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// Only what asking the triangles costs: beside votes, the same walk in a cube and the hardware's comparison in cubes,
    /// for each of these numbers of lights a pixel, separated by commas. 0 for all lookups with one light
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "0", value_parser = clap::value_parser!(u32).range(..=32))]
    lights: Vec<u32>,
    /// Only see whether everything works: a small scene, a tiny map, few pixels, one run
    #[arg(long)]
    quick: bool,
    /// What cargo says to a benchmark.
    #[arg(long, hide = true)]
    bench: bool,
}

const LEGEND: &str = "\
Medians of a pass over the whole screen, with all passes interleaved: in compute, as deferred renderers light, and in a \
fragment pass. *Over nothing* is the time less \
that of the pass that only reads the position and the normal. Ratios are to the hardware's comparison in a cube, of \
the whole time and of that over nothing, and of filters to the same on the cube.";

fn main() -> ExitCode {
    match run(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("lookup: {}", one_line(format!("{error:#}")));
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: Arguments) -> anyhow::Result<()> {
    let arguments = if arguments.quick { quick(arguments) } else { arguments };
    if arguments.lights != [0] {
        return lights::run(&arguments);
    }
    let names = select_scenes(&arguments.scenes)?;
    let gpu = Gpu::new(wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)?;
    let timer = Timer::new(&gpu);
    let mut text = format!(
        "# Cost of a lookup\n\n{}; times: {}; R = {}, {} runs of {} passes.\n\n{LEGEND}\n",
        gpu.name(),
        timer.clock(),
        arguments.resolution,
        arguments.runs,
        arguments.repeat
    );
    let mut scenes = Vec::new();
    for name in &names {
        eprintln!("{name}");
        scenes.extend(measure(&gpu, &timer, name, &arguments)?);
    }
    for &size in &arguments.screens {
        for stage in PassStage::ALL {
            let title = format!("{}, {}x{}", stage.name(), size.0, size.1);
            text += &format!("\n## Geometric means over the scenes, {title}\n\n{}", means(&scenes, size, stage));
            for of in scenes.iter().filter(|of| of.size == size) {
                text += &format!("\n### {}, {title}\n\n{}", of.scene, table(&of.times, stage));
            }
        }
    }
    println!("{text}");
    let json = json!({
        "adapter": gpu.name(),
        "clock": timer.clock(),
        "resolution": arguments.resolution,
        "scenes": scenes,
    });
    write(&arguments, text, &json)
}

/// Writes the files that were asked for.
fn write(arguments: &Arguments, text: String, json: &serde_json::Value) -> anyhow::Result<()> {
    let files = [(&arguments.out, text), (&arguments.json, format!("{json:#}\n"))];
    files.iter().filter_map(|(path, text)| Some((path.as_ref()?, text))).try_for_each(|(path, text)| {
        std::fs::write(path, text).with_context(|| format!("can't write {}", path.display()))
    })
}

fn quick(arguments: Arguments) -> Arguments {
    Arguments {
        scenes: vec!["few-large".into()],
        resolution: 64,
        screens: vec![(64, 36)],
        runs: 1,
        repeat: 1,
        ..arguments
    }
}

/// A scene's times at one size of the screen.
#[derive(Serialize)]
struct SceneTimes {
    scene: String,
    size: (u32, u32),
    times: Vec<LookupTime>,
}

fn measure(gpu: &Gpu, timer: &Timer, name: &str, arguments: &Arguments) -> anyhow::Result<Vec<SceneTimes>> {
    // The other methods know no holes.
    let scene = find_scene(name)?.without_holes();
    let (light, choice) = choose_light(&scene, None, None);
    let rounds = Rounds { warm_up: 3, measured: arguments.runs as usize };
    let mut all = Vec::new();
    for shot in Shot::take_sizes(&scene, &choose_camera(&scene, &light, choice), &arguments.screens) {
        let bench = LookupBench::new(gpu, &scene, &light, &shot, arguments.resolution)?;
        let times = bench.times(timer, rounds, arguments.repeat);
        all.push(SceneTimes { scene: scene.name.clone(), size: (shot.width, shot.height), times });
    }
    Ok(all)
}

fn table(times: &[LookupTime], stage: PassStage) -> Table {
    let head = ["lookup", "time, us", "min", "max", "over nothing"];
    let mut table = Table::new(&[&head[..], &RATIOS].concat());
    for time in times.iter().filter(|time| time.stage == stage) {
        let micros = |milliseconds: f64| format!("{:.1}", 1000.0 * milliseconds);
        let taken = [time.time.median, time.time.min, time.time.max].map(|time| micros(milliseconds(time)));
        let ratios = figures(time).map(ratio);
        let cells = taken.into_iter().chain([micros(time.ms_over_nothing)]).chain(ratios);
        table.row([time.question.name().to_owned()].into_iter().chain(cells));
    }
    table
}

const RATIOS: [&str; 3] = ["to the cube", "to the cube, over nothing", "to the same on the cube, over nothing"];

fn figures(time: &LookupTime) -> [Option<f64>; 3] {
    [Some(time.to_cube), time.to_cube_over_nothing, time.to_same_on_cube_over_nothing]
}

/// Geometric means of the ratios over scenes.
fn means(scenes: &[SceneTimes], size: (u32, u32), stage: PassStage) -> Table {
    let mut table = Table::new(&[&["lookup"][..], &RATIOS].concat());
    for question in Question::all() {
        let of_size = scenes.iter().filter(|of| of.size == size).flat_map(|of| &of.times);
        let times: Vec<_> =
            of_size.filter(|time| time.stage == stage && time.question == question).map(figures).collect();
        let mean = |number: usize| {
            let all = times.iter().filter_map(|figures| figures[number]);
            geometric_mean(&all.filter(|ratio| *ratio > 0.0).collect::<Vec<_>>())
        };
        let ratios = [0, 1, 2].map(mean);
        table.row([question.name().to_owned()].into_iter().chain(ratios.map(ratio)));
    }
    table
}

fn ratio(ratio: Option<f64>) -> String {
    ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}"))
}
