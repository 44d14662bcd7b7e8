//! What a lookup costs on its own: passes over the whole screen that read recorded positions and normals, as deferred
//! renderers have them, and ask for the shadow at each pixel.

mod lights;
mod pass;

pub use lights::{LightsBench, LightsQuestion, LightsTime};
pub use pass::PassStage;

use std::collections::HashMap;

use super::baselines::{Baseline, BaselineError, Budget, DeviceScene, Lookup, Method};
use super::gpu::Gpu;
use super::shot::Shot;
use super::timing::{Rounds, Summary, Timer, milliseconds};
use crate::{PointLight, Sides};
use pass::{Screen, ShadePass};
use serde::{Serialize, Serializer};

const TEXELS: &str = include_str!("../../shaders/compare/lookup_texels.wgsl");
const CUBE_FILTER: &str = include_str!("../../shaders/compare/cube_filter.wgsl");

/// A filter wider than four texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// 3 x 3 texels.
    Square3,
    /// 5 x 5 texels.
    Square5,
    /// A disc of 0.01 radians, 16 taps.
    Disc,
    /// A sphere of 0.1 world units, 32 taps.
    Soft,
}

/// What a pass asks at each pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Question {
    /// Nothing: it only reads the position and the normal.
    Nothing,
    /// A method's own lookup, over the pixel where it takes that.
    Lookup(Lookup),
    /// `dp_shadow` at the pixel's middle alone.
    Point,
    /// `dp_shadow` over a square of texels, so many across, each loaded on its own.
    Texels(u32),
    /// A filter of the pair.
    Filter(Kernel),
    /// The same on a cube, of the hardware's comparisons.
    CubeFilter(Kernel),
}

impl Question {
    /// What is measured: every lookup of every method, squares of 1, 4 and 9 texels, and filters.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut all = vec![Self::Nothing, Self::Point];
        for lookup in Method::ALL.iter().flat_map(|method| method.lookups()).copied().map(Self::Lookup) {
            if !all.contains(&lookup) {
                all.push(lookup);
            }
        }
        all.extend([1, 2, 3].map(Self::Texels));
        all.extend(Kernel::ALL.into_iter().flat_map(|kernel| [Self::CubeFilter(kernel), Self::Filter(kernel)]));
        all
    }

    /// The name for reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Lookup(lookup) => lookup.name(),
            Self::Point => "dp_shadow, points",
            Self::Texels(1) => "dp_shadow, 1 texel",
            Self::Texels(2) => "dp_shadow, 4 texels loaded",
            Self::Texels(_) => "dp_shadow, 9 texels loaded",
            Self::Filter(Kernel::Square3) => "dp_shadow_pcf3",
            Self::Filter(Kernel::Square5) => "dp_shadow_pcf5",
            Self::Filter(Kernel::Disc) => "dp_shadow_disc, 16 taps",
            Self::Filter(Kernel::Soft) => "dp_shadow_soft, 32 taps",
            Self::CubeFilter(Kernel::Square3) => "cube, 3x3 by hardware",
            Self::CubeFilter(Kernel::Square5) => "cube, 5x5 by hardware",
            Self::CubeFilter(Kernel::Disc) => "cube, disc of 16 by hardware",
            Self::CubeFilter(Kernel::Soft) => "cube, soft of 32 by hardware",
        }
    }

    /// The method whose map it reads: the first whose lookup it is.
    fn method(self) -> Method {
        let reads = |method: &Method| method.is_read_by(self.lookup());
        Method::ALL.into_iter().find(reads).unwrap_or(Method::Paraboloid)
    }

    /// The lookup whose groups it binds.
    fn lookup(self) -> Lookup {
        match self {
            Self::Nothing | Self::Texels(_) => Lookup::Votes,
            Self::Point => Lookup::Paraboloid,
            Self::Filter(_) => Lookup::Filtered,
            Self::CubeFilter(_) => Lookup::CubeHardware,
            Self::Lookup(lookup) => lookup,
        }
    }

    /// WGSL for the map's group 0, and an expression over `position` and `normal`.
    fn text(self) -> (String, String) {
        let (text, expression) = match self {
            Self::Nothing => (Lookup::Votes.text(0), "dot(position, normal)"),
            Self::Lookup(lookup) => (lookup.text_unturned(0), lookup.expression()),
            Self::Point => (Lookup::Paraboloid.text(0), "dp_shadow(0u, position, normal, vec4<f32>(0.0))"),
            Self::Texels(side) => {
                let text = TEXELS.replace("TEXELS", &side.to_string());
                ([Lookup::Votes.text(0), text].concat(), "texels_shadow(0u, position, normal)")
            }
            Self::Filter(kernel) => (Lookup::Filtered.text(0), kernel.expression()),
            Self::CubeFilter(kernel) => {
                ([&Lookup::CubeHardware.text_unturned(0), CUBE_FILTER].concat(), kernel.cube_expression())
            }
        };
        (text, expression.replace("view", "camera"))
    }
}

