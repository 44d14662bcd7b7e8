//! What a lookup costs on its own: passes over the whole screen that read recorded positions and normals, as deferred
//! renderers have them, and ask for the shadow at each pixel.

mod pass;

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
    /// A method's own lookup.
    Lookup(Lookup),
    /// `dp_shadow` over a square of texels, so many across, each loaded on its own.
    Texels(u32),
    /// A filter of the pair.
    Filter(Kernel),
    /// The same on a cube, of the hardware's comparisons.
    CubeFilter(Kernel),
}

impl Question {
    /// What is measured: all lookups, squares of 1, 4 and 9 texels, and filters.
    pub const ALL: [Self; 16] = [
        Self::Nothing,
        Self::Lookup(Lookup::CubeHardware),
        Self::Lookup(Lookup::CubePlane),
        Self::Lookup(Lookup::VertexWarp),
        Self::Lookup(Lookup::Paraboloid),
        Self::Texels(1),
        Self::Texels(2),
        Self::Texels(3),
        Self::CubeFilter(Kernel::Square3),
        Self::Filter(Kernel::Square3),
        Self::CubeFilter(Kernel::Square5),
        Self::Filter(Kernel::Square5),
        Self::CubeFilter(Kernel::Disc),
        Self::Filter(Kernel::Disc),
        Self::CubeFilter(Kernel::Soft),
        Self::Filter(Kernel::Soft),
    ];

    /// The name for reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Lookup(Lookup::Paraboloid) => "dp_shadow, 2x2 gathered",
            Self::Lookup(Lookup::Filtered) => "dp_shadow_filtered",
            Self::Lookup(Lookup::VertexWarp) => "vertex warp, 2x2 by hardware",
            Self::Lookup(Lookup::VertexWarpShipped) => "vertex warp, shipped bias, 2x2 by hardware",
            Self::Lookup(Lookup::CubeHardware) => "cube, 2x2 by hardware",
            Self::Lookup(Lookup::CubeShipped) => "cube, shipped bias, 2x2 by hardware",
            Self::Lookup(Lookup::CubePlane) => "cube, plane bias, 2x2 gathered",
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

    /// The method whose map it reads.
    fn method(self) -> Method {
        match self {
            Self::Nothing | Self::Texels(_) | Self::Filter(_) => Method::Paraboloid,
            Self::Lookup(Lookup::Paraboloid | Lookup::Filtered) => Method::Paraboloid,
            Self::Lookup(Lookup::VertexWarp | Lookup::VertexWarpShipped) => Method::VertexWarp,
            Self::Lookup(Lookup::CubeHardware | Lookup::CubeShipped | Lookup::CubePlane) | Self::CubeFilter(_) => {
                Method::Cube
            }
        }
    }

    /// WGSL for the map's group 0, and an expression over `position` and `normal`.
    fn text(self) -> (String, &'static str) {
        match self {
            Self::Nothing => (Lookup::Paraboloid.text(0), "dot(position, normal)"),
            Self::Lookup(lookup) => (lookup.text_unturned(0), lookup.expression()),
            Self::Texels(side) => {
                let text = TEXELS.replace("TEXELS", &side.to_string());
                ([Lookup::Paraboloid.text(0), text].concat(), "texels_shadow(0u, position, normal)")
            }
            Self::Filter(kernel) => (Lookup::Filtered.text(0), kernel.expression()),
            Self::CubeFilter(kernel) => {
                ([&Lookup::CubeHardware.text_unturned(0), CUBE_FILTER].concat(), kernel.cube_expression())
            }
        }
    }
}

impl Kernel {
    fn expression(self) -> &'static str {
        match self {
            Self::Square3 => "dp_shadow_pcf3(0u, position, normal, 0.5)",
            Self::Square5 => "dp_shadow_pcf5(0u, position, normal, 0.5)",
            Self::Disc => "dp_shadow_with(0u, position, normal, 0.5, DpFilter(DP_DISC, 0.01, 16u))",
            Self::Soft => "dp_shadow_with(0u, position, normal, 0.5, DpFilter(DP_SOFT, 0.1, 32u))",
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
        (format!("compare_shade_{number}"), pass::module(&text, expression))
    };
    Question::ALL.into_iter().enumerate().map(module).collect()
}

/// What a pass takes, in itself and beside the others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LookupTime {
    /// What it asks.
    #[serde(serialize_with = "as_name")]
    pub question: Question,
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

