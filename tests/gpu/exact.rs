//! Lookups that ask the triangles: of maps that are out of date, at receivers that aren't the casters, over pixels, and
//! through holes.

use crate::common::{add_spheres, descriptor, filled, gpu, record, soup};
use crate::hard_cases::scene;
use crate::masked::{CELLS, board_above_floor};
use dual_paraboloid::compare::gpu::evaluation;
use dual_paraboloid::compare::measure::light_for;
use dual_paraboloid::compare::procedural::shapes::{icosphere, quad};
use dual_paraboloid::{
    Casters, InstanceId, LightId, PointLight, PointShadows, PointShadowsDescriptor, RecordOptions, Sides, wgsl,
};
use glam::{Affine3A, Quat, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

fn values(shadows: &PointShadows, casters: &Casters, light: LightId, receivers: &[(Vec3, Vec3)]) -> Vec<f32> {
    gpu().shadow_values(shadows, casters, light, receivers)
}

/// Records with so many maps made anew at most.
fn record_some(shadows: &mut PointShadows, casters: &mut Casters, most: u32) {
    let options = RecordOptions { most: Some(most), draw: None };
    let gpu = gpu();
    gpu.submit(|encoder| shadows.record_with(&gpu.device, &gpu.queue, encoder, casters, options)).unwrap();
    gpu.wait();
}

/// Points on a floor at a height of 0, within `half` of the middle.
fn on_floor(count: usize, half: f32, random: &mut Pcg64) -> Vec<(Vec3, Vec3)> {
    let mut place = || random.random_range(-half..half);
    (0..count).map(|_| (Vec3::new(place(), 0.0, place()), Vec3::Y)).collect()
}

fn floor(half: f32) -> Vec<[Vec3; 3]> {
    let [a, b, c, d] = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]].map(|[x, z]| half * Vec3::new(x, 0.0, z));
    vec![[a, b, c], [a, c, d]]
}

/// Balls in the air over a floor.
fn balls(count: usize) -> (Casters, Vec<InstanceId>) {
    let mut casters = soup(&floor(8.0), Sides::Both);
    let (_, ids) = add_spheres(&mut casters, count);
    for (k, id) in ids.iter().enumerate() {
        casters
            .set_transform(*id, ball(Vec3::new(1.5 * (k % 4) as f32 - 2.0, 1.0, 1.5 * (k / 4) as f32 - 2.0)))
            .unwrap();
    }
    (casters, ids)
}

fn ball(place: Vec3) -> Affine3A {
    Affine3A::from_translation(place)
}

fn lamp(position: Vec3) -> PointLight {
    PointLight { position, orientation: Quat::from_rotation_x(0.4), ..Default::default() }
}

/// The lookup's text with all indices checked: `dp_out_of_range` counts those that are past the end.
fn checked_lookup() -> String {
    let mut text = wgsl::lookup(0, 1);
    for (array, index) in [("dp_chunks", "chunk"), ("dp_meshes", "place"), ("dp_vertices", "vertex")] {
        let read = format!("return {array}[{index}]");
        assert_eq!(text.matches(&format!("{array}[")).count(), 1, "{array} is read elsewhere");
        let check = format!("dp_out_of_range += u32({index} >= arrayLength(&{array}));\n    {read}");
        text = text.replace(&read, &check);
    }
    assert_eq!(text.matches("dp_out_of_range").count(), 3);
    text + "var<private> dp_out_of_range: u32;\n"
}

