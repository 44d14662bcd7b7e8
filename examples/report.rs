//! Measures the hall and the test scenes against the ray-cast truth, and writes a table in Markdown. `./dev report`.
//!
//! The scenes are looked for in the folder that the environment variable `DP_SCENES` names. Each is measured with its
//! first light, near and range as the example `measure` takes them, and with the defaults of the library.

use anyhow::anyhow;
use clap::Parser;
use dual_paraboloid::compare::baselines::{Baseline, DeviceScene, Lookup, Method};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::measure::{Judge, Judged, Truth, choose_light, find_scene};
use dual_paraboloid::compare::scene::{Scene, scene_files, scenes_dir};
use dual_paraboloid::compare::text::one_line;
use dual_paraboloid::{PointLight, Sides};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Write the table of errors of the hall and of the scenes in `DP_SCENES`.
#[derive(Parser)]
#[command(name = "report")]
struct Arguments {
    /// Write the table here too
    #[arg(short, long, value_name = "FILE.md")]
    output: Option<PathBuf>,
    /// Points of each scene to ask for their shadow
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(1..))]
    samples: u32,
    /// Number that the points are drawn with
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Texels across each hemisphere's map, separated by commas
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [512, 1024])]
    resolution: Vec<u32>,
    /// Only scenes whose name contains one of these, separated by commas
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    scenes: Vec<String>,
}

const HEAD: &str = "\
| scene | triangles | R | wrong | ideal | ratio | far | ideal far | holes | phantoms | strays | depth p99 | vertex warp |
| --- | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: |";

const LEGEND: &str = "\
Wrong answers, in parts per million of the samples: *wrong* of this library, *ideal* of the same lookup on a ray-cast \
map, *ratio* of the two, *far* those farther than 1.5 texels from any shadow boundary or crease, *vertex warp* of the \
technique as published with the best of 17 constant biases for the scene, without the scene's holes, since it knows \
none. Texels of the map: *holes* are empty where there is a caster, *phantoms* the reverse, *strays* wrong and more \
than a texel from any silhouette; *depth p99* is the relative depth error that 99 % of the right ones stay below.";

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("report: {}", one_line(error));
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let gpu = Gpu::new(wgpu::Features::empty())?;
    let names = scene_names(&arguments.scenes)?;
    let title = format!("Errors on {}, {} samples, seed {}.", gpu.name(), arguments.samples, arguments.seed);
    let mut text = format!("{title}\n\n{HEAD}\n");
    print!("{text}");
    let style = ProgressStyle::with_template("{bar:32} {percent:>3} %  {elapsed}  {msg}");
    let bar = ProgressBar::new((names.len() * arguments.resolution.len()) as u64);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.enable_steady_tick(Duration::from_millis(200));
    for name in &names {
        let mut subject = Subject::new(&gpu, name, arguments)?;
        for &resolution in &arguments.resolution {
            bar.set_message(format!("{} at {resolution}", subject.scene.name));
            let row = subject.row(&gpu, resolution)?;
            bar.suspend(|| println!("{row}"));
            text += &format!("{row}\n");
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    println!("\n{LEGEND}");
    text += &format!("\n{LEGEND}\n");
    arguments.output.as_ref().map_or(Ok(()), |path| {
        std::fs::write(path, &text).map_err(|error| anyhow!("can't write {}: {error}", path.display()))
    })
}

/// The hall and every file, by name, that holds one of `wanted`; all if there is none.
fn scene_names(wanted: &[String]) -> anyhow::Result<Vec<String>> {
    let mut names = vec!["hall".to_owned()];
    match scenes_dir() {
        None => eprintln!("report: no folder of scenes, so only the hall: name one in DP_SCENES"),
        Some(folder) => {
            names.extend(scene_files(&folder)?.into_iter().map(|path| path.to_string_lossy().into_owned()));
        }
    }
    names.retain(|name| {
        let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
        wanted.is_empty() || wanted.iter().any(|part| file.contains(part))
    });
    Ok(names)
}

/// A scene with its light and its truth.
struct Subject {
    scene: Scene,
    light: PointLight,
    own: Trial,
    /// Without holes, which the vertex warp knows nothing of; if there are any.
    whole: Option<Trial>,
}

/// Casters and the truth of them.
struct Trial {
    truth: Truth,
    casters: DeviceScene,
}

impl Trial {
    fn new(gpu: &Gpu, scene: &Scene, light: &PointLight, arguments: &Arguments) -> anyhow::Result<Self> {
        let truth = Truth::new(scene, light, arguments.samples as usize, arguments.seed);
        Ok(Self { truth, casters: DeviceScene::new(gpu, scene, Sides::Auto)? })
    }

    fn judge(
        &mut self,
        gpu: &Gpu,
        light: PointLight,
        method: Method,
        lookup: Lookup,
        resolution: u32,
    ) -> anyhow::Result<Judged> {
        let mut baseline = Baseline::new(&gpu.device, method, resolution)?;
        let judged = Judge::new(gpu, light, &self.truth).judge(&mut baseline, lookup, &mut self.casters)?;
        judged.ok_or_else(|| anyhow!("{method} can't be read by {}", lookup.name()))
    }
}

impl Subject {
    fn new(gpu: &Gpu, name: &str, arguments: &Arguments) -> anyhow::Result<Self> {
        let scene = find_scene(name)?;
        let (light, _) = choose_light(&scene, None, None);
        let own = Trial::new(gpu, &scene, &light, arguments)?;
        let whole =
            scene.has_holes().then(|| Trial::new(gpu, &scene.without_holes(), &light, arguments)).transpose()?;
        Ok(Self { scene, light, own, whole })
    }

    fn row(&mut self, gpu: &Gpu, resolution: u32) -> anyhow::Result<String> {
        let light = self.light;
        let own = self.own.judge(gpu, light, Method::Paraboloid, Lookup::Paraboloid, resolution)?;
        let trial = self.whole.as_mut().unwrap_or(&mut self.own);
        let warp = trial.judge(gpu, light, Method::VertexWarp, Lookup::VertexWarp, resolution)?;
        let (map, shadow) = (own.map.unwrap_or_default(), own.shadow);
        let ideal = own.ideal.map(|(_, error)| error).unwrap_or_default();
        Ok(format!(
            "| {} | {} | {resolution} | {:.0} | {:.0} | {:.3} | {:.1} | {:.1} | {} | {} | {} | {:.1e} | {:.0} |",
            self.scene.name,
            self.scene.triangle_count(),
            shadow.wrong_ppm,
            ideal.wrong_ppm,
            shadow.wrong_ppm / ideal.wrong_ppm,
            shadow.far_wrong_ppm,
            ideal.far_wrong_ppm,
            map.holes,
            map.phantoms,
            map.strays,
            map.depth_error_p99,
            warp.shadow.wrong_ppm,
        ))
    }
}
