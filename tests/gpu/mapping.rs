//! The mapping's WGSL against its Rust twin, and that against double precision.

use crate::common::gpu;
use dual_paraboloid::compare::gpu::evaluation;
use dual_paraboloid::paraboloid::{self as single, double};
use glam::{DVec2, Vec2, Vec3, Vec3Swizzles};
use rand::{RngCore, SeedableRng};
use rand_pcg::Pcg64;

const COUNT: usize = 10_000;

fn unit(rng: &mut Pcg64) -> f32 {
    (rng.next_u32() >> 8) as f32 / (1 << 24) as f32
}

/// Points of hemisphere space over many magnitudes, and the edges of the domain: axes, seam, axis behind.
fn points() -> Vec<Vec3> {
    let mut rng = Pcg64::seed_from_u64(1);
    let mut points = Vec::with_capacity(COUNT);
    for x in [-1.0, -1e-6, 0.0, 1e-6, 1.0f32] {
        for y in [-1.0, -1e-6, 0.0, 1e-6, 1.0f32] {
            for z in [-1.0, -0.5, -1e-6, 0.0, 1e-6, 1.0f32] {
                if Vec3::new(x, y, z).length() > 1e-3 {
                    points.push(Vec3::new(x, y, z));
                }
            }
        }
    }
    while points.len() < COUNT {
        let direction = Vec3::new(unit(&mut rng) - 0.5, unit(&mut rng) - 0.5, unit(&mut rng) - 0.5);
        if direction.length() > 0.05 {
            points.push(direction * 10f32.powf(8.0 * unit(&mut rng) - 4.0));
        }
    }
    points
}

/// Map coordinates in and around the disc, in pairs from far apart to nearly the same.
fn edges() -> Vec<(Vec2, Vec2)> {
    let mut rng = Pcg64::seed_from_u64(2);
    let point = |rng: &mut Pcg64| Vec2::new(2.4 * unit(rng) - 1.2, 2.4 * unit(rng) - 1.2);
    (0..COUNT)
        .map(|i| {
            let a = point(&mut rng);
            let b = if i % 2 == 0 { point(&mut rng) } else { a + 0.1 * point(&mut rng) };
            if i % 17 == 0 { (a, Vec2::ZERO) } else { (a, b) }
        })
        .collect()
}

fn evaluate(expression: &str, inputs: &[(Vec3, Vec3)]) -> Vec<f32> {
    let text = [dual_paraboloid::wgsl::paraboloid(), &evaluation(expression)].concat();
    gpu().evaluate(&text, &[], inputs)
}

/// Asserts that the shader's value of an expression is `expected` within a relative error, where anything is expected,
/// which it is of most inputs.
fn agrees(expression: &str, inputs: &[(Vec3, Vec3)], relative: f32, expected: impl Fn(Vec3, Vec3) -> Option<f32>) {
    let mut compared = 0;
    for ((a, b), value) in inputs.iter().zip(evaluate(expression, inputs)) {
        let Some(expected) = expected(*a, *b) else { continue };
        // No NaN is close to anything; infinities are alike or not.
        let close = (value - expected).abs() <= relative * expected.abs() + 1e-30 || value == expected;
        assert!(close, "{expression} of {a} and {b} is {value}, not {expected}");
        compared += 1;
    }
    assert!(2 * compared > inputs.len(), "{expression} is compared at {compared} of {} inputs", inputs.len());
}

/// The value, unless it is `noise`.
fn unless(noise: bool, value: f32) -> Option<f32> {
    (!noise).then_some(value)
}

#[test]
fn shader_and_rust_agree_on_points() {
    let inputs: Vec<(Vec3, Vec3)> =
        points().iter().map(|p| (*p, Vec3::from_array(p.to_array().map(|x| 2.0 * x)).zxy())).collect();
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        agrees(&format!("dp_to_hemisphere(position, true).{name}"), &inputs, 0.0, |p, _| {
            Some(single::to_hemisphere(p, true)[axis])
        });
        agrees(&format!("dp_to_hemisphere(position, false).{name}"), &inputs, 0.0, |p, _| Some(p[axis]));
    }
    agrees("f32(dp_is_back(position))", &inputs, 0.0, |p, _| Some(f32::from(u8::from(single::is_back(p)))));
    agrees("dp_homogeneous_w(position)", &inputs, 1e-6, |p, _| Some(single::homogeneous_w(p)));
    agrees("dp_project(position).x", &inputs, 1e-6, |p, _| Some(single::project(p).x));
    agrees("dp_project(position).y", &inputs, 1e-6, |p, _| Some(single::project(p).y));
    agrees("dp_depth(position, 0.01)", &inputs, 1e-6, |p, _| Some(single::depth(p, 0.01)));
    for (axis, name) in ["x", "y", "z", "w"].iter().enumerate() {
        let expression = format!("dp_clip_position(position, 0.01, 0.9).{name}");
        agrees(&expression, &inputs, 1e-6, |p, _| Some(single::clip_position(p, 0.01, 0.9)[axis]));
    }
}

