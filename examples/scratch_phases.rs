//! scratch
use dual_paraboloid::Sides;
use dual_paraboloid::compare::baselines::DeviceScene;
use dual_paraboloid::compare::error_figures::map_error;
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::ideal::{MapGeometry, ideal_map};
use dual_paraboloid::compare::measure::{Pixels, Truth, choose_camera, choose_light, find_scene, select_scenes};
use dual_paraboloid::compare::reference::Reference;
use dual_paraboloid::compare::shot::Shot;
use std::time::Instant;
fn main() {
    let gpu = Gpu::new(wgpu::Features::empty()).unwrap();
    let parts: Vec<String> = std::env::args().skip(1).collect();
    for name in select_scenes(&parts).unwrap() {
        let mut t = Instant::now();
        let mut lap = |what: &str| {
            print!("{what} {:.2}  ", t.elapsed().as_secs_f64());
            use std::io::Write;
            std::io::stdout().flush().ok();
            t = Instant::now();
        };
        println!("== {name}");
        let scene = find_scene(&name).unwrap();
        lap("load");
        let scene = scene.without_holes();
        lap("without");
        let (light, choice) = choose_light(&scene, None, None);
        lap("light");
        let camera = choose_camera(&scene, &light, choice);
        lap("camera");
        let all = scene.world_triangles();
        lap("world");
        let _ = scene.double_sided(&all);
        lap("double");
        let r = Reference::new(&all.corners, None, light.position.as_dvec3());
        lap("tree");
        drop(r);
        lap("drop");
        let truth = Truth::new(&scene, &light, 1_000_000, 1);
        lap("truth");
        let front = |t: u32| {
            let c = &truth.reference.triangles()[t as usize];
            (c[1] - c[0]).cross(c[2] - c[0]).dot(c[0]) < 0.0
        };
        let fronts = truth.receivers.iter().filter(|r| r.counts(truth.view.position) && front(r.triangle)).count();
        print!("[receivers {} fronts {fronts} of {}] ", truth.receivers.len(), truth.counted());
        let d = DeviceScene::new(&gpu, &scene, Sides::Auto).unwrap();
        lap("device");
        drop(d);
        lap("drop");
        let s = Shot::of(&truth.reference, &camera, 1920, 1080);
        lap("shot1080");
        drop(s);
        let _ = Pixels::new(&truth, &scene, &camera, 480, 270);
        lap("pixels/16");
        let g = MapGeometry { resolution: 512, guard: 0.03 };
        let m = ideal_map(&truth.reference, &truth.view, g);
        lap("ideal512");
        let votes = truth.votes_v1(&m);
        lap("votes");
        let e = truth.judge(&votes);
        lap("judge");
        print!("[{}] ", e.wrong_ppm);
        let st: Vec<f32> = m.depths.iter().map(|d| *d as f32).collect();
        let _ = map_error(&st, &m, &truth.reference, &truth.view);
        lap("maperror");
        let c = truth.lit_creases().len();
        lap("creases");
        println!("[{c}]");
    }
}
