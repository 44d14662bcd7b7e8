//! Which lights there are, and how bright.

use crate::arguments::Arguments;
use crate::camera::Light;
use dual_paraboloid::PointLight;
use dual_paraboloid::compare::scene::{Scene, SceneLight};
use glam::Vec3;

/// A little warmer than white, as lamps are.
const COLOR: [f32; 3] = [1.0, 0.92, 0.8];
/// Casters this close to a light, as a share of its range, are cut away. It costs no precision, so it is tiny.
const NEAR: f32 = 1e-5;

/// The lights, and who chose them.
pub fn choose(arguments: &Arguments, scene: &Scene) -> (Vec<Light>, &'static str) {
    let plain = |position| SceneLight { position, color: COLOR, intensity: 1.0, range: None };
    let (chosen, by) = if !arguments.lights.is_empty() {
        let given = arguments.lights.iter().copied().map(plain).collect();
        (given, "given")
    } else if !scene.lights.is_empty() {
        (scene.lights.clone(), "the scene's own")
    } else {
        (vec![plain(scene.suggest_light())], "chosen to suit the scene")
    };
    let (low, high) = scene.bounds().unwrap_or_default();
    // The picture is exposed by what is in it; here it is only seen to that no number is huge or tiny.
    let brightest = chosen.iter().map(|light| light.intensity).fold(f32::MIN_POSITIVE, f32::max);
    let unit = (high - low).length_squared() / (25.0 * brightest);
    let lights = chosen.iter().map(|light| {
        // Twice as far as the farthest corner, so that the end of the falloff isn't in the picture.
        let reach = 2.0 * (light.position - low).abs().max((light.position - high).abs()).length();
        let range = arguments.range.or(light.range).unwrap_or(reach);
        Light {
            shadow: PointLight {
                position: light.position,
                range,
                near: NEAR * range,
                filter: arguments.filter.with(arguments.light_radius, range),
                ..Default::default()
            },
            intensity: Vec3::from(light.color) * (light.intensity * unit),
        }
    });
    (lights.collect(), by)
}
