//! Many lights over a crowd: what a frame costs beside cube maps with as many texels, and what it looks like. See
//! README.md beside this file.

mod arguments;
#[path = "../render/camera.rs"]
mod camera;
mod cloth;
mod foliage;
#[path = "../render/model.rs"]
mod model;
mod plaza;
mod sides;

use anyhow::Context;
use arguments::Arguments;
use clap::Parser;
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::text::{Table, one_line};
use dual_paraboloid::compare::timing::{Summary, Timer, Times, milliseconds};
use dual_paraboloid::{Casters, LightId, Sides};
use glam::{UVec2, Vec3};
use plaza::Plaza;
use sides::{BothSides, Way};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Seconds from one way's frame to the next one's.
const STEP: f32 = 1.0 / 240.0;
/// Frames that aren't counted.
const WARM_UP: u32 = 2;
/// Pixels of a picture.
const SIZE: UVec2 = UVec2::new(1280, 720);
/// Of a lamp, a little warmer than white.
const INTENSITY: Vec3 = Vec3::new(6.0, 5.5, 4.8);

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("crowd: {}", one_line(error));
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let features = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
    let gpu = Gpu::new(features)?;
    let walking = arguments.walking.unwrap_or(arguments.instances).min(arguments.instances);
    let mut plaza = Plaza::new(arguments.lights, arguments.range, arguments.instances, walking);
    let mut sides = BothSides::new(&gpu, &plaza, arguments.resolution)?;
    println!("adapter      {}", gpu.name());
    println!(
        "plaza        {} lights that reach {} m, {} figures, of which {walking} walk, {} triangles, R = {}",
        arguments.lights,
        arguments.range,
        arguments.instances,
        sides.triangles(),
        arguments.resolution
    );
    let [casters, maps, kept] = sides.memory().map(|bytes| bytes as f64 / f64::from(1 << 20));
    println!("memory       {casters:.1} MiB of casters, {maps:.1} MiB of maps, {kept:.1} MiB with static ones kept");
    let Measured { times, recording, moving } = measure(arguments, &gpu, &mut plaza, &mut sides)?;
    println!("moving       {:.0} us on the CPU to say where all are, the median", microseconds(moving.median));
    print_medians(&times, &recording);
    if let Some(path) = &arguments.json {
        let json = serde_json::to_string_pretty(&figures(arguments, &gpu, &sides, &times))?;
        make_folder(path)?;
        std::fs::write(path, json).with_context(|| format!("writing {}", path.display()))?;
    }
    pictures(arguments, &gpu, &mut plaza)
}

/// What was measured.
struct Measured {
    /// Of each way; the host's with the encoder's finish.
    times: [Times; Way::ALL.len()],
    /// The host's without it.
    recording: [Summary; Way::ALL.len()],
    /// Of saying what has moved.
    moving: Summary,
}

/// Times of each way, and of saying what has moved. Each way has a step of its own in every frame, so that all maps are
/// stale, and another one is the first each time, so that drift hits all alike.
fn measure(arguments: &Arguments, gpu: &Gpu, plaza: &mut Plaza, sides: &mut BothSides) -> anyhow::Result<Measured> {
    let timer = Timer::new(gpu);
    println!("device times {}", timer.clock());
    let mut table = Table::new(&["frame", "casters", "cull", "bin", "rasterise", "this, ms", "kept", "still", "cube"]);
    let mut samples = [const { Vec::new() }; Way::ALL.len()];
    let mut recording = [const { Vec::new() }; Way::ALL.len()];
    let (mut step, mut moving) = (0, Vec::new());
    for frame in 0..WARM_UP + arguments.frames {
        let mut times = [(Duration::ZERO, Duration::ZERO); Way::ALL.len()];
        for turn in 0..times.len() {
            let number = (frame as usize + turn) % times.len();
            let way = Way::ALL[number];
            step += 1;
            plaza.go(STEP * step as f32);
            let started = Instant::now();
            sides.move_for(gpu, plaza, way)?;
            if way == Way::All {
                moving.push(started.elapsed());
            }
            let mut recorded = Ok(());
            let mut alone = Duration::ZERO;
            times[number] = timer.once(|encoder| {
                let started = Instant::now();
                recorded = sides.record(gpu, plaza, encoder, way);
                alone = started.elapsed();
            });
            recorded?;
            if frame >= WARM_UP {
                recording[number].push(alone);
            }
        }
        if frame >= WARM_UP {
            samples.iter_mut().zip(times).for_each(|(all, time): (&mut Vec<_>, _)| all.push(time));
            table.row(cells((frame - WARM_UP).to_string(), times.map(|(device, _)| device)));
        }
    }
    print!("{table}");
    let times = samples.map(|samples| {
        let (device, host) = samples.into_iter().unzip();
        Times { gpu: Summary::new(device), cpu: Summary::new(host) }
    });
    Ok(Measured { times, recording: recording.map(Summary::new), moving: Summary::new(moving) })
}

