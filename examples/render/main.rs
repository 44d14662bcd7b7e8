//! Renders a scene with point-light shadows to a PNG: what a renderer does with the library, from casters to the
//! lighting pass. See README.md beside this file.

mod arguments;
mod camera;
mod error;
mod filter;
mod lighting;
mod map;
mod model;
mod versus;

use anyhow::{anyhow, ensure};
use arguments::Arguments;
use camera::{Light, View};
use clap::Parser;
use dual_paraboloid::compare::gpu::{Gpu, Statistics};
use dual_paraboloid::compare::procedural::{hall, hall_camera, shapes};
use dual_paraboloid::compare::scene::{Camera, Material, Scene, SceneInstance, SceneMesh};
use dual_paraboloid::compare::text::one_line;
use dual_paraboloid::{Casters, LightId, PointLight, PointShadows, PointShadowsDescriptor, Sides};
use glam::{Affine3A, Quat, Vec3};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Time to spend on measuring how long the maps take.
const MEASURING: Duration = Duration::from_millis(800);
/// Size of a lamp in the picture, as a share of its distance from the camera.
const LAMP: f32 = 0.005;

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("render: {}", one_line(error));
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let start = Instant::now();
    let mut scene = match &arguments.scene {
        Some(path) => Scene::load(path)?,
        None => hall(),
    };
    let gpu = Gpu::new(wgpu::Features::empty())?;
    println!("adapter      {}", gpu.name());
    println!(
        "scene        {}: {} triangles in, {} instances of {} meshes",
        scene.name,
        grouped(scene.triangle_count()),
        grouped(scene.instances.len()),
        grouped(scene.meshes.len())
    );
    let (lights, by) = lighting::choose(arguments, &scene);
    for light in &lights {
        let PointLight { position, range, .. } = light.shadow;
        println!("light        at {}, range {range:.4} ({by})", coordinates(position));
    }
    let camera = choose_camera(arguments, &scene, lights[0].shadow.position)?;

    let mut casters = Casters::new(&gpu.device)?;
    dual_paraboloid::compare::fill(&mut casters, &gpu, &scene, Sides::Auto)?;
    let mut shadows = PointShadows::new(
        &gpu.device,
        &PointShadowsDescriptor {
            resolution: arguments.resolution,
            capacity: lights.len() as u32,
            ..Default::default()
        },
    )?;
    let lights: Vec<(LightId, Light)> = lights
        .into_iter()
        .map(|light| Ok((shadows.add(light.shadow)?, light)))
        .collect::<Result<_, dual_paraboloid::Error>>()?;
    make_maps(&gpu, &mut shadows, &mut casters, &lights)?;
    print_statistics(&gpu.statistics(&shadows), arguments.resolution);
    if let Some(path) = &arguments.map {
        let (id, light) = &lights[0];
        let depth = gpu.read_map(&shadows, *id);
        let picture = map::picture(&depth, arguments.resolution, shadows.half_width(), light.shadow.near);
        write(path, &picture)?;
        println!("map          {}", path.display());
    }

    if arguments.view == View::Versus {
        let picture = versus::picture(&gpu, arguments, &scene, &camera, &lights[0].1.shadow)?;
        return finish(arguments, &picture, start);
    }
    if arguments.view == View::Error {
        let (id, light) = &lights[0];
        let picture = error::picture(&gpu, arguments, &scene, &camera, (&shadows, &casters), (*id, &light.shadow));
        return finish(arguments, &picture, start);
    }
    show_lamps(&mut scene, &lights, camera.eye);
    let (low, high) = scene.bounds().unwrap_or_default();
    let picture = camera::take(
        &gpu,
        &camera::Shot {
            model: &model::Model::new(&gpu, &scene)?,
            shadows: &shadows,
            casters: &casters,
            lights: &lights,
            camera,
            near: 1e-4 * (high - low).length(),
            view: arguments.view,
            size: arguments.size,
        },
    )?;
    finish(arguments, &picture, start)
}

fn finish(arguments: &Arguments, picture: &image::RgbImage, start: Instant) -> anyhow::Result<()> {
    write(&arguments.output, picture)?;
    println!("total        {:.2} s", start.elapsed().as_secs_f32());
    println!("picture      {}", arguments.output.display());
    Ok(())
}

