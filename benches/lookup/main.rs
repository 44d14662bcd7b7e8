//! What a lookup costs on its own: passes over the whole screen that read recorded positions and normals.
//!
//! `cargo bench --bench lookup`; `-- --help` says what can be chosen.

use anyhow::Context;
use clap::Parser;
use dual_paraboloid::compare::cost::geometric_mean;
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::lookup_cost::{LookupBench, LookupTime, Question};
use dual_paraboloid::compare::measure::{choose_light, find_scene, select_scenes};
use dual_paraboloid::compare::shot::Shot;
use dual_paraboloid::compare::text::{Table, one_line};
use dual_paraboloid::compare::timing::{Rounds, Timer, milliseconds};
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
    /// Pixels of the screen
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1920x1080", value_parser = size)]
    size: (u32, u32),
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
    /// Only see whether everything works: a small scene, a tiny map, few pixels, one run
    #[arg(long)]
    quick: bool,
    /// What cargo says to a benchmark.
    #[arg(long, hide = true)]
    bench: bool,
}

const LEGEND: &str = "\
Medians of a pass over the whole screen, with all passes interleaved. *Over nothing* is the time less \
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
    let names = select_scenes(&arguments.scenes)?;
    let gpu = Gpu::new(wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)?;
    let timer = Timer::new(&gpu);
    let (width, height) = arguments.size;
    let mut text = format!(
        "# Cost of a lookup\n\n{}; times: {}; {width}x{height} pixels, R = {}, {} runs of {} passes.\n\n{LEGEND}\n",
        gpu.name(),
        timer.clock(),
        arguments.resolution,
        arguments.runs,
        arguments.repeat
    );
    let mut scenes = Vec::new();
    for name in &names {
        eprintln!("{name}");
        let (scene, times) = measure(&gpu, &timer, name, &arguments)?;
        text += &format!("\n## {scene}\n\n{}", table(&times));
        scenes.push((scene, times));
    }
    text += &format!("\n## Geometric means over the scenes\n\n{}", means(&scenes));
    println!("{text}");
    let json = json!({
        "adapter": gpu.name(),
        "clock": timer.clock(),
        "size": [width, height],
        "resolution": arguments.resolution,
        "scenes": scenes.iter().map(|(scene, times)| json!({ "scene": scene, "lookups": times })).collect::<Vec<_>>(),
    });
    let files = [(&arguments.out, text), (&arguments.json, format!("{json:#}\n"))];
    files.iter().filter_map(|(path, text)| Some((path.as_ref()?, text))).try_for_each(|(path, text)| {
        std::fs::write(path, text).with_context(|| format!("can't write {}", path.display()))
    })
}

fn quick(arguments: Arguments) -> Arguments {
    Arguments { scenes: vec!["few-large".into()], resolution: 64, size: (64, 36), runs: 1, repeat: 1, ..arguments }
}

fn measure(gpu: &Gpu, timer: &Timer, name: &str, arguments: &Arguments) -> anyhow::Result<(String, Vec<LookupTime>)> {
    // The other methods know no holes.
    let scene = find_scene(name)?.without_holes();
    let (light, _) = choose_light(&scene, None, None);
    let (width, height) = arguments.size;
    let shot = Shot::take(&scene, &scene.suggest_camera(light.position), width, height);
    let bench = LookupBench::new(gpu, &scene, &light, &shot, arguments.resolution)?;
    let rounds = Rounds { warm_up: 3, measured: arguments.runs as usize };
    Ok((scene.name, bench.times(timer, rounds, arguments.repeat)))
}

fn table(times: &[LookupTime]) -> Table {
    let head = ["lookup", "time, us", "min", "max", "over nothing"];
    let mut table = Table::new(&[&head[..], &RATIOS].concat());
    for time in times {
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
fn means(scenes: &[(String, Vec<LookupTime>)]) -> Table {
    let mut table = Table::new(&[&["lookup"][..], &RATIOS].concat());
    for (place, question) in Question::ALL.into_iter().enumerate() {
        let mean = |number: usize| {
            let all = scenes.iter().filter_map(|(_, times)| figures(&times[place])[number]);
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

fn size(text: &str) -> Result<(u32, u32), String> {
    let pixels = |text: &str| text.parse::<u32>().ok().filter(|pixels| (1..=8192).contains(pixels));
    let parsed = text.split_once('x').and_then(|(width, height)| pixels(width).zip(pixels(height)));
    parsed.ok_or_else(|| format!("{text:?} is not like 1920x1080, with 1 to 8192 pixels each way"))
}
