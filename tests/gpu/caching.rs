//! What is kept from one recording to the next is what would be made anew, bit for bit.

use crate::common::{box_inside, gpu, soup};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::{
    CasterMesh, Casters, Coverage, Indices, InstanceId, LightId, MeshId, PointLight, PointShadows,
    PointShadowsDescriptor, RecordOptions, Sides,
};
use glam::{Affine3A, EulerRot, Quat, Vec3};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

const CAPACITY: usize = 5;
const RESOLUTION: u32 = 32;

/// Something that happens to casters and lights. Numbers choose among those that there are.
#[derive(Debug, Clone)]
enum Step {
    AddInstance {
        mesh: usize,
        transform: Affine3A,
        moving: bool,
    },
    Move {
        instance: usize,
        transform: Affine3A,
    },
    SetMoving {
        instance: usize,
        moving: bool,
    },
    RemoveInstance {
        instance: usize,
    },
    AddLight(PointLight),
    SetLight {
        light: usize,
        to: PointLight,
    },
    SetPriority {
        light: usize,
        priority: f32,
    },
    RemoveLight {
        light: usize,
    },
    Record {
        most: u32,
    },
    /// Records to encoders that are dropped, of the subjects that `whose` has the bits of.
    ThrowAway {
        most: u32,
        whose: u32,
    },
}

fn point(size: f32) -> impl Strategy<Value = Vec3> {
    [-size..size, -size..size, -size..size].prop_map(Vec3::from)
}

fn rotation() -> impl Strategy<Value = Quat> {
    point(3.0).prop_map(|angles| Quat::from_euler(EulerRot::XYZ, angles.x, angles.y, angles.z))
}

fn transform() -> impl Strategy<Value = Affine3A> {
    let scale = prop_oneof![Just(Vec3::ONE), Just(Vec3::new(-1.0, 1.0, 1.0)), Just(Vec3::new(0.3, 1.5, 1.0))];
    (scale, rotation(), point(6.0)).prop_map(|(s, r, t)| Affine3A::from_scale_rotation_translation(s, r, t))
}

fn light() -> impl Strategy<Value = PointLight> {
    (point(4.0), rotation(), 1.0f32..6.0, any::<bool>()).prop_map(|(position, orientation, range, full)| PointLight {
        position,
        orientation,
        range,
        coverage: if full { Coverage::Full } else { Coverage::Hemisphere },
        ..Default::default()
    })
}

fn step() -> impl Strategy<Value = Step> {
    let number = || 0usize..1000;
    prop_oneof![
        2 => (number(), transform(), any::<bool>())
            .prop_map(|(mesh, transform, moving)| Step::AddInstance { mesh, transform, moving }),
        4 => (number(), transform()).prop_map(|(instance, transform)| Step::Move { instance, transform }),
        1 => (number(), any::<bool>()).prop_map(|(instance, moving)| Step::SetMoving { instance, moving }),
        1 => number().prop_map(|instance| Step::RemoveInstance { instance }),
        1 => light().prop_map(Step::AddLight),
        1 => (number(), light()).prop_map(|(light, to)| Step::SetLight { light, to }),
        1 => (number(), 0.01f32..100.0).prop_map(|(light, priority)| Step::SetPriority { light, priority }),
        1 => number().prop_map(|light| Step::RemoveLight { light }),
        6 => (0u32..4).prop_map(|most| Step::Record { most }),
        1 => (0u32..4, 1u32..16).prop_map(|(most, whose)| Step::ThrowAway { most, whose }),
    ]
}

/// A tetrahedron, a large plate, and a box that lights may be in.
fn add_meshes(casters: &mut Casters) -> Vec<MeshId> {
    let corners = [Vec3::ONE, Vec3::new(1.0, -1.0, -1.0), Vec3::new(-1.0, 1.0, -1.0), Vec3::new(-1.0, -1.0, 1.0)];
    let tetrahedron: Vec<[Vec3; 3]> =
        [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]].iter().map(|face| face.map(|k| 0.5 * corners[k])).collect();
    let plate = vec![[Vec3::new(-3.0, 0.0, -3.0), Vec3::new(3.0, 0.0, -3.0), Vec3::new(0.0, 0.0, 4.0)]];
    let shapes = [tetrahedron, plate, box_inside(Vec3::splat(-2.0), Vec3::splat(2.0))];
    let add = |triangles: &Vec<[Vec3; 3]>| {
        let positions: Vec<[f32; 3]> = triangles.iter().flatten().map(|p| p.to_array()).collect();
        let indices: Vec<u32> = (0..positions.len() as u32).collect();
        let mesh = CasterMesh {
            positions: &positions,
            indices: Indices::U32(&indices),
            sides: Sides::Auto,
            ..Default::default()
        };
        casters.add_mesh(&mesh).unwrap()
    };
    shapes.iter().map(add).collect()
}

