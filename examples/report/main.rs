//! Measures errors over scenes against the ray-cast truth, and writes tables in Markdown. `./dev report`.
//!
//! Real scenes are looked for in the folder that the environment variable `DP_SCENES` names. Each scene is measured with
//! its first light, near and range as the example `measure` takes them, and with the defaults of the library.

mod subject;
mod tables;

use anyhow::{Context, ensure};
use clap::Parser;
use dual_paraboloid::compare::error_figures::SAMPLES;
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::measure::{SCENES_IN_CODE, select_scenes};
use dual_paraboloid::compare::scene::{scene_files, scenes_dir};
use dual_paraboloid::compare::text::{one_line, parse_size};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;
use subject::{Measured, Subject};

/// Write tables of errors: of this library beside other methods, and beside what its maps allow.
#[derive(Parser)]
#[command(name = "report")]
struct Arguments {
    /// Write the tables here too
    #[arg(short, long, value_name = "FILE.md")]
    output: Option<PathBuf>,
    /// Points of each scene to ask for their shadow
    #[arg(long, value_name = "N", default_value_t = SAMPLES as u32, value_parser = clap::value_parser!(u32).range(1..))]
    samples: u32,
    /// Random orientations of all maps that methods are compared in
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    orientations: u32,
    /// Number that the points and the orientations are drawn with
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Texels across each hemisphere's map, separated by commas; cubes have as many in all
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [512, 1024], value_parser = clap::value_parser!(u32).range(1..))]
    resolution: Vec<u32>,
    /// Pixels of the scene's camera
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = parse_size)]
    size: (u32, u32),
    /// Scenes, separated by commas: made in code, files, or parts of the names of files in `DP_SCENES`. Without it, all
    /// files and those made in code of fewer than a million triangles
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    scenes: Vec<String>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("report: {}", one_line(format!("{error:#}")));
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let names = scene_names(&arguments.scenes)?;
    let gpu = Gpu::new(wgpu::Features::empty())?;
    let most = gpu.most_receivers();
    ensure!(u64::from(arguments.samples) <= most, "--samples can be {most} at most on {}", gpu.name());
    let style = ProgressStyle::with_template("{bar:32} {percent:>3} %  {elapsed}  {msg}");
    let bar = ProgressBar::new((names.len() * arguments.resolution.len()) as u64);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.enable_steady_tick(Duration::from_millis(200));
    let conditions = format!(
        "Errors on {}, {} samples and a camera of {}x{} pixels a scene, {} random orientations, seed {}.",
        gpu.name(),
        arguments.samples,
        arguments.size.0,
        arguments.size.1,
        arguments.orientations,
        arguments.seed
    );
    let (mut all, mut text): (Vec<Measured>, String) = (Vec::new(), String::new());
    for name in &names {
        bar.set_message(format!("{name}: the truth"));
        let mut subject = Subject::new(&gpu, name, arguments)?;
        for &resolution in &arguments.resolution {
            bar.set_message(format!("{} at {resolution}", subject.name()));
            all.push(subject.measure(&gpu, resolution)?);
            bar.inc(1);
        }
        text = format!("# Errors\n\n{conditions}\n{}", tables::all(&all));
        // What ends early leaves the scenes that it got to.
        if let Some(path) = &arguments.output {
            std::fs::write(path, &text).with_context(|| format!("can't write {}", path.display()))?;
        }
    }
    bar.finish_and_clear();
    println!("{text}");
    Ok(())
}

/// The scenes that are wanted; without any, all files after those made in code.
fn scene_names(wanted: &[String]) -> anyhow::Result<Vec<String>> {
    if !wanted.is_empty() {
        return Ok(select_scenes(wanted)?);
    }
    let in_code = SCENES_IN_CODE.iter().filter(|name| !name.starts_with("dense-")).map(|name| (*name).to_owned());
    let files = match scenes_dir() {
        Some(folder) => scene_files(&folder)?,
        None => {
            eprintln!("report: no folder of real scenes, so only those made in code: name one in DP_SCENES");
            Vec::new()
        }
    };
    Ok(in_code.chain(files.into_iter().map(|path| path.to_string_lossy().into_owned())).collect())
}
