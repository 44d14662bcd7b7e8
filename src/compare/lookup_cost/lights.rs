//! What it costs to ask several lights at each pixel, beside the hardware's comparison in their cubes.

use super::pass::{PassStage, Screen, ShadePass};
use crate::compare::baselines::{
    BaselineError, Bound, Budget, CubeArray, DeviceScene, Lookup, Method, cube_array_text, cube_shape,
};
use crate::compare::gpu::Gpu;
use crate::compare::scene::Scene;
use crate::compare::shot::Shot;
use crate::compare::timing::{Rounds, Summary, Timer, milliseconds};
use crate::{PointLight, PointShadows, PointShadowsDescriptor, Sides, Tuning};
use glam::Quat;
use serde::{Serialize, Serializer};

/// What a pass asks of each light at each pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LightsQuestion {
    /// Nothing: it only reads the position and the normal.
    Nothing,
    /// The hardware's comparison in cubes that the hardware draws.
    HardwareCube,
    /// The lookup of this library over the pixel, in a pair of so many texels across each map.
    Exact(u32),
    /// The same at the pixel's middle alone.
    Points(u32),
    /// The lookup without triangles.
    Votes(u32),
    /// [`Self::Exact`] in a cube of this library's own making, of as many texels.
    CubeWalk(u32),
    /// No lookup: whether the texels around the pixel's middle disagree.
    Mixed(u32),
}

impl LightsQuestion {
    /// The name for reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::HardwareCube => "cube, hardware 2x2",
            Self::Exact(_) => "exact, over the pixel",
            Self::Points(_) => "exact, points",
            Self::Votes(_) => "votes",
            Self::CubeWalk(_) => "cube-compute, the same walk",
            Self::Mixed(_) => "mixed",
        }
    }

    /// Texels across each map of the pair that it reads, or that as many texels are of.
    #[must_use]
    pub fn pair(self) -> Option<u32> {
        match self {
            Self::Nothing | Self::HardwareCube => None,
            Self::Exact(pair) | Self::Points(pair) | Self::Votes(pair) | Self::CubeWalk(pair) | Self::Mixed(pair) => {
                Some(pair)
            }
        }
    }

    /// WGSL for the groups from 0 on, and an expression over `position`, `normal` and the number of a `light`.
    fn text(self) -> (String, &'static str) {
        match self {
            Self::Nothing => (Lookup::Votes.text(0), "dot(position, normal)"),
            Self::HardwareCube => (cube_array_text(0), "cube_array_shadow(light, position, normal)"),
            Self::Exact(_) => (Lookup::Paraboloid.text(0), "dp_shadow(light, position, normal, view)"),
            Self::Points(_) => (Lookup::Paraboloid.text(0), "dp_shadow(light, position, normal, vec4<f32>(0.0))"),
            Self::Votes(_) => (Lookup::Votes.text(0), "dp_shadow(light, position, normal, view)"),
            Self::CubeWalk(_) => (Lookup::CubeWalk.text_unturned(0), "cube_shadow_walk(light, position, normal, view)"),
            Self::Mixed(_) => ([&Lookup::Paraboloid.text(0), MIXED].concat(), "mixed(light, position, normal)"),
        }
    }
}

/// The text of a question with a sum over all lights.
fn with_sum((text, expression): (String, &str), lights: u32) -> String {
    let view = if expression.contains("view") { "let view = camera;" } else { "" };
    format!(
        "{text}
fn sum_of_lights(position: vec3<f32>, normal: vec3<f32>) -> f32 {{
    {view}
    var sum = 0.0;
    for (var light = 0u; light < {lights}u; light++) {{
        sum += {expression};
    }}
    return sum;
}}
"
    )
}

/// The complete modules of all passes over two lights.
pub(super) fn modules() -> impl Iterator<Item = String> {
    let questions = [LightsQuestion::Nothing, LightsQuestion::HardwareCube].into_iter().chain(of_pair(1024));
    questions.map(|question| super::pass::module(&with_sum(question.text(), 2), SUM))
}