fn shadows(keep_static: bool) -> PointShadows {
    let descriptor =
        PointShadowsDescriptor { capacity: CAPACITY as u32, resolution: RESOLUTION, keep_static, ..Default::default() };
    PointShadows::new(&gpu().device, &descriptor).unwrap()
}

fn record(shadows: &mut PointShadows, casters: &mut Casters, most: Option<u32>) -> u32 {
    let made = gpu().submit(|encoder| {
        let options = RecordOptions { most, draw: None };
        shadows.record_with(&gpu().device, &gpu().queue, encoder, casters, options)
    });
    gpu().wait();
    made.unwrap()
}

/// The bits of a light's map, of the hemispheres that the light has: what is behind one that has but one stays as it was.
fn bits(shadows: &PointShadows, id: LightId, light: &PointLight) -> Vec<u32> {
    in_sight(gpu().read_texture(shadows.maps(), id.index()), light)
}

/// The same of the numbers of its triangles.
fn numbers(shadows: &PointShadows, id: LightId, light: &PointLight) -> Vec<u32> {
    in_sight(gpu().read_texture(shadows.numbers(), id.index()), light)
}

fn in_sight(texels: Vec<u32>, light: &PointLight) -> Vec<u32> {
    let width = if light.coverage == Coverage::Full { 2 * RESOLUTION } else { RESOLUTION } as usize;
    texels.chunks(2 * RESOLUTION as usize).flat_map(|row| &row[..width]).copied().collect()
}

/// Shadows under test, with the handles of the world's lights.
struct Subject {
    shadows: PointShadows,
    lights: Vec<LightId>,
    limited: bool,
    /// Each light's map after the last recording.
    before: Vec<Vec<u32>>,
}

/// All there is, and what it ought to look like.
struct World {
    casters: Casters,
    meshes: Vec<MeshId>,
    instances: Vec<(InstanceId, usize, Affine3A)>,
    lights: Vec<PointLight>,
    subjects: Vec<Subject>,
    /// Makes every map anew at each recording, from casters made anew.
    fresh: PointShadows,
    checked: usize,
}

impl World {
    fn new() -> Self {
        let subject = |keep_static, limited| Subject {
            shadows: shadows(keep_static),
            lights: Vec::new(),
            limited,
            before: Vec::new(),
        };
        let mut casters = Casters::new(&gpu().device).unwrap();
        Self {
            meshes: add_meshes(&mut casters),
            casters,
            instances: Vec::new(),
            lights: Vec::new(),
            subjects: vec![subject(false, false), subject(true, false), subject(true, true)],
            fresh: shadows(false),
            checked: 0,
        }
    }

    /// Takes away all instances and lights, so that pipelines needn't be made for every sequence.
    fn clear(&mut self) {
        for (id, ..) in self.instances.drain(..) {
            self.casters.remove_instance(id).unwrap();
        }
        while !self.lights.is_empty() {
            self.take(Step::RemoveLight { light: 0 });
        }
    }

