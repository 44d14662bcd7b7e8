use dual_paraboloid::compare::{gpu::Gpu, measure::*, scene::*};
use dual_paraboloid::*;
use glam::Vec3;
fn main() {
    let gpu = Gpu::new(wgpu::Features::empty()).unwrap();
    println!("{}", gpu.name());
    let args: Vec<String> = std::env::args().collect();
    let samples: usize = args[1].parse().unwrap();
    let only = args.get(2).cloned().unwrap_or_default();
    let mut files: Vec<_> = std::fs::read_dir(scenes_dir().unwrap())
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "glb"))
        .collect();
    files.sort();
    for path in files {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        if !name.contains(&only) {
            continue;
        }
        let t0 = std::time::Instant::now();
        let scene = Scene::load(&path).unwrap();
        let mut lights: Vec<Vec3> = known_lights(&name).iter().map(|p| Vec3::from(*p)).collect();
        if lights.is_empty() {
            lights = scene.lights.iter().map(|l| l.position).collect();
        }
        for (k, position) in lights.into_iter().enumerate().take(2) {
            let light = light_for(&scene, position);
            let truth = Truth::new(&scene, &light, samples, 1);
            for resolution in [512, 1024] {
                let made = Made::new(
                    &gpu,
                    &scene,
                    light,
                    &PointShadowsDescriptor { resolution, capacity: 1, ..Default::default() },
                )
                .unwrap();
                let f = made.figures(&gpu, &truth);
                println!(
                    "{name:22}/{k} R{resolution:5} wrong {:7.0} ideal {:7.0} ratio {:.3} far {:5.0} idealfar {:5.0} leak {:6.0} false {:6.0} | holes {} phantoms {} wrongsurf {:6.1} strays {} maxdist {:.2} | depth {:.1e} {:.1e} {:.1e} {:.0}s",
                    f.shadow.error.wrong_ppm,
                    f.ideal.wrong_ppm,
                    f.shadow.error.wrong_ppm / f.ideal.wrong_ppm.max(1e-9),
                    f.shadow.error.far_wrong_ppm,
                    f.ideal.far_wrong_ppm,
                    f.shadow.error.leak_ppm,
                    f.shadow.error.false_shadow_ppm,
                    f.map.holes,
                    f.map.phantoms,
                    f.map.wrong_surface_ppm,
                    f.map.strays,
                    f.map.silhouette_distance_max,
                    f.map.depth_error_median,
                    f.map.depth_error_p99,
                    f.map.depth_error_max,
                    t0.elapsed().as_secs_f32()
                );
            }
        }
    }
}