/// All that is asked of maps at the texels of a pair.
fn of_pair(pair: u32) -> [LightsQuestion; 5] {
    let all = [
        LightsQuestion::Exact,
        LightsQuestion::Points,
        LightsQuestion::Votes,
        LightsQuestion::CubeWalk,
        LightsQuestion::Mixed,
    ];
    all.map(|question| question(pair))
}

const MIXED: &str = "
fn mixed(light: u32, position: vec3<f32>, normal: vec3<f32>) -> f32 {
    let receiver = dp_locate(light, position, normal);
    if dp_is_known(light, receiver) {
        return 0.0;
    }
    return select(0.0, 1.0, dp_walk_first(light, position, receiver).mixed);
}
";

/// What a pass takes that asks all lights at each pixel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LightsTime {
    /// What it asks.
    #[serde(serialize_with = "as_name")]
    pub question: LightsQuestion,
    /// Texels across each map of the pair; `None` of what reads none.
    pub pair: Option<u32>,
    /// What kind of pass it is.
    pub stage: PassStage,
    /// The device's time for one pass.
    pub time: Summary,
    /// Median less that of the pass that asks nothing, in milliseconds.
    pub ms_over_nothing: f64,
    /// Median over that of the hardware's comparison.
    pub to_cube: f64,
}

fn as_name<S: Serializer>(question: &LightsQuestion, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(question.name())
}

/// Maps of several lights of one scene in all forms, and what a camera sees of it.
#[derive(Debug)]
pub struct LightsBench<'a> {
    gpu: &'a Gpu,
    screen: Screen,
    lights: u32,
    casters: DeviceScene,
    cubes: CubeArray,
    /// By texels across each map of the pair: the pairs, and cubes of as many texels.
    maps: Vec<(u32, PointShadows, PointShadows)>,
    passes: Vec<(LightsQuestion, PassStage, ShadePass)>,
}

impl<'a> LightsBench<'a> {
    /// Records the maps of all lights: pairs of each of `pairs` texels across, and the hardware's cubes at the texels of
    /// the first of them. They lie along the world's axes.
    ///
    /// # Errors
    /// [`BaselineError`], for a resolution that the device doesn't allow or a scene that it can't hold.
    pub fn new(
        gpu: &'a Gpu,
        scene: &Scene,
        lights: &[PointLight],
        shot: &Shot,
        pairs: &[u32],
    ) -> Result<Self, BaselineError> {
        let lights: Vec<PointLight> =
            lights.iter().map(|light| PointLight { orientation: Quat::IDENTITY, ..*light }).collect();
        let mut casters = DeviceScene::new(gpu, scene, Sides::Auto)?;
        let side = |pair| Method::Cube.side(pair, Budget::EqualTexels);
        let cubes = CubeArray::new(gpu, &mut casters, &lights, side(pairs[0]))?;
        let mut maps = Vec::new();
        for &pair in pairs {
            let descriptor =
                PointShadowsDescriptor { capacity: lights.len() as u32, resolution: pair, ..Default::default() };
            let mut shadows = PointShadows::new(&gpu.device, &descriptor)?;
            let descriptor = PointShadowsDescriptor { resolution: side(pair), ..descriptor };
            let tuning = Tuning::of(&gpu.device);
            let mut walked = PointShadows::with_shape(&gpu.device, &descriptor, &tuning, cube_shape(side(pair)))?;
            for shadows in [&mut shadows, &mut walked] {
                for light in &lights {
                    shadows.add(*light)?;
                }
                gpu.submit(|encoder| shadows.record(&gpu.device, &gpu.queue, encoder, &mut casters.chunked))?;
            }
            maps.push((pair, shadows, walked));
        }
        let screen = Screen::new(gpu, shot, &lights[0]);
        let lights = lights.len() as u32;
        let mut bench = Self { gpu, screen, lights, casters, cubes, maps, passes: Vec::new() };
        let questions = [LightsQuestion::Nothing, LightsQuestion::HardwareCube];
        for question in questions.into_iter().chain(pairs.iter().copied().flat_map(of_pair)) {
            for stage in PassStage::ALL {
                let text = with_sum(question.text(), bench.lights);
                let pass = ShadePass::new(gpu, stage, &bench.bind_groups(question), &text, SUM);
                bench.passes.push((question, stage, pass));
            }
        }
        Ok(bench)
    }