/// Whatever happens to casters while maps wait, lookups read nothing that isn't there.
#[test]
fn maps_out_of_date_are_safe_to_ask() {
    const LIGHTS: u32 = 3;
    let mut random = Pcg64::seed_from_u64(3);
    let (mut casters, mut ids) = balls(12);
    let (mesh, more) = add_spheres(&mut casters, 4);
    ids.extend(more);
    let descriptor = PointShadowsDescriptor { capacity: LIGHTS, resolution: 128, ..Default::default() };
    let mut shadows = PointShadows::new(&gpu().device, &descriptor).unwrap();
    for k in 0..LIGHTS {
        shadows.add(lamp(Vec3::new(k as f32 - 1.0, 3.0, 0.3))).unwrap();
    }
    let receivers = on_floor(3000, 4.0, &mut random);
    let calls: Vec<String> = (0..LIGHTS).map(|k| format!("dp_shadow({k}u, position, normal, view)")).collect();
    let answer = format!(
        "fn answer(position: vec3<f32>, normal: vec3<f32>, view: vec4<f32>) -> f32 {{
            let sum = {};
            return select(sum, -f32(dp_out_of_range), dp_out_of_range > 0u);
        }}",
        calls.join(" + ")
    );
    let text = [checked_lookup(), answer, evaluation("answer(position, normal, view)")].concat();
    let layouts = [shadows.bind_group_layout(), casters.bind_group_layout()];
    let evaluator = gpu().evaluator(&text, &layouts, &receivers);
    let place = |random: &mut Pcg64| {
        ball(Vec3::new(random.random_range(-3.0..3.0), random.random_range(0.2..2.5), random.random_range(-3.0..3.0)))
    };
    for step in 0..150 {
        for _ in 0..random.random_range(1..6) {
            let chosen = random.random_range(0..ids.len().max(1));
            match random.random_range(0..6) {
                0 if !ids.is_empty() => casters.remove_instance(ids.swap_remove(chosen)).unwrap(),
                1 => ids.push(casters.add_instance(mesh, place(&mut random)).unwrap()),
                // A great many go at once, and buffers shrink.
                2 if step % 30 == 29 => ids.drain(..).for_each(|id| casters.remove_instance(id).unwrap()),
                3 if step % 30 == 14 => {
                    ids.extend((0..200).map(|_| casters.add_instance(mesh, place(&mut random)).unwrap()))
                }
                _ if !ids.is_empty() => casters.set_transform(ids[chosen], place(&mut random)).unwrap(),
                _ => {}
            }
        }
        record_some(&mut shadows, &mut casters, random.random_range(0..2));
        let answers = evaluator.values(gpu(), &[Some(shadows.bind_group()), Some(casters.bind_group())]);
        let wrong = answers.iter().find(|sum| !(0.0..=LIGHTS as f32).contains(*sum));
        assert_eq!(wrong, None, "step {step}");
    }
}

/// What moved, went or came again since a map was made is looked up by votes, all else as before.
#[test]
fn texels_of_what_changed_vote() {
    let mut random = Pcg64::seed_from_u64(4);
    let (mut casters, ids) = balls(8);
    let light = lamp(Vec3::new(0.3, 3.0, -0.2));
    let (mut shadows, id) = record(PointShadows::new(&gpu().device, &descriptor(128)).unwrap(), &mut casters, light);
    let receivers = on_floor(20_000, 4.0, &mut random);
    let before = values(&shadows, &casters, id, &receivers);
    let votes = gpu().vote_values(&shadows, id, &receivers);
    let check = |shadows: &PointShadows, casters: &Casters, least: usize, what: &str| {
        let after = values(shadows, casters, id, &receivers);
        let by = |a: f32, b: f32| a.to_bits() == b.to_bits();
        let known = after.iter().zip(before.iter().zip(&votes)).all(|(&after, (&a, &b))| by(after, a) || by(after, b));
        assert!(known, "{what}: an answer is neither the former one nor that of the votes");
        let changed = after.iter().zip(&before).filter(|(a, b)| !by(**a, **b)).count();
        assert!((least..2000).contains(&changed), "{what}: {changed} answers changed");
        changed
    };
    casters.set_transform(ids[0], ball(Vec3::new(-3.0, 0.5, 3.0))).unwrap();
    record_some(&mut shadows, &mut casters, 0);
    let one = check(&shadows, &casters, 20, "one moved");
    casters.remove_instance(ids[1]).unwrap();
    record_some(&mut shadows, &mut casters, 0);
    let two = check(&shadows, &casters, one + 10, "another went");
    // What comes takes its place in every buffer.
    add_spheres(&mut casters, 1);
    record_some(&mut shadows, &mut casters, 0);
    assert_eq!(check(&shadows, &casters, two, "another came"), two);
    record_some(&mut shadows, &mut casters, 1);
    let fresh = values(&shadows, &casters, id, &receivers);
    let (anew, other) = record(PointShadows::new(&gpu().device, &descriptor(128)).unwrap(), &mut casters, light);
    assert_eq!(fresh, values(&anew, &casters, other, &receivers));
}

/// With other casters all of a map votes: their triangles aren't those it shows.
#[test]
fn maps_of_other_casters_vote() {
    let mut random = Pcg64::seed_from_u64(5);
    let ((mut casters, _), (mut others, _)) = (balls(8), balls(3));
    let light = lamp(Vec3::new(0.3, 3.0, -0.2));
    let (mut shadows, id) = record(PointShadows::new(&gpu().device, &descriptor(128)).unwrap(), &mut casters, light);
    let receivers = on_floor(5000, 4.0, &mut random);
    let votes = gpu().vote_values(&shadows, id, &receivers);
    assert_ne!(values(&shadows, &casters, id, &receivers), votes);
    record_some(&mut shadows, &mut others, 0);
    assert_eq!(values(&shadows, &others, id, &receivers), votes);
}