impl Kernel {
    /// Every kernel.
    pub const ALL: [Self; 4] = [Self::Square3, Self::Square5, Self::Disc, Self::Soft];

    fn expression(self) -> &'static str {
        match self {
            Self::Square3 => "dp_shadow_pcf3(0u, position, normal, view, 0.5)",
            Self::Square5 => "dp_shadow_pcf5(0u, position, normal, view, 0.5)",
            Self::Disc => "dp_shadow_with(0u, position, normal, view, 0.5, DpFilter(DP_DISC, 0.01, 16u))",
            Self::Soft => "dp_shadow_with(0u, position, normal, view, 0.5, DpFilter(DP_SOFT, 0.1, 32u))",
        }
    }

    fn cube_expression(self) -> &'static str {
        match self {
            Self::Square3 => "cube_shadow_square(position, normal, 1)",
            Self::Square5 => "cube_shadow_square(position, normal, 2)",
            Self::Disc => "cube_shadow_disc(position, normal, 0.01, 16u, 0.5)",
            Self::Soft => "cube_shadow_soft(position, normal, 0.1, 32u, 0.5)",
        }
    }
}

/// Name and text of the complete modules of all passes, for checking them with other compilers.
#[must_use]
pub fn modules() -> Vec<(String, String)> {
    let module = |(number, question): (usize, Question)| {
        let (text, expression) = question.text();
        (format!("compare_shade_{number}"), pass::module(&text, &expression))
    };
    let lights =
        (0..).zip(lights::modules()).map(|(number, text): (u32, _)| (format!("compare_lights_{number}"), text));
    Question::all().into_iter().enumerate().map(module).chain(lights).collect()
}

/// What a pass takes, in itself and beside the others of its kind.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LookupTime {
    /// What it asks.
    #[serde(serialize_with = "as_name")]
    pub question: Question,
    /// What kind of pass it is.
    pub stage: PassStage,
    /// The device's time for one pass.
    pub time: Summary,
    /// Median less that of the pass that asks nothing, in milliseconds.
    pub ms_over_nothing: f64,
    /// Median over that of the hardware's comparison in a cube.
    pub to_cube: f64,
    /// The same of what either takes more than the pass that asks nothing; `None` where the cube takes no more.
    pub to_cube_over_nothing: Option<f64>,
    /// That of a filter to the same one on a cube; `None` of what is no filter, and where the cube takes no more.
    pub to_same_on_cube_over_nothing: Option<f64>,
}

fn as_name<S: Serializer>(question: &Question, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(question.name())
}