/// A row: the shares of the stages, and times in milliseconds. Ways are in the order of [`Way::ALL`].
fn cells(name: String, [casters, cull, bin, all, kept, still, cube]: [Duration; Way::ALL.len()]) -> Vec<String> {
    let share = |to: Duration, from: Duration| {
        format!("{:.0} %", 100.0 * to.saturating_sub(from).as_secs_f64() / all.as_secs_f64().max(1e-9))
    };
    let shares = [share(casters, Duration::ZERO), share(cull, casters), share(bin, cull), share(all, bin)];
    let times = [all, kept, still, cube].map(|time| format!("{:.3}", milliseconds(time)));
    [name].into_iter().chain(shares).chain(times).collect()
}

fn print_medians(times: &[Times; Way::ALL.len()], recording: &[Summary; Way::ALL.len()]) {
    let mut table = Table::new(&["median", "GPU, ms", "recording, us", "with finish, us"]);
    for ((way, time), recording) in Way::ALL.iter().zip(times).zip(recording) {
        let host = [recording, &time.cpu].map(|time| format!("{:.0}", microseconds(time.median)));
        let figures = [format!("{:.3}", milliseconds(time.gpu.median))].into_iter().chain(host);
        table.row([format!("{way:?}").to_lowercase()].into_iter().chain(figures));
    }
    print!("{table}");
    let [.., all, _, _, cube] = times.map(|time| time.gpu.median.as_secs_f64());
    println!("this / cube  {:.2}", all / cube);
}

fn figures(arguments: &Arguments, gpu: &Gpu, sides: &BothSides, times: &[Times; Way::ALL.len()]) -> serde_json::Value {
    let [.., all, kept, still, cube] = times;
    serde_json::json!({
        "lights": arguments.lights,
        "instances": arguments.instances,
        "triangles": sides.triangles(),
        "adapter": gpu.name(),
        "frame_ms_median": milliseconds(all.gpu.median),
        "record_cpu_us_median": microseconds(all.cpu.median),
        "cube_frame_ms_median": milliseconds(cube.gpu.median),
        "cube_record_cpu_us_median": microseconds(cube.cpu.median),
        "kept_frame_ms_median": milliseconds(kept.gpu.median),
        "still_frame_ms_median": milliseconds(still.gpu.median),
        "still_record_cpu_us_median": microseconds(still.cpu.median),
    })
}

fn microseconds(time: Duration) -> f64 {
    1e6 * time.as_secs_f64()
}

/// Renders frames of the first second.
fn pictures(arguments: &Arguments, gpu: &Gpu, plaza: &mut Plaza) -> anyhow::Result<()> {
    for number in 0..arguments.pictures {
        plaza.go(number as f32 / arguments.pictures as f32);
        let mut casters = Casters::new(&gpu.device)?;
        dual_paraboloid::compare::fill(&mut casters, gpu, &plaza.scene, Sides::Auto)?;
        let (shadows, ids) = sides::set_up(gpu, plaza, &mut casters, arguments.resolution, false)?;
        let light = |(&id, &shadow): (&LightId, _)| (id, camera::Light { shadow, intensity: INTENSITY });
        let lights: Vec<_> = ids.iter().zip(&plaza.lights).map(light).collect();
        let picture = camera::take(
            gpu,
            &camera::Shot {
                model: &model::Model::new(gpu, &plaza.scene)?,
                shadows: &shadows,
                casters: &casters,
                lights: &lights,
                camera: plaza.camera(),
                near: 0.1,
                view: camera::View::Lit,
                size: SIZE,
            },
        )?;
        let path = arguments.output.join(format!("frame-{number:03}.png"));
        make_folder(&path)?;
        picture.save(&path).with_context(|| format!("writing {}", path.display()))?;
        println!("picture      {}", path.display());
    }
    Ok(())
}

fn make_folder(file: &std::path::Path) -> anyhow::Result<()> {
    let folder = file.parent().unwrap_or(std::path::Path::new(""));
    std::fs::create_dir_all(folder).with_context(|| format!("making the folder {}", folder.display()))
}
