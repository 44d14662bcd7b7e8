//! What is measured of a scene at one resolution.

use crate::Arguments;
use anyhow::{Context, ensure};
use dual_paraboloid::PointLight;
use dual_paraboloid::Sides;
use dual_paraboloid::compare::baselines::{Baseline, Budget, DeviceScene, Lookup, Method};
use dual_paraboloid::compare::cost::{Contestant, Origin, orientations, turned_errors};
use dual_paraboloid::compare::error_figures::{CreaseError, MapError, ShadowError, map_error};
use dual_paraboloid::compare::gpu::Gpu;
use dual_paraboloid::compare::ideal::MapGeometry;
use dual_paraboloid::compare::measure::{
    Judge, PixelError, Pixels, Truth, choose_camera, choose_light, find_scene, is_made_in_code,
};
use dual_paraboloid::compare::scene::Scene;
use glam::Quat;

/// Figures of a scene at one resolution.
pub struct Measured {
    pub scene: String,
    pub origin: Origin,
    pub triangles: usize,
    /// Texels across each map of the pair.
    pub resolution: u32,
    /// Wrong answers of all methods over all orientations, in parts per million. Without the scene's holes, which the
    /// others know nothing of.
    pub compared: Vec<(Contestant, f64)>,
    pub own: OwnFigures,
}

/// This library's figures in the light's own orientation, with the scene's holes.
pub struct OwnFigures {
    pub shadow: ShadowError,
    /// Of the frozen lookup [`votes_v1`](Truth::votes_v1) on the ray-cast map.
    pub ideal: ShadowError,
    /// Receivers at which library and ideal decide differently, in parts per million.
    pub disagree_ppm: f64,
    pub creases: Option<CreaseError>,
    pub map: MapError,
    pub pixels: Option<PixelError>,
}

/// A scene with its light and its truth.
pub struct Subject {
    scene: Scene,
    origin: Origin,
    light: PointLight,
    orientations: Vec<Quat>,
    pixels: Pixels,
    own: Trial,
    /// Without holes, if there are any.
    whole: Option<Trial>,
}

/// Casters and the truth of them.
struct Trial {
    truth: Truth,
    casters: DeviceScene,
}

impl Trial {
    fn new(gpu: &Gpu, scene: &Scene, light: &PointLight, arguments: &Arguments) -> anyhow::Result<Self> {
        let truth = Truth::new(scene, light, arguments.samples as usize, arguments.seed);
        ensure!(truth.counted() > 0, "the light of {} reaches no surface", scene.name);
        Ok(Self { truth, casters: DeviceScene::new(gpu, scene, Sides::Auto)? })
    }
}

impl Subject {
    pub fn new(gpu: &Gpu, name: &str, arguments: &Arguments) -> anyhow::Result<Self> {
        let (width, height) = arguments.size;
        let scene = find_scene(name)?;
        let (light, choice) = choose_light(&scene, None, None);
        let own = Trial::new(gpu, &scene, &light, arguments)?;
        let whole =
            scene.has_holes().then(|| Trial::new(gpu, &scene.without_holes(), &light, arguments)).transpose()?;
        let pixels = Pixels::new(&own.truth, &scene, &choose_camera(&scene, &light, choice), width, height);
        let origin = if is_made_in_code(name) { Origin::Code } else { Origin::File };
        let orientations = orientations(arguments.orientations as usize, arguments.seed);
        Ok(Self { scene, origin, light, orientations, pixels, own, whole })
    }

    pub fn name(&self) -> &str {
        &self.scene.name
    }

    pub fn measure(&mut self, gpu: &Gpu, resolution: u32) -> anyhow::Result<Measured> {
        Ok(Measured {
            scene: self.scene.name.clone(),
            origin: self.origin,
            triangles: self.scene.triangle_count(),
            resolution,
            compared: self.compare(gpu, resolution)?,
            own: self.own(gpu, resolution)?,
        })
    }

    /// Every lookup of every method whose map is its own, over all orientations.
    fn compare(&mut self, gpu: &Gpu, resolution: u32) -> anyhow::Result<Vec<(Contestant, f64)>> {
        let Trial { truth, casters } = self.whole.as_mut().unwrap_or(&mut self.own);
        let mut judge = Judge::new(gpu, PointLight { orientation: self.orientations[0], ..self.light }, truth);
        let mut compared = Vec::new();
        for method in Method::ALL.into_iter().filter(|method| method.same_map() == *method && method.is_available(gpu))
        {
            let mut baseline = Baseline::new(&gpu.device, method, method.side(resolution, Budget::EqualTexels))?;
            let errors = turned_errors(&mut judge, &mut baseline, casters, &self.orientations)?;
            compared.extend(errors.into_iter().map(|(lookup, errors)| (Contestant { method, lookup }, errors.mean())));
        }
        Ok(compared)
    }

    fn own(&mut self, gpu: &Gpu, resolution: u32) -> anyhow::Result<OwnFigures> {
        let Trial { truth, casters } = &mut self.own;
        let mut pair = Baseline::new(&gpu.device, Method::Paraboloid, resolution)?;
        gpu.submit(|encoder| pair.record(&gpu.device, &gpu.queue, encoder, casters, &self.light))?;
        let answers = |inputs: &[_]| pair.shadow_values(gpu, Lookup::Paraboloid, inputs).unwrap_or_default();
        let values = answers(&truth.inputs());
        let geometry = geometry(&pair)?;
        let (ideal_map, _) = truth.ideal(geometry);
        let ideal = truth.votes_v1(&ideal_map);
        let inputs = self.pixels.inputs();
        let pixels = if inputs.is_empty() { None } else { self.pixels.judge(&answers(&inputs)) };
        Ok(OwnFigures {
            shadow: truth.judge(&values),
            ideal: truth.judge(&ideal),
            disagree_ppm: truth.disagree_ppm(&values, &ideal),
            creases: truth.crease_error(&values),
            map: map_error(&gpu.read_texture::<f32>(pair.map(), 0), &ideal_map, &truth.reference, &truth.view),
            pixels,
        })
    }
}

/// Shape of the library's map.
fn geometry(pair: &Baseline) -> anyhow::Result<MapGeometry> {
    let shadows = pair.shadows().context("the map is not this library's")?;
    let guard = f64::from(shadows.half_width()) - 1.0;
    Ok(MapGeometry { resolution: shadows.maps().height(), guard })
}