/// Sets the times of all questions, asked by one kind of pass, beside each other.
fn compare(stage: PassStage, times: &[(Question, Summary)]) -> Vec<LookupTime> {
    let of = |wanted: Question| {
        let found = times.iter().find(|(question, _)| *question == wanted);
        found.map_or(0.0, |(_, time)| milliseconds(time.median))
    };
    let (nothing, cube) = (of(Question::Nothing), of(Question::Lookup(Lookup::CubeHardware)));
    let all = times.iter().map(|&(question, time)| {
        let over_nothing = milliseconds(time.median) - nothing;
        let same = match question {
            Question::Filter(kernel) => of(Question::CubeFilter(kernel)),
            _ => nothing,
        };
        LookupTime {
            question,
            stage,
            time,
            ms_over_nothing: over_nothing,
            to_cube: milliseconds(time.median) / cube,
            to_cube_over_nothing: (cube > nothing).then(|| over_nothing / (cube - nothing)),
            to_same_on_cube_over_nothing: (same > nothing).then(|| over_nothing / (same - nothing)),
        }
    });
    all.collect()
}

/// What a camera sees at some sizes of the screen, and passes over it that ask questions of any map.
#[derive(Debug)]
pub struct Screens<'a> {
    gpu: &'a Gpu,
    screens: Vec<Screen>,
    /// Those that were needed so far: all maps that a question is put to are bound alike.
    passes: HashMap<(Question, PassStage), ShadePass>,
}

impl<'a> Screens<'a> {
    /// Uploads what was seen, for a light.
    #[must_use]
    pub fn new(gpu: &'a Gpu, shots: &[Shot], light: &PointLight) -> Self {
        let screens = shots.iter().map(|shot| Screen::new(gpu, shot, light)).collect();
        Self { gpu, screens, passes: HashMap::new() }
    }

    /// Pixels across and down of each screen.
    #[must_use]
    pub fn sizes(&self) -> Vec<(u32, u32)> {
        self.screens.iter().map(Screen::size).collect()
    }

    /// Makes the pipeline for a question to maps like this one.
    pub fn prepare(&mut self, question: Question, stage: PassStage, map: &Baseline) {
        self.passes.entry((question, stage)).or_insert_with(|| {
            let (text, expression) = question.text();
            ShadePass::new(self.gpu, stage, &map.bind_groups(question.lookup()), &text, &expression)
        });
    }

    /// Records a pass that puts a question to a map; nothing without a pipeline from [`Self::prepare`].
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        screen: usize,
        question: Question,
        stage: PassStage,
        map: &Baseline,
    ) {
        if let Some(pass) = self.passes.get(&(question, stage)) {
            self.screens[screen].record(encoder, pass, &map.bind_groups(question.lookup()));
        }
    }

    /// What the last pass over a screen wrote, pixel by pixel.
    #[must_use]
    pub fn answers(&self, screen: usize) -> Vec<f32> {
        self.gpu.read_texture(self.screens[screen].target(), 0)
    }
}

/// Recorded maps of a light and what a camera sees of its scene: all that the passes read.
#[derive(Debug)]
pub struct LookupBench<'a> {
    gpu: &'a Gpu,
    screens: Screens<'a>,
    /// One of each method that a question reads.
    maps: Vec<Baseline>,
}

impl<'a> LookupBench<'a> {
    /// Records the maps, of `pair` texels across each of the pair's, cubes with as many in all. They lie along the
    /// world's axes, as engines' cubes do, whatever the light's orientation.
    ///
    /// # Errors
    /// [`BaselineError`], for a resolution that the device doesn't allow or a scene that it can't hold.
    pub fn new(
        gpu: &'a Gpu,
        scene: &super::scene::Scene,
        light: &PointLight,
        shot: &Shot,
        pair: u32,
    ) -> Result<Self, BaselineError> {
        let mut casters = DeviceScene::new(gpu, scene, Sides::Auto)?;
        let light = &PointLight { orientation: glam::Quat::IDENTITY, ..*light };
        let mut bench = Self { gpu, screens: Screens::new(gpu, std::slice::from_ref(shot), light), maps: Vec::new() };
        for question in Question::all() {
            let method = question.method();
            if bench.maps.iter().all(|map| map.method() != method) {
                let mut map = Baseline::new(&gpu.device, method, method.side(pair, Budget::EqualTexels))?;
                gpu.submit(|encoder| map.record(&gpu.device, &gpu.queue, encoder, &mut casters, light))?;
                bench.maps.push(map);
            }
            let map = &bench.maps[bench.map_of(question)];
            PassStage::ALL.into_iter().for_each(|stage| bench.screens.prepare(question, stage, map));
        }
        Ok(bench)
    }