    fn take(&mut self, step: Step) {
        match step {
            Step::AddInstance { mesh, transform, moving } => {
                let mesh = mesh % self.meshes.len();
                let id = self.casters.add_instance(self.meshes[mesh], transform).unwrap();
                self.casters.set_moving(id, moving).unwrap();
                self.instances.push((id, mesh, transform));
            }
            Step::Move { instance, transform } if !self.instances.is_empty() => {
                let count = self.instances.len();
                let (id, _, place) = &mut self.instances[instance % count];
                self.casters.set_transform(*id, transform).unwrap();
                *place = transform;
            }
            Step::SetMoving { instance, moving } if !self.instances.is_empty() => {
                let (id, ..) = self.instances[instance % self.instances.len()];
                self.casters.set_moving(id, moving).unwrap();
            }
            Step::RemoveInstance { instance } if !self.instances.is_empty() => {
                let (id, ..) = self.instances.swap_remove(instance % self.instances.len());
                self.casters.remove_instance(id).unwrap();
            }
            Step::AddLight(light) if self.lights.len() < CAPACITY => {
                self.lights.push(light);
                for subject in &mut self.subjects {
                    let id = subject.shadows.add(light).unwrap();
                    subject.before.push(bits(&subject.shadows, id, &light));
                    subject.lights.push(id);
                }
            }
            Step::SetLight { light, to } if !self.lights.is_empty() => {
                let light = light % self.lights.len();
                self.lights[light] = to;
                for subject in &mut self.subjects {
                    subject.shadows.set(subject.lights[light], to).unwrap();
                    // With another coverage other hemispheres are compared.
                    subject.before[light] = bits(&subject.shadows, subject.lights[light], &to);
                }
            }
            Step::SetPriority { light, priority } if !self.lights.is_empty() => {
                let light = light % self.lights.len();
                self.subjects.iter_mut().for_each(|s| s.shadows.set_priority(s.lights[light], priority).unwrap());
            }
            Step::RemoveLight { light } if !self.lights.is_empty() => {
                let light = light % self.lights.len();
                self.lights.swap_remove(light);
                for subject in &mut self.subjects {
                    subject.before.swap_remove(light);
                    subject.shadows.remove(subject.lights.swap_remove(light)).unwrap();
                }
            }
            Step::Record { most } => self.record(most),
            Step::ThrowAway { most, whose } => {
                for (_, subject) in (0..).zip(&mut self.subjects).filter(|(number, _)| whose & 1 << number != 0) {
                    let mut encoder = gpu().device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                    let options = RecordOptions { most: subject.limited.then_some(most), draw: None };
                    let Gpu { device, queue, .. } = gpu();
                    subject.shadows.record_with(device, queue, &mut encoder, &mut self.casters, options).unwrap();
                }
            }
            _ => {}
        }
    }

    /// Records, and holds each map against one made anew: it is the same, or, within a limit, what it was before.
    fn record(&mut self, most: u32) {
        let expected = self.made_anew();
        for subject in &mut self.subjects {
            let made = record(&mut subject.shadows, &mut self.casters, subject.limited.then_some(most));
            let mut changed = 0;
            for (number, expected) in expected.iter().enumerate() {
                let map = bits(&subject.shadows, subject.lights[number], &self.lights[number]);
                let kept = map == subject.before[number];
                assert!(map == *expected || (subject.limited && kept), "light {number} of {:?}", self.lights);
                changed += u32::from(!kept);
                subject.before[number] = map;
            }
            assert!(changed <= made && (!subject.limited || made <= most), "{changed} changed, {made} made of {most}");
        }
        // Those of other casters' triangles would be other numbers.
        let [plain, kept, ..] = &self.subjects[..] else { return };
        for (number, light) in self.lights.iter().enumerate() {
            let [plain, kept] = [plain, kept].map(|s| numbers(&s.shadows, s.lights[number], light));
            assert!(plain == kept, "numbers of light {number} of {:?}", self.lights);
        }
        self.checked += 1;
    }

    /// Whatever the limit, all maps are right after as many recordings as there are lights.
    fn settle(&mut self) {
        let subjects = self.subjects.iter_mut().filter(|subject| subject.limited);
        for subject in subjects {
            let made = |_| record(&mut subject.shadows, &mut self.casters, Some(1));
            let made: Vec<u32> = (0..CAPACITY).map(made).collect();
            assert!(made.is_sorted_by(|a, b| a >= b), "{made:?}");
            let lights = subject.lights.iter().zip(&self.lights);
            subject.before = lights.map(|(&id, light)| bits(&subject.shadows, id, light)).collect();
            assert_eq!(record(&mut subject.shadows, &mut self.casters, None), 0);
        }
        self.record(0);
        let expected = self.made_anew();
        assert!(self.subjects.iter().all(|subject| subject.before == expected));
    }

