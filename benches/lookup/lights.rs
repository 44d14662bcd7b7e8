//! What asking the triangles costs, with one light and with several: the passes' times beside the hardware's comparison.

use crate::Arguments;
use dual_paraboloid::PointLight;
use dual_paraboloid::compare::cost::geometric_mean;
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::lookup_cost::{LightsBench, LightsTime, PassStage};
use dual_paraboloid::compare::measure::{choose_camera, choose_light, find_scene, select_scenes};
use dual_paraboloid::compare::shot::Shot;
use dual_paraboloid::compare::text::Table;
use dual_paraboloid::compare::timing::{Rounds, Timer, milliseconds};
use glam::{Quat, Vec3};
use serde::Serialize;
use serde_json::json;
use std::f32::consts::TAU;

const LEGEND: &str = "\
Medians of a pass over the whole screen, in microseconds, with all passes interleaved; *over nothing* is the time less that \
of the pass that only reads the position and the normal; ratios are to the hardware's comparison of 2x2 texels in cubes with \
the texels of the first R, of the whole time. Cubes of the same walk have as many texels as the pair. *Mixed* is the share of all \
pixels and lights for which the four texels around the pixel's middle disagree.";

/// Beside the first light the others stand around it, so far of its range away.
const APART: f32 = 0.02;

/// A scene's times with so many lights.
#[derive(Serialize)]
struct Measured {
    scene: String,
    size: (u32, u32),
    lights: u32,
    /// By texels across each map of the pair.
    mixed: Vec<(u32, f64)>,
    times: Vec<LightsTime>,
}

/// Measures, prints and writes what was asked for.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let names = select_scenes(&arguments.scenes)?;
    let gpu = Gpu::new(wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS)?;
    let timer = Timer::new(&gpu);
    let pairs = [arguments.resolution, (arguments.resolution / 4).max(1)];
    let mut all = Vec::new();
    for name in &names {
        eprintln!("{name}");
        // The other methods know no holes.
        let scene = find_scene(name)?.without_holes();
        let (light, choice) = choose_light(&scene, None, None);
        let shots = Shot::take_sizes(&scene, &choose_camera(&scene, &light, choice), &arguments.screens);
        for shot in &shots {
            for &count in arguments.lights.iter().filter(|count| **count > 0) {
                let bench = LightsBench::new(&gpu, &scene, &around(&light, count), shot, &pairs)?;
                let rounds = Rounds { warm_up: 3, measured: arguments.runs as usize };
                all.push(Measured {
                    scene: scene.name.clone(),
                    size: (shot.width, shot.height),
                    lights: count,
                    mixed: bench.mixed(),
                    times: bench.times(&timer, rounds, arguments.repeat),
                });
            }
        }
    }
    let mut text = format!(
        "# Cost of asking the triangles\n\n{}; times: {}; {} runs of {} passes.\n\n{LEGEND}\n",
        gpu.name(),
        timer.clock(),
        arguments.runs,
        arguments.repeat
    );
    for stage in PassStage::ALL {
        text += &format!("\n## {}\n\n{}", stage.name(), table(&all, stage));
    }
    println!("{text}");
    let json = json!({ "adapter": gpu.name(), "clock": timer.clock(), "pairs": pairs, "scenes": all });
    crate::write(arguments, text, &json)
}

/// So many lights: this one, and others in a circle around it.
fn around(light: &PointLight, count: u32) -> Vec<PointLight> {
    let place = |number: u32| {
        let turn = Quat::from_rotation_y(TAU * number as f32 / count as f32);
        let aside = if number == 0 { Vec3::ZERO } else { turn * Vec3::X * (APART * light.range) };
        PointLight { position: light.position + aside, ..*light }
    };
    (0..count).map(place).collect()
}

/// A line for each question, a column for each scene and number of lights; then the geometric mean and the worst ratio.
fn table(all: &[Measured], stage: PassStage) -> Table {
    let mut head = vec!["lookup".to_owned(), "R".to_owned()];
    for of in all {
        let plural = if of.lights == 1 { "light" } else { "lights" };
        head.push(format!("{}, {}x{}, {} {plural}", of.scene, of.size.0, of.size.1, of.lights));
    }
    let mut counts: Vec<u32> = all.iter().map(|of| of.lights).collect();
    counts.sort_unstable();
    counts.dedup();
    head.extend(counts.iter().flat_map(|count| [format!("{count}: mean ratio"), "worst".to_owned()]));
    let mut table = Table::new(&head.iter().map(String::as_str).collect::<Vec<_>>());
    let Some(first) = all.first() else { return table };
    for row in first.times.iter().filter(|time| time.stage == stage) {
        let of_scene = |of: &Measured| {
            let same = |time: &&LightsTime| (time.question, time.stage) == (row.question, stage);
            of.times.iter().find(same).copied()
        };
        let mut cells = vec![row.question.name().to_owned(), row.pair.map_or_else(dash, |pair| pair.to_string())];
        cells.extend(all.iter().map(|of| of_scene(of).map_or_else(dash, |time| time_text(&time))));
        for &count in &counts {
            let ratios: Vec<f64> =
                all.iter().filter(|of| of.lights == count).filter_map(|of| Some(of_scene(of)?.to_cube)).collect();
            let worst = ratios.iter().copied().reduce(f64::max);
            cells.extend([geometric_mean(&ratios), worst].map(|ratio| ratio.map_or_else(dash, ratio_text)));
        }
        table.row(cells);
    }
    for (pair, _) in &first.mixed {
        let share = |of: &Measured| of.mixed.iter().find(|mixed| mixed.0 == *pair).map(|mixed| mixed.1);
        let mut cells = vec!["mixed".to_owned(), pair.to_string()];
        cells.extend(all.iter().map(|of| share(of).map_or_else(dash, |share| format!("{:.1} %", 100.0 * share))));
        cells.extend(counts.iter().flat_map(|_| [dash(), dash()]));
        table.row(cells);
    }
    table
}

/// The pass, what it takes more than the one that asks nothing, and the ratio.
fn time_text(time: &LightsTime) -> String {
    let micros = |milliseconds: f64| format!("{:.1}", 1000.0 * milliseconds);
    let (whole, over) = (micros(milliseconds(time.time.median)), micros(time.ms_over_nothing));
    format!("{whole} (+{over}, {})", ratio_text(time.to_cube))
}

fn ratio_text(ratio: f64) -> String {
    format!("{ratio:.2}")
}

fn dash() -> String {
    "-".to_owned()
}