/// Share of receivers, per million, that are dark; of a surface that nothing shadows.
fn acne_ppm(casters: &mut Casters, light: PointLight, resolution: u32, receivers: &[(Vec3, Vec3)]) -> f64 {
    let shadows = PointShadows::new(&gpu().device, &descriptor(resolution)).unwrap();
    let (shadows, id) = record(shadows, casters, light);
    let dark = values(&shadows, casters, id, receivers).iter().filter(|value| **value < 0.5).count();
    1e6 * dark as f64 / receivers.len() as f64
}

/// Points of a ball of another level of detail than the one that casts lie behind it, by so much as their faces are apart.
#[test]
fn coarser_receivers_take_an_offset() {
    let coarse = icosphere(1.0, 2);
    let mut casters = filled(&scene([icosphere(1.0, 5)]));
    let light = lamp(Vec3::new(0.5, 2.5, 1.0));
    let corners = |face: &[u32; 3]| face.map(|vertex| Vec3::from(coarse.positions[vertex as usize]));
    let faces: Vec<[Vec3; 3]> = coarse.indices.as_chunks().0.iter().map(corners).collect();
    let normal = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).normalize();
    let offset = faces.iter().map(|face| 1.0 - normal(*face).dot(face[0])).fold(0.0, f32::max);
    let mut random = Pcg64::seed_from_u64(6);
    let receivers: Vec<(Vec3, Vec3)> = (0..80_000)
        .map(|_| {
            let face @ [a, b, c] = faces[random.random_range(0..faces.len())];
            let (s, t): (f32, f32) = (random.random(), random.random());
            let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
            (a + (b - a) * s + (c - a) * t, normal(face))
        })
        // The fine ball's terminator lies elsewhere.
        .filter(|(position, normal)| normal.dot((light.position - position).normalize()) > 0.5)
        .collect();
    assert!(receivers.len() > 5000);
    for resolution in [64, 256, 1024] {
        let with = |receiver_offset| PointLight { receiver_offset, ..light };
        assert!(acne_ppm(&mut casters, with(0.0), resolution, &receivers) > 1000.0, "the offset isn't needed");
        assert_eq!(acne_ppm(&mut casters, with(offset), resolution, &receivers), 0.0, "R = {resolution}");
    }
}

/// Positions from a depth buffer of 24 bits, for a camera some 40 away from a floor whose near plane is at a tenth.
#[test]
fn positions_from_a_depth_buffer_take_an_offset() {
    let mut casters = soup(&floor(20.0), Sides::Both);
    let mut random = Pcg64::seed_from_u64(7);
    let eye = Vec3::new(20.0, 30.0, 10.0);
    let ahead = -eye.normalize();
    let receivers: Vec<(Vec3, Vec3)> = on_floor(20_000, 8.0, &mut random)
        .into_iter()
        .map(|(position, normal)| {
            let depth = f64::from((position - eye).dot(ahead));
            let stored = (0.1 / depth * f64::from(1 << 24)).round() / f64::from(1 << 24);
            (eye + (position - eye) * (0.1 / stored / depth) as f32, normal)
        })
        .collect();
    let offset = receivers.iter().map(|(position, _)| position.y.abs()).fold(0.0, f32::max);
    let light = lamp(Vec3::new(0.4, 3.0, 0.2));
    for resolution in [64, 1024] {
        let with = |receiver_offset| PointLight { receiver_offset, ..light };
        let without = acne_ppm(&mut casters, with(0.0), resolution, &receivers);
        assert!(without > 1000.0 || resolution == 64, "{without}: the offset isn't needed");
        assert_eq!(acne_ppm(&mut casters, with(offset), resolution, &receivers), 0.0, "R = {resolution}");
    }
}

/// What single precision leaves of positions is allowed for, as other arithmetic in skinning would have it.
#[test]
fn rounded_receivers_need_no_offset() {
    let mut random = Pcg64::seed_from_u64(8);
    for place in [0.0, 1e3, 1e5_f32] {
        let at = Vec3::new(place, 0.0, -place);
        let moved = |triangles: Vec<[Vec3; 3]>| triangles.into_iter().map(|t| t.map(|p| p + at)).collect::<Vec<_>>();
        let mut casters = soup(&moved(floor(8.0)), Sides::Both);
        let light = lamp(Vec3::new(0.4, 1.5, 0.2) + at);
        let ulp = |x: f32| x.abs().next_up() - x.abs();
        let receivers: Vec<(Vec3, Vec3)> = on_floor(20_000, 6.0, &mut random)
            .into_iter()
            .map(|(p, normal)| {
                let p = p + at;
                let scale = ulp(place.max(1.0)) * 0.5;
                (p + Vec3::Y * scale * random.random_range(-1.0..1.0), normal)
            })
            .collect();
        for resolution in [64, 256, 1024] {
            assert_eq!(acne_ppm(&mut casters, light, resolution, &receivers), 0.0, "R = {resolution} at {place}");
        }
    }
}