#[test]
fn shader_and_rust_agree_on_map_coordinates() {
    let inputs: Vec<(Vec3, Vec3)> = edges().iter().map(|(a, b)| (a.extend(0.7), b.extend(-0.4))).collect();
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        // Near 0 the difference of squares cancels.
        let clear = |value: f32| unless(value.abs() < 0.1, value);
        agrees(&format!("dp_unproject_scaled(position.xy).{name}"), &inputs, 1e-5, |a, _| {
            clear(single::unproject_scaled(a.xy())[axis])
        });
        agrees(&format!("dp_unproject(position.xy).{name}"), &inputs, 1e-5, |a, _| {
            clear(single::unproject(a.xy())[axis])
        });
    }
    agrees("dp_solid_angle_density(position.xy)", &inputs, 1e-6, |a, _| Some(single::solid_angle_density(a.xy())));
    agrees("dp_texel_angle(position.xy, 0.01)", &inputs, 1e-6, |a, _| Some(single::texel_angle(a.xy(), 0.01)));
    agrees("dp_plane_depth(normal, 2.0, position.xy, 0.01)", &inputs, 1e-3, |a, b| {
        let depth = single::plane_depth(b, 2.0, a.xy(), 0.01);
        unless(depth.abs() < 1e-4, depth)
    });
}

#[test]
fn single_precision_follows_double() {
    for p in points() {
        let exact = double::homogeneous_w(p.as_dvec3());
        let w = f64::from(single::homogeneous_w(p));
        assert!((w - exact).abs() <= 4e-7 * exact, "w of {p} is {w}, not {exact}");
        let (x, exact) = (single::project(p).as_dvec2(), double::project(p.as_dvec3()));
        assert!((x - exact).length() <= 1e-6 * exact.length().max(1e-30), "{p} is projected to {x}, not {exact}");
    }
}

#[test]
fn unproject_inverts_project() {
    for p in points() {
        let x = p.as_dvec3();
        if x.z > -0.99 * x.length() {
            let back = double::unproject(double::project(x));
            assert!(back.distance(x.normalize()) < 1e-12, "{x} comes back as {back}");
            assert!((back.length() - 1.0).abs() < 1e-14);
        }
    }
}

#[test]
fn a_plane_is_a_quadratic() {
    let mut compared = 0;
    for (x, n) in points().iter().zip(points().iter().rev()) {
        let (x, n) = (x.as_dvec3(), n.as_dvec3());
        let distance = n.dot(x);
        if x.z > -0.9 * x.length() && distance.abs() > 1e-3 * n.length() * x.length() {
            let depth = double::plane_depth(n, distance, double::project(x), 0.01);
            let expected = double::depth(x, 0.01);
            assert!((depth - expected).abs() < 1e-9 * expected, "{depth} is not {expected}");
            compared += 1;
        }
    }
    assert!(2 * compared > COUNT, "{compared} planes of {COUNT}");
}

#[test]
fn an_edge_is_a_circle() {
    let mut compared = 0;
    for (a, b) in edges() {
        let (a, b) = (double::unproject(a.as_dvec2()), double::unproject(b.as_dvec2()));
        if a.distance(b) < 1e-3 || a.angle_between(b) > 3.0 {
            continue;
        }
        let (centre, radius) = double::edge_arc(a, b);
        assert!(radius >= 1.0 - 1e-12, "{radius}");
        for share in [0.0, 0.3, 0.5, 1.0] {
            let p = double::project(a.lerp(b, share));
            let off = (p.distance(centre) - radius).abs();
            assert!(radius > 1e3 || off < 1e-9 * radius, "{p} of the edge is off its circle by {off}");
            compared += usize::from(radius <= 1e3);
        }
    }
    assert!(compared > COUNT, "{compared} points of {COUNT} edges");
}

#[test]
fn the_disc_integrates_to_a_hemisphere() {
    let steps = 1000;
    let mut sum = 0.0;
    for i in 0..steps {
        for j in 0..steps {
            let p = DVec2::new(
                2.0 * (f64::from(i) + 0.5) / f64::from(steps) - 1.0,
                2.0 * (f64::from(j) + 0.5) / f64::from(steps) - 1.0,
            );
            if p.length() <= 1.0 {
                sum += double::solid_angle_density(p);
            }
        }
    }
    sum *= 4.0 / f64::from(steps * steps);
    assert!((sum - std::f64::consts::TAU).abs() < 2e-3, "{sum}");
}

#[test]
fn no_edge_within_the_angle_limit_bends_more_than_the_tolerance() {
    let (mut rng, mut compared) = (Pcg64::seed_from_u64(3), 0);
    for _ in 0..COUNT {
        let texels = 32.0 * 64f64.powf(f64::from(unit(&mut rng)));
        let tolerance = 0.01 + 0.99 * f64::from(unit(&mut rng));
        let limit = double::angle_limit(texels, tolerance);
        let p = DVec2::from_angle(f64::from(unit(&mut rng)) * 7.0) * f64::from(unit(&mut rng));
        let a = double::unproject(p);
        let across = a.any_orthonormal_vector();
        let turn = glam::DQuat::from_axis_angle(
            glam::DQuat::from_axis_angle(a, f64::from(unit(&mut rng)) * 7.0) * across,
            limit,
        );
        let b = double::project(turn * a);
        if b.length() <= 1.0 {
            // Largest distance of an arc from its chord.
            let (_, radius) = double::edge_arc(a, double::unproject(b));
            let half = 0.5 * p.distance(b);
            let gap = half * half / (radius + (radius * radius - half * half).sqrt()) * texels;
            assert!(gap <= tolerance * 1.1, "a gap of {gap} texels for a tolerance of {tolerance}");
            compared += 1;
        }
    }
    assert!(2 * compared > COUNT, "{compared} of {COUNT} edges are in the disc");
}