fn choose_camera(arguments: &Arguments, scene: &Scene, light: Vec3) -> anyhow::Result<Camera> {
    let mut camera = match arguments.scene {
        Some(_) => scene.suggest_camera(light),
        None => hall_camera(),
    };
    camera.eye = arguments.camera.unwrap_or(camera.eye);
    camera.target = arguments.look_at.unwrap_or(camera.target);
    camera.fov_y = arguments.fov.map_or(camera.fov_y, f32::to_radians);
    let ahead = (camera.target - camera.eye).try_normalize();
    ensure!(ahead.is_some(), "the camera at {} looks at itself: give --look-at another point", coordinates(camera.eye));
    println!(
        "camera       at {}, looking at {}, {:.0} degrees",
        coordinates(camera.eye),
        coordinates(camera.target),
        camera.fov_y.to_degrees()
    );
    Ok(camera)
}

/// Records all maps: once as a first frame would, and then again and again to see how long that takes.
fn make_maps(
    gpu: &Gpu,
    shadows: &mut PointShadows,
    casters: &mut Casters,
    lights: &[(LightId, Light)],
) -> anyhow::Result<()> {
    let mut record = |shadows: &mut PointShadows| {
        let start = Instant::now();
        gpu.submit(|encoder| shadows.record(&gpu.device, &gpu.queue, encoder, casters))?;
        gpu.wait();
        anyhow::Ok(start.elapsed())
    };
    let first = record(shadows)?;
    let started = Instant::now();
    let mut again = Vec::new();
    // An even number of times: every other time the lights are as they should be.
    while again.len() < 2 || again.len() % 2 == 1 || (again.len() < 20 && started.elapsed() < MEASURING) {
        for (id, light) in lights {
            // A light is only rendered again if something about it is new.
            let near = if again.len() % 2 == 0 { 1.000_001 } else { 1.0 };
            shadows.set(*id, PointLight { near: light.shadow.near * near, ..light.shadow })?;
        }
        again.push(record(shadows)?);
    }
    again.sort();
    println!(
        "maps made    in {:.1} ms, and at first, with moving the casters to the GPU, in {:.1} ms",
        milliseconds(again[again.len() / 2]),
        milliseconds(first)
    );
    println!("             (all lights, recording to idle; the median of {} times)", again.len());
    Ok(())
}

fn print_statistics(counted: &Statistics, resolution: u32) {
    println!("resolution   2 x {resolution} x {resolution} texels a light");
    println!("large        {} triangles, counted in each hemisphere", grouped(counted.large as usize));
}

/// Puts a small bright ball where each lamp is. It casts no shadow, since the casters are there already.
fn show_lamps(scene: &mut Scene, lights: &[(LightId, Light)], eye: Vec3) {
    // In files it is often the lighting of the whole room, baked, and there would be nothing left to see of shadows.
    scene.materials.iter_mut().for_each(|material| material.emissive = [0.0; 3]);
    for (_, light) in lights {
        let (position, color) = (light.shadow.position, light.intensity);
        scene.materials.push(Material {
            base_color: [0.0, 0.0, 0.0, 1.0],
            emissive: (color * (8.0 / color.max_element().max(f32::MIN_POSITIVE))).to_array(),
            ..Material::default()
        });
        scene.meshes.push(SceneMesh { material: scene.materials.len() - 1, ..shapes::icosphere(1.0, 2) });
        let radius = LAMP * position.distance(eye);
        scene.instances.push(SceneInstance {
            mesh: scene.meshes.len() - 1,
            transform: Affine3A::from_scale_rotation_translation(Vec3::splat(radius), Quat::IDENTITY, position),
        });
    }
}

/// Writes a PNG, making the folders it lies in.
fn write(path: &Path, picture: &image::RgbImage) -> anyhow::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder {
        std::fs::create_dir_all(folder)
            .map_err(|error| anyhow!("can't make the folder {}: {error}", folder.display()))?;
    }
    picture
        .save_with_format(path, image::ImageFormat::Png)
        .map_err(|error| anyhow!("can't write {}: {error}", path.display()))
}

fn milliseconds(time: Duration) -> f32 {
    1000.0 * time.as_secs_f32()
}

fn coordinates(point: Vec3) -> String {
    format!("{:.3},{:.3},{:.3}", point.x, point.y, point.z)
}

/// A number with commas between its thousands.
fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let from_the_end = digits.as_bytes().rchunks(3).rev();
    let groups: Vec<_> = from_the_end.map(String::from_utf8_lossy).collect();
    groups.join(",")
}