/// Sets the times of [`Question::ALL`] beside each other.
fn compare(times: &[Summary]) -> Vec<LookupTime> {
    let of = |wanted: Question| {
        let place = Question::ALL.iter().position(|question| *question == wanted);
        place.and_then(|place| times.get(place)).map_or(0.0, |time| milliseconds(time.median))
    };
    let (nothing, cube) = (of(Question::Nothing), of(Question::Lookup(Lookup::CubeHardware)));
    let all = Question::ALL.into_iter().zip(times).map(|(question, time)| {
        let over_nothing = milliseconds(time.median) - nothing;
        let same = match question {
            Question::Filter(kernel) => of(Question::CubeFilter(kernel)),
            _ => nothing,
        };
        LookupTime {
            question,
            time: *time,
            ms_over_nothing: over_nothing,
            to_cube: milliseconds(time.median) / cube,
            to_cube_over_nothing: (cube > nothing).then(|| over_nothing / (cube - nothing)),
            to_same_on_cube_over_nothing: (same > nothing).then(|| over_nothing / (same - nothing)),
        }
    });
    all.collect()
}

/// Recorded maps of a light and what a camera sees of its scene: all that the passes read.
#[derive(Debug)]
pub struct LookupBench<'a> {
    gpu: &'a Gpu,
    screen: Screen,
    /// Of the pair, the cube and the warped pair.
    maps: Vec<Baseline>,
}

impl<'a> LookupBench<'a> {
    /// Records the maps, of `pair` texels across each of the pair's, the cube with as many in all. They lie along the
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
        let mut maps = Vec::new();
        for method in [Method::Paraboloid, Method::Cube, Method::VertexWarp] {
            let mut map = Baseline::new(&gpu.device, method, method.side(pair, Budget::EqualTexels))?;
            let mut recorded = Ok(());
            gpu.submit(|encoder| recorded = map.record(&gpu.device, &gpu.queue, encoder, &mut casters, light));
            recorded?;
            maps.push(map);
        }
        Ok(Self { gpu, screen: Screen::new(gpu, shot, light), maps })
    }

    /// What a pass writes, pixel by pixel: the shares of light from 0 (dark) to 1 (lit).
    #[must_use]
    pub fn answers(&self, question: Question) -> Vec<f32> {
        let pass = self.pass(question);
        self.gpu.submit(|encoder| self.draw(encoder, &pass));
        self.gpu.read_texture(self.screen.target(), 0)
    }

    /// What one pass of each question of [`Question::ALL`] takes, interleaved, `repeat` passes timed together.
    #[must_use]
    pub fn times(&self, timer: &Timer, rounds: Rounds, repeat: u32) -> Vec<LookupTime> {
        let passes: Vec<ShadePass> = Question::ALL.iter().map(|question| self.pass(*question)).collect();
        let times = timer.interleaved(passes.len(), rounds, |way, encoder| {
            for _ in 0..repeat.max(1) {
                self.draw(encoder, &passes[way]);
            }
        });
        let one = |time| time / repeat.max(1);
        let of_one = |all: Summary| Summary { median: one(all.median), min: one(all.min), max: one(all.max) };
        compare(&times.into_iter().map(|times| of_one(times.gpu)).collect::<Vec<_>>())
    }

    fn pass(&self, question: Question) -> ShadePass {
        let (text, expression) = question.text();
        let map = self.maps.iter().position(|map| map.method() == question.method()).unwrap_or(0);
        ShadePass::new(self.gpu, &self.screen, map, self.maps[map].bind_group(), &text, expression)
    }

    fn draw(&self, encoder: &mut wgpu::CommandEncoder, pass: &ShadePass) {
        self.screen.draw(encoder, pass, self.maps[pass.map].bind_group());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn ratios_with_and_without_the_pass_that_asks_nothing() {
        let times = [2, 6, 8, 4, 10, 1, 3, 5, 4, 5, 1, 1, 1, 1, 1, 1].map(|time| {
            let median = Duration::from_millis(time);
            Summary { median, min: median, max: median }
        });
        let all = compare(&times);
        let own = all.iter().find(|time| time.question == Question::Lookup(Lookup::Paraboloid));
        let figures = own.map(|own| (own.ms_over_nothing, own.to_cube, own.to_cube_over_nothing));
        assert_eq!(figures, Some((8.0, 10.0 / 6.0, Some(2.0))));
        assert_eq!(all.len(), Question::ALL.len());
        let same = |kernel| {
            let filter = all.iter().find(|time| time.question == Question::Filter(kernel));
            filter.and_then(|time| time.to_same_on_cube_over_nothing)
        };
        assert_eq!((same(Kernel::Square3), same(Kernel::Square5)), (Some(1.5), None));
        assert_eq!(compare(&[times[0]; 16])[1].to_cube_over_nothing, None);
    }
}