    /// The maps of all lights with nothing kept from before, neither casters nor maps.
    fn made_anew(&mut self) -> Vec<Vec<u32>> {
        let mut casters = Casters::new(&gpu().device).unwrap();
        let meshes = add_meshes(&mut casters);
        for (_, mesh, transform) in &self.instances {
            casters.add_instance(meshes[*mesh], *transform).unwrap();
        }
        let ids: Vec<LightId> = self.lights.iter().map(|light| self.fresh.add(*light).unwrap()).collect();
        assert_eq!(record(&mut self.fresh, &mut casters, None), ids.len() as u32);
        let maps = ids.iter().zip(&self.lights).map(|(&id, light)| bits(&self.fresh, id, light)).collect();
        ids.into_iter().for_each(|id| self.fresh.remove(id).unwrap());
        maps
    }
}

#[test]
fn kept_maps_are_fresh_ones_after_any_steps() {
    let config = Config { cases: 15, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let world = std::cell::RefCell::new(World::new());
    let sequences = prop::collection::vec(step(), 150);
    let result = runner.run(&sequences, |steps| {
        let mut world = world.borrow_mut();
        world.clear();
        steps.into_iter().for_each(|step| world.take(step));
        world.settle();
        Ok(())
    });
    result.unwrap_or_else(|failure| panic!("{failure}"));
    assert!(world.borrow().checked > 600);
}

#[test]
fn what_has_to_wait_stays_as_it_is() {
    let wall = [[Vec3::new(-4.0, -4.0, 1.0), Vec3::new(4.0, -4.0, 1.0), Vec3::new(0.0, 6.0, 1.0)]];
    let mut casters = soup(&wall, Sides::Both);
    let before = PointLight::default();
    let behind = PointLight { position: Vec3::new(0.0, 0.0, 3.0), ..before };
    let mut shadows = shadows(true);
    // In front of the wall and facing back, behind it and facing on.
    let receivers = [(Vec3::new(0.1, 0.2, 0.5), Vec3::NEG_Z), (Vec3::new(0.1, 0.2, 2.0), Vec3::Z)];
    let arrives =
        |shadows: &PointShadows, casters: &Casters, light| gpu().shadow_values(shadows, casters, light, &receivers);
    let old = shadows.add(before).unwrap();
    assert_eq!(record(&mut shadows, &mut casters, Some(1)), 1);
    let of_before = arrives(&shadows, &casters, old);
    assert_eq!(of_before, [1.0, 0.0]);
    shadows.set(old, behind).unwrap();
    let new = shadows.add(behind).unwrap();
    assert_eq!(record(&mut shadows, &mut casters, Some(0)), 0);
    assert_eq!(arrives(&shadows, &casters, old), of_before, "a light is looked up by another one's map");
    assert_eq!(arrives(&shadows, &casters, new), [0.0, 0.0], "a light without a map isn't dark");
    assert_eq!(record(&mut shadows, &mut casters, Some(1)), 1);
    assert_eq!(arrives(&shadows, &casters, new), [0.0, 1.0], "the new one doesn't go first");
    assert_eq!(arrives(&shadows, &casters, old), of_before);
    assert_eq!(record(&mut shadows, &mut casters, Some(1)), 1);
    assert_eq!(arrives(&shadows, &casters, old), [0.0, 1.0]);
}

#[test]
fn more_changes_than_are_remembered_are_noticed() {
    let wall = [[Vec3::new(-4.0, -4.0, 1.0), Vec3::new(4.0, -4.0, 1.0), Vec3::new(0.0, 6.0, 1.0)]];
    let mut casters = soup(&wall, Sides::Both);
    let mut shadows = shadows(false);
    shadows.add(PointLight::default()).unwrap();
    assert_eq!(record(&mut shadows, &mut casters, None), 1);
    let touch = |casters: &mut Casters, x: f32| casters.touch(Vec3::splat(x), Vec3::splat(x + 1.0)).unwrap();
    // The one that is near is forgotten, so every light counts as touched.
    touch(&mut casters, 0.0);
    (0..70_000).for_each(|_| touch(&mut casters, 1e3));
    assert_eq!(record(&mut shadows, &mut casters, None), 1);
    // As many as ever are remembered, and yet those are others.
    touch(&mut casters, 1e3);
    assert_eq!(record(&mut shadows, &mut casters, None), 0);
    touch(&mut casters, 0.0);
    assert_eq!(record(&mut shadows, &mut casters, None), 1);
}
