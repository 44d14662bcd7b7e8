//! The cube that is drawn in one pass is the cube.

use crate::trial;
use dual_paraboloid::compare::baselines::{Baseline, BaselineError, CubeMultiview, DeviceScene, Method};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::procedural::{self, shapes};
use dual_paraboloid::compare::scene::{Material, Scene, SceneInstance};
use dual_paraboloid::{PointLight, Sides};
use glam::{Affine3A, Vec3};
use libtest_mimic::Trial;

const RESOLUTION: u32 = 128;

pub fn trials() -> Vec<Trial> {
    vec![
        Trial::test("multiview::is_refused_without_the_feature", || {
            is_refused_without_the_feature();
            Ok(())
        }),
        trial("multiview::draws_each_face", draws_each_face),
        trial("multiview::draws_what_the_cube_does", draws_what_the_cube_does),
    ]
}

/// A device that can draw into six layers at a time.
fn device() -> Result<Gpu, String> {
    let gpu = Gpu::new(wgpu::Features::MULTIVIEW).unwrap_or_else(|error| panic!("{error}"));
    if CubeMultiview::is_supported(&gpu.device) {
        Ok(gpu)
    } else {
        Err(format!("{} has no multiview over six layers", gpu.name()))
    }
}

fn light() -> PointLight {
    PointLight { position: Vec3::new(0.3, 0.2, -0.1), range: 200.0, ..Default::default() }
}

/// The bits of all layers of a method's map.
fn layers(gpu: &Gpu, method: Method, scene: &mut DeviceScene) -> Vec<Vec<u32>> {
    let mut baseline = Baseline::new(&gpu.device, method, RESOLUTION).unwrap();
    gpu.submit(|encoder| baseline.record(&gpu.device, &gpu.queue, encoder, scene, &light()).unwrap());
    (0..baseline.map().depth_or_array_layers()).map(|layer| gpu.read_texture(baseline.map(), layer)).collect()
}

fn is_refused_without_the_feature() {
    let gpu = Gpu::new(wgpu::Features::empty()).unwrap_or_else(|error| panic!("{error}"));
    let refused = Baseline::new(&gpu.device, Method::CubeMultiview, RESOLUTION);
    assert!(matches!(refused, Err(BaselineError::Unsupported { .. })));
}

/// One object at a time, well within a face: what software drivers get right too.
fn draws_each_face() -> Result<(), String> {
    let gpu = device()?;
    let blob = shapes::displaced_sphere(24, 12, |at| at * (1.0 + 0.2 * (5.0 * at.x).sin()));
    let ways = [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    for (face, towards) in ways.enumerate() {
        let transform = Affine3A::from_translation(5.0 * towards + Vec3::splat(0.5));
        let scene = Scene {
            meshes: vec![blob.clone()],
            instances: vec![SceneInstance { mesh: 0, transform }],
            materials: vec![Material::default()],
            ..Scene::default()
        };
        let mut scene = DeviceScene::new(&gpu, &scene, Sides::Front).unwrap();
        let one_pass = layers(&gpu, Method::CubeMultiview, &mut scene);
        for (layer, bits) in one_pass.iter().enumerate() {
            assert_eq!(bits.iter().any(|depth| *depth != 0), layer == face, "layer {layer} for face {face}");
        }
        assert!(layers(&gpu, Method::Cube, &mut scene) == one_pass, "face {face}");
    }
    Ok(())
}

/// Objects across the faces' borders, to the bit.
fn draws_what_the_cube_does() -> Result<(), String> {
    let gpu = device()?;
    if !Method::CubeMultiview.is_available(&gpu) {
        return Err(format!("{} draws to the wrong face what it clips", gpu.name()));
    }
    for sides in [Sides::Both, Sides::Front] {
        let mut scene = DeviceScene::new(&gpu, &procedural::many_small(400), sides).unwrap();
        let one_pass = layers(&gpu, Method::CubeMultiview, &mut scene);
        assert!(one_pass.iter().all(|bits| bits.iter().any(|depth| *depth != 0)));
        assert!(layers(&gpu, Method::Cube, &mut scene) == one_pass, "{sides:?}");
    }
    Ok(())
}
