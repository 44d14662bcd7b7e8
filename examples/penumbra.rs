//! Draws the shadow of a straight edge in the light of a sphere, against ray casting: profiles at three heights of the
//! edge, on a hemisphere's axis and at its rim.

use anyhow::anyhow;
use clap::Parser;
use dual_paraboloid::compare::area_light::shares_of_sphere;
use dual_paraboloid::compare::error_figures::Receiver;
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::measure::{Made, Truth, light_for};
use dual_paraboloid::compare::procedural::shapes::quad;
use dual_paraboloid::compare::scene::{Scene, SceneInstance};
use dual_paraboloid::compare::text::one_line;
use dual_paraboloid::{Filter, PointLight, PointShadowsDescriptor};
use glam::{Affine3A, Quat, Vec3};
use plotters::prelude::*;
use std::f32::consts::FRAC_PI_2;
use std::path::PathBuf;
use std::process::ExitCode;

/// Draw profiles of penumbras as SVG.
#[derive(Parser)]
#[command(name = "penumbra")]
struct Arguments {
    /// Where to write the picture
    #[arg(short, long, value_name = "OUT.svg", default_value = "out/penumbra.svg")]
    output: PathBuf,
    /// Texels across each hemisphere's map
    #[arg(long, value_name = "N", default_value_t = 1024)]
    resolution: u32,
}

/// Distance of the wall that the shadow falls on.
const WALL: f32 = 4.0;
/// Radius of the light.
const RADIUS: f32 = 0.1;
/// Distances of the edge.
const EDGES: [f32; 3] = [1.0, 2.0, 3.5];
/// Points of a profile, and rays to the sphere from each.
const POINTS: usize = 240;
const RAYS: usize = 4096;

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("penumbra: {}", one_line(error));
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let gpu = Gpu::new(wgpu::Features::empty())?;
    let profiles = EDGES.map(|edge| profile(&gpu, edge, arguments.resolution));
    let profiles = profiles.into_iter().collect::<Result<Vec<_>, _>>()?;
    if let Some(folder) = arguments.output.parent() {
        std::fs::create_dir_all(folder).map_err(|error| anyhow!("can't make {}: {error}", folder.display()))?;
    }
    draw(&arguments.output, &profiles)
        .map_err(|error| anyhow!("can't draw {}: {error}", arguments.output.display()))?;
    println!("picture      {}", arguments.output.display());
    Ok(())
}

/// Shares of the light along a line across an edge's shadow, by the distance from its middle.
struct Profile {
    edge: f32,
    distances: Vec<f32>,
    truth: Vec<f64>,
    /// On the axis and at the rim.
    soft: [Vec<f32>; 2],
    unfiltered: Vec<f32>,
}

fn profile(gpu: &Gpu, edge: f32, resolution: u32) -> Result<Profile, dual_paraboloid::Error> {
    let wall = quad(Vec3::new(-6.0, -6.0, WALL), Vec3::X * 12.0, Vec3::Y * 12.0);
    let sheet = quad(Vec3::new(0.0, -6.0, edge), Vec3::X * 6.0, Vec3::Y * 12.0);
    let instances = (0..2).map(|mesh| SceneInstance { mesh, transform: Affine3A::IDENTITY }).collect();
    let scene = Scene { meshes: vec![wall, sheet], instances, ..Scene::default() };
    let light = PointLight { filter: Filter::soft(RADIUS), ..light_for(&scene, Vec3::ZERO) };
    // Twice as wide as the penumbra.
    let reach = 2.0 * RADIUS * (WALL / edge - 1.0);
    let distances: Vec<f32> = (0..POINTS).map(|k| reach * (2.0 * k as f32 / (POINTS - 1) as f32 - 1.0)).collect();
    let at = |x: &f32| (Vec3::new(*x, 0.03, WALL), Vec3::Z);
    let inputs: Vec<(Vec3, Vec3)> = distances.iter().map(at).collect();
    let receiver = |&(position, normal): &(Vec3, Vec3)| Receiver { position, normal, triangle: 0, rounding: 1e-6 };
    let receivers: Vec<Receiver> = inputs.iter().map(receiver).collect();
    let Truth { view, reference, .. } = Truth::new(&scene, &light, 0, 1);
    let descriptor = PointShadowsDescriptor { resolution, capacity: 1, ..Default::default() };
    let made = |orientation| Made::new(gpu, &scene, PointLight { orientation, ..light }, &descriptor);
    let (axis, rim) = (made(Quat::IDENTITY)?, made(Quat::from_rotation_y(FRAC_PI_2))?);
    Ok(Profile {
        edge,
        truth: shares_of_sphere(&receivers, &reference, &view, RADIUS.into(), RAYS),
        soft: [&axis, &rim].map(|made| gpu.filtered_values(&made.shadows, &made.casters, made.light, &inputs)),
        unfiltered: gpu.shadow_values(&axis.shadows, &axis.casters, axis.light, &inputs),
        distances,
    })
}

fn draw(path: &std::path::Path, profiles: &[Profile]) -> Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::new(path, (960, 300)).into_drawing_area();
    root.fill(&WHITE)?;
    for (area, profile) in root.split_evenly((1, profiles.len())).iter().zip(profiles) {
        let reach = profile.distances.last().copied().unwrap_or(1.0);
        let title = format!("edge at {} of {WALL}", profile.edge);
        let mut chart = ChartBuilder::on(area)
            .caption(title, ("sans-serif", 15))
            .margin(8)
            .x_label_area_size(32)
            .y_label_area_size(32)
            .build_cartesian_2d(-reach..reach, -0.02f32..1.02)?;
        chart.configure_mesh().x_labels(5).x_desc("distance from the edge's shadow").light_line_style(WHITE).draw()?;
        let truth: Vec<f32> = profile.truth.iter().map(|share| *share as f32).collect();
        let lines = [
            ("rays", &truth, BLACK.stroke_width(3)),
            ("2x2", &profile.unfiltered, RGBColor(170, 170, 170).stroke_width(1)),
            ("soft, axis", &profile.soft[0], RED.stroke_width(1)),
            ("soft, rim", &profile.soft[1], BLUE.stroke_width(1)),
        ];
        for (name, values, style) in lines {
            let points = profile.distances.iter().copied().zip(values.iter().copied());
            chart
                .draw_series(LineSeries::new(points, style))?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 14, y)], style));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerLeft)
            .background_style(WHITE.mix(0.8))
            .draw()?;
    }
    root.present()?;
    Ok(())
}
