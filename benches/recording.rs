//! What recording costs the CPU: `cargo bench --bench recording`.
//!
//! Timed is [`PointShadows::record`] with `CommandEncoder::finish`, where wgpu translates the commands, and the first
//! alone beside it. Making the encoder, submitting and waiting aren't: the renderer does them anyway. Times of
//! several lights are those of one of them.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use dual_paraboloid::compare::fill;
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::procedural::shapes;
use dual_paraboloid::compare::scene::{Scene, SceneInstance};
use dual_paraboloid::{
    Casters, InstanceId, LightId, PointLight, PointShadows, PointShadowsDescriptor, RecordOptions, Sides,
};
use glam::{Affine3A, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Half the width of the room that instances and lights are in.
const ROOM: f32 = 50.0;

/// What is timed.
#[derive(Clone, Copy)]
enum Timed {
    Record,
    RecordAndFinish,
    /// With no map made.
    RecordCasters,
}

/// A renderer's frames.
struct Frames {
    gpu: Gpu,
    casters: Casters,
    instances: Vec<(InstanceId, Vec3)>,
    shadows: PointShadows,
    lights: Vec<(LightId, PointLight)>,
    random: Pcg64,
}

impl Frames {
    /// With so many tetrahedra and lights, all recorded before.
    fn new(instances: usize, lights: usize) -> Self {
        let gpu = Gpu::new(wgpu::Features::empty()).unwrap_or_else(|error| panic!("{error}"));
        let mut random = Pcg64::seed_from_u64(1);
        let mut casters = Casters::new(&gpu.device).unwrap();
        let scene = tetrahedra(instances, &mut random);
        let instances = fill(&mut casters, &gpu, &scene, Sides::Auto).expect("the device has room");
        let places = scene.instances.iter().map(|instance| instance.transform.translation.into());
        let instances = instances.into_iter().zip(places).collect();
        let descriptor = PointShadowsDescriptor { capacity: lights as u32, resolution: 64, ..Default::default() };
        let mut shadows = PointShadows::new(&gpu.device, &descriptor).expect("the descriptor is valid");
        let mut add = |light| (shadows.add(light).expect("there is a place for each light"), light);
        // They reach few of the instances, so that the device keeps up.
        let place = |random: &mut Pcg64| PointLight { position: point(random), range: 5.0, ..Default::default() };
        let lights = (0..lights).map(|_| add(place(&mut random))).collect();
        let mut frames = Self { gpu, casters, instances, shadows, lights, random };
        for _ in 0..3 {
            frames.touch_lights();
            frames.frame(Timed::Record);
        }
        frames
    }

    /// Makes all maps stale.
    fn touch_lights(&mut self) {
        for (id, light) in &mut self.lights {
            light.near = if light.near < 0.01 { 0.01 } else { 0.005 };
            self.shadows.set(*id, *light).expect("the light is still there");
        }
    }

    /// Moves all instances a little, and returns how long it takes to say so.
    fn move_all(&mut self) -> Duration {
        let mut near = |at: &Vec3| Affine3A::from_translation(*at + 0.001 * point(&mut self.random));
        let transforms: Vec<Affine3A> = self.instances.iter().map(|(_, at)| near(at)).collect();
        let started = Instant::now();
        for ((instance, _), transform) in self.instances.iter().zip(transforms) {
            self.casters.set_transform(*instance, transform).expect("the instance is still there");
        }
        started.elapsed()
    }

    /// Records a frame, and waits until the device has done it.
    fn frame(&mut self, timed: Timed) -> Duration {
        let Gpu { device, queue, .. } = &self.gpu;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let started = Instant::now();
        let most = matches!(timed, Timed::RecordCasters).then_some(0);
        let options = RecordOptions { most, ..Default::default() };
        let made = self.shadows.record_with(device, queue, &mut encoder, &mut self.casters, options);
        black_box(made.expect("the device is there"));
        let recorded = started.elapsed();
        let commands = encoder.finish();
        let finished = started.elapsed();
        queue.submit([commands]);
        self.gpu.wait();
        match timed {
            Timed::Record => recorded,
            Timed::RecordAndFinish | Timed::RecordCasters => finished,
        }
    }

    /// Time of frames in which all lights are stale, for one light.
    fn stale(&mut self, timed: Timed, frames: u64) -> Duration {
        let frame = |_| {
            self.touch_lights();
            self.frame(timed)
        };
        (0..frames).map(frame).sum::<Duration>() / self.lights.len() as u32
    }
}

fn point(random: &mut Pcg64) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| random.random_range(-ROOM..ROOM)))
}

fn tetrahedra(count: usize, random: &mut Pcg64) -> Scene {
    let instance = |at| SceneInstance { mesh: 0, transform: Affine3A::from_translation(at) };
    Scene {
        meshes: vec![shapes::tetrahedron(0.2)],
        instances: (0..count).map(|_| instance(point(random))).collect(),
        ..Scene::default()
    }
}

fn recording(criterion: &mut Criterion) {
    let names = [("record", Timed::Record), ("record and finish", Timed::RecordAndFinish)];
    let mut group = criterion.benchmark_group("one stale light, by instances");
    for instances in [10, 1_000, 100_000] {
        let mut frames = Frames::new(instances, 1);
        for (name, timed) in names {
            let id = BenchmarkId::new(name, instances);
            group.bench_function(id, |bencher| bencher.iter_custom(|count| frames.stale(timed, count)));
        }
    }
    group.finish();
    let mut group = criterion.benchmark_group("all lights stale, time of one, by lights");
    for lights in [1, 4, 16, 64] {
        let mut frames = Frames::new(1_000, lights);
        for (name, timed) in names {
            let id = BenchmarkId::new(name, lights);
            group.bench_function(id, |bencher| bencher.iter_custom(|count| frames.stale(timed, count)));
        }
    }
    group.finish();
    let mut group = criterion.benchmark_group("nothing stale, by instances");
    for instances in [10, 100_000] {
        let mut frames = Frames::new(instances, 16);
        let frame = |frames: &mut Frames| frames.frame(Timed::RecordAndFinish);
        group.bench_function(BenchmarkId::new("record and finish", instances), |bencher| {
            bencher.iter_custom(|count| (0..count).map(|_| frame(&mut frames)).sum());
        });
    }
    group.finish();
}

/// Frames in which everything moves: saying so, bringing the casters up to date, and making all maps too.
fn moving(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("everything moved, 64 lights, by instances");
    for instances in [100, 1_000, 10_000] {
        let mut frames = Frames::new(instances, 64);
        group.bench_function(BenchmarkId::new("set transforms", instances), |bencher| {
            bencher.iter_custom(|count| {
                let frame = |_| {
                    let time = frames.move_all();
                    frames.frame(Timed::RecordCasters);
                    time
                };
                (0..count).map(frame).sum()
            });
        });
        for (name, timed) in [("record casters", Timed::RecordCasters), ("record all", Timed::RecordAndFinish)] {
            group.bench_function(BenchmarkId::new(name, instances), |bencher| {
                bencher.iter_custom(|count| {
                    let frame = |_| {
                        frames.move_all();
                        frames.frame(timed)
                    };
                    (0..count).map(frame).sum()
                });
            });
        }
    }
    group.finish();
}

/// Little of a frame is timed, so little time goes a long way.
fn config() -> Criterion {
    let times = [100, 300].map(Duration::from_millis);
    Criterion::default().sample_size(20).warm_up_time(times[0]).measurement_time(times[1])
}

criterion_group! {
    name = benches;
    config = config();
    targets = recording, moving
}
criterion_main!(benches);