    fn bind_groups(&self, question: LightsQuestion) -> Vec<Bound<'_>> {
        let pair = question.pair().unwrap_or(self.maps[0].0);
        let (_, shadows, walked) = self.maps.iter().find(|maps| maps.0 == pair).unwrap_or(&self.maps[0]);
        match question {
            LightsQuestion::HardwareCube => vec![self.cubes.bind_group()],
            LightsQuestion::CubeWalk(_) => self.own_groups(walked).to_vec(),
            _ => self.own_groups(shadows).to_vec(),
        }
    }

    fn own_groups<'b>(&'b self, shadows: &'b PointShadows) -> [Bound<'b>; 2] {
        let casters = &self.casters.chunked;
        [
            (Some(shadows.bind_group()), shadows.bind_group_layout()),
            (Some(casters.bind_group()), casters.bind_group_layout()),
        ]
    }

    fn record(&self, encoder: &mut wgpu::CommandEncoder, pass: usize) {
        let (question, _, shade) = &self.passes[pass];
        self.screen.record(encoder, shade, &self.bind_groups(*question));
    }

    /// What a pass writes, pixel by pixel: sums over the lights. `None` for a question that wasn't prepared.
    #[must_use]
    pub fn answers(&self, question: LightsQuestion, stage: PassStage) -> Option<Vec<f32>> {
        let pass = self.passes.iter().position(|pass| (pass.0, pass.1) == (question, stage))?;
        self.gpu.submit(|encoder| self.record(encoder, pass));
        Some(self.gpu.read_texture(self.screen.target(), 0))
    }

    /// Share of all pixels and lights for which the texels around the pixel's middle disagree, by the pair's texels across.
    #[must_use]
    pub fn mixed(&self) -> Vec<(u32, f64)> {
        let share = |&(pair, ..): &(u32, PointShadows, PointShadows)| {
            let mixed = self.answers(LightsQuestion::Mixed(pair), PassStage::Compute)?;
            let sum: f64 = mixed.iter().copied().map(f64::from).sum();
            Some((pair, sum / (mixed.len() as f64 * f64::from(self.lights))))
        };
        self.maps.iter().filter_map(share).collect()
    }

    /// What one pass of each question and kind takes, interleaved, `repeat` passes timed together.
    #[must_use]
    pub fn times(&self, timer: &Timer, rounds: Rounds, repeat: u32) -> Vec<LightsTime> {
        let is_timed = |pass: &usize| !matches!(self.passes[*pass].0, LightsQuestion::Mixed(_));
        let timed: Vec<usize> = (0..self.passes.len()).filter(is_timed).collect();
        let times = timer.interleaved(timed.len(), rounds, |way, encoder| {
            (0..repeat.max(1)).for_each(|_| self.record(encoder, timed[way]));
        });
        let one = |time| time / repeat.max(1);
        let times: Vec<(LightsQuestion, PassStage, Summary)> = timed
            .iter()
            .zip(times)
            .map(|(&pass, times)| {
                let Summary { median, min, max } = times.gpu;
                let (question, stage, _) = &self.passes[pass];
                (*question, *stage, Summary { median: one(median), min: one(min), max: one(max) })
            })
            .collect();
        let of = |wanted: LightsQuestion, stage: PassStage| {
            let found = times.iter().find(|time| (time.0, time.1) == (wanted, stage));
            found.map_or(0.0, |time| milliseconds(time.2.median))
        };
        let compare = |&(question, stage, time): &(LightsQuestion, PassStage, Summary)| LightsTime {
            question,
            pair: question.pair(),
            stage,
            time,
            ms_over_nothing: milliseconds(time.median) - of(LightsQuestion::Nothing, stage),
            to_cube: milliseconds(time.median) / of(LightsQuestion::HardwareCube, stage),
        };
        times.iter().map(compare).collect()
    }
}

const SUM: &str = "sum_of_lights(position, normal)";