/// Over a pixel an edge is the share of it that is lit.
#[test]
fn edges_are_smooth_over_a_pixel() {
    // A sheet's edge at x = 0, half way between the light and the floor, throws its shadow's edge to -2 x of the light.
    let sheet = quad(Vec3::new(0.0, 1.5, -9.0), 18.0 * Vec3::Z, 9.0 * Vec3::X);
    let ground = quad(Vec3::new(-9.0, 0.0, -9.0), 18.0 * Vec3::Z, 18.0 * Vec3::X);
    let scene = scene([sheet, ground]);
    let light = PointLight { orientation: Quat::from_rotation_y(0.6), ..light_for(&scene, Vec3::new(0.5, 3.0, 0.0)) };
    let mut casters = filled(&scene);
    let (shadows, id) = record(PointShadows::new(&gpu().device, &descriptor(512)).unwrap(), &mut casters, light);
    const STEP: f32 = 0.01;
    let edge = -0.5;
    let receivers: Vec<(Vec3, Vec3)> =
        (-1000..=1000).map(|k| (Vec3::new(edge + 2e-5 * k as f32, 0.0, 0.02 + 1e-4 * k as f32), Vec3::Y)).collect();
    // From straight above, a pixel is as wide as a step.
    let view = format!("vec4<f32>({edge:?}, 10.0, 0.0, {:?})", STEP / 10.0);
    let call = format!("dp_shadow({}u, position, normal, {view})", id.index());
    let over_pixels = gpu().lookup_values(&shadows, &casters, &call, &receivers);
    let points = values(&shadows, &casters, id, &receivers);
    let (mut sum, mut worst) = (0.0, 0.0f32);
    for (((position, _), value), point) in receivers.iter().zip(over_pixels).zip(points) {
        let lit = (edge - position.x) / STEP;
        let decides = (position.x - edge).abs() > 1e-6;
        assert!(!decides || point == f32::from(lit > 0.0), "at {position}, {lit} pixels from the edge");
        let error = (value - (0.5 + lit).clamp(0.0, 1.0)).abs();
        sum += error;
        worst = worst.max(error);
    }
    let mean = sum / receivers.len() as f32;
    println!("worst {worst}, mean {mean}");
    // Where the edge runs just past the four texels that are asked, they agree.
    assert!(worst <= 0.25 && mean <= 0.005, "{worst}, mean {mean}");
}

/// Holes are seen through to the point: alpha decides where the ray to the receiver goes through.
#[test]
fn holes_end_where_their_alpha_does() {
    let mut casters = board_above_floor(3, 4);
    let light = PointLight { position: Vec3::new(0.13, 3.0, -0.21), ..Default::default() };
    let (shadows, id) = record(PointShadows::new(&gpu().device, &descriptor(512)).unwrap(), &mut casters, light);
    let mut random = Pcg64::seed_from_u64(9);
    let receivers = on_floor(50_000, 2.5, &mut random);
    // Through the board, 4 across at a height of 1, in cells of the checkerboard.
    let cell = |x: f32| (x + 2.0) / 4.0 * CELLS as f32;
    let lit = |position: Vec3| {
        let at = light.position + (position - light.position) * (2.0 / 3.0);
        let (x, z) = (cell(at.x), cell(at.z));
        let near_an_edge = [x, z].iter().any(|c| (c - c.round()).abs() < 1e-3);
        (!near_an_edge).then_some((x.floor() as i32 + z.floor() as i32) % 2 != 0)
    };
    let wrong = |values: Vec<f32>| {
        let wrong = receivers
            .iter()
            .zip(values)
            .filter(|((position, _), value)| lit(*position).is_some_and(|lit| lit != (*value >= 0.5)));
        1e6 * wrong.count() as f64 / receivers.len() as f64
    };
    let (exact, votes) =
        (wrong(values(&shadows, &casters, id, &receivers)), wrong(gpu().vote_values(&shadows, id, &receivers)));
    println!("wrong per million: {exact:.0}, by votes {votes:.0}");
    assert!(votes > 1000.0 && exact <= 0.1 * votes, "{exact} of a million are wrong, {votes} by votes");
}