    /// What a pass writes, pixel by pixel: the shares of light from 0 (dark) to 1 (lit).
    #[must_use]
    pub fn answers(&self, question: Question, stage: PassStage) -> Vec<f32> {
        self.gpu.submit(|encoder| self.record(encoder, question, stage));
        self.screens.answers(0)
    }

    /// What one pass of each question and kind takes, interleaved, `repeat` passes timed together.
    #[must_use]
    pub fn times(&self, timer: &Timer, rounds: Rounds, repeat: u32) -> Vec<LookupTime> {
        let questions = Question::all();
        let ways: Vec<(Question, PassStage)> =
            PassStage::ALL.into_iter().flat_map(|stage| questions.iter().map(move |&of| (of, stage))).collect();
        let times = timer.interleaved(ways.len(), rounds, |way, encoder| {
            let (question, stage) = ways[way];
            (0..repeat.max(1)).for_each(|_| self.record(encoder, question, stage));
        });
        let one = |time| time / repeat.max(1);
        let of_one = |all: Summary| Summary { median: one(all.median), min: one(all.min), max: one(all.max) };
        let of_stage = |(stage, times): (PassStage, &[_])| compare(stage, times);
        let times: Vec<(Question, Summary)> =
            ways.iter().zip(times).map(|((question, _), times)| (*question, of_one(times.gpu))).collect();
        PassStage::ALL.into_iter().zip(times.chunks(questions.len())).flat_map(of_stage).collect()
    }

    fn map_of(&self, question: Question) -> usize {
        self.maps.iter().position(|map| map.method() == question.method()).unwrap_or(0)
    }

    fn record(&self, encoder: &mut wgpu::CommandEncoder, question: Question, stage: PassStage) {
        self.screens.record(encoder, 0, question, stage, &self.maps[self.map_of(question)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn times(milliseconds: impl Fn(Question) -> u64) -> Vec<(Question, Summary)> {
        let time = |question| {
            let median = Duration::from_millis(milliseconds(question));
            (question, Summary { median, min: median, max: median })
        };
        Question::all().into_iter().map(time).collect()
    }

    #[test]
    fn ratios_with_and_without_the_pass_that_asks_nothing() {
        let all = compare(
            PassStage::Compute,
            &times(|question| match question {
                Question::Nothing => 2,
                Question::Lookup(Lookup::CubeHardware) => 6,
                Question::Lookup(Lookup::Paraboloid) => 10,
                Question::CubeFilter(Kernel::Square3) => 4,
                Question::Filter(Kernel::Square3) => 5,
                _ => 1,
            }),
        );
        let own = all.iter().find(|time| time.question == Question::Lookup(Lookup::Paraboloid));
        let figures = own.map(|own| (own.ms_over_nothing, own.to_cube, own.to_cube_over_nothing));
        assert_eq!(figures, Some((8.0, 10.0 / 6.0, Some(2.0))));
        assert_eq!(all.len(), Question::all().len());
        let same = |kernel| {
            let filter = all.iter().find(|time| time.question == Question::Filter(kernel));
            filter.and_then(|time| time.to_same_on_cube_over_nothing)
        };
        assert_eq!((same(Kernel::Square3), same(Kernel::Square5)), (Some(1.5), None));
        let even = compare(PassStage::Fragment, &times(|_| 2));
        assert!(even.iter().all(|time| time.to_cube_over_nothing.is_none() && time.stage == PassStage::Fragment));
    }

    #[test]
    fn every_lookup_is_asked_once() {
        let all = Question::all();
        for lookup in Method::ALL.iter().flat_map(|method| method.lookups()) {
            assert_eq!(all.iter().filter(|of| **of == Question::Lookup(*lookup)).count(), 1, "{}", lookup.name());
        }
    }
}
