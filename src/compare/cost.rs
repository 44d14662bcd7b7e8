//! What maps cost and how wrong they are, over methods, resolutions and scenes: the comparison of the benchmark.
//!
//! A [`Subject`] is a scene with its light and its truth; [`Subject::costs`] measures all methods of a [`Plan`] at one
//! resolution of the [ladder](LADDER), [`OwnErrors`] are this library's own by all definitions. [`Curve`] compares two methods where they are equally wrong, [`Ratios`] their
//! times over scenes, [`ErrorRatios`] their errors.

mod bytes;
mod curve;
mod error_ratios;
mod orientations;
mod own_errors;
mod ratios;
mod scene_costs;
mod step;

pub use bytes::{BreakEven, Bytes};
pub use curve::{Curve, Point, Ratio, Reading, geometric_mean, pareto_front, shown_error};
pub use error_ratios::{ERROR_FLOOR_PPM, ErrorPair, ErrorRatios, error_ratio};
pub use orientations::{TurnedErrors, orientations, turned_errors};
pub use own_errors::{OwnErrors, OwnLookup};
pub use ratios::{RatioSummary, Ratios, SceneRatio};
pub use scene_costs::{Contestant, Origin, SceneCosts};
pub use step::{Plan, Subject};

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

use super::baselines::{Bias, Budget, Lookup, Method};
use super::lookup_cost::PassStage;
use super::timing::{Summary, as_milliseconds, milliseconds};
use crate::Sides;
use serde::{Deserialize, Serialize};

/// Texels across each map of the pair at which curves are measured, all methods alike; cubes have as many texels in
/// all.
pub const LADDER: [u32; 7] = [64, 128, 256, 512, 1024, 2048, 4096];

/// Which sides of all meshes cast, for all methods alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// Both sides of every triangle.
    DoubleSided,
    /// Front faces only, as engines cull for single-sided materials.
    Culled,
}

impl Rule {
    /// Both rules.
    pub const ALL: [Self; 2] = [Self::DoubleSided, Self::Culled];

    /// The name that [`str::parse`] reads.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::DoubleSided => "double-sided",
            Self::Culled => "culled",
        }
    }

    /// What a mesh is added with.
    #[must_use]
    pub fn sides(self) -> Sides {
        match self {
            Self::DoubleSided => Sides::Auto,
            Self::Culled => Sides::Front,
        }
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(match self {
            Self::DoubleSided => "all casters double-sided",
            Self::Culled => "back faces culled",
        })
    }
}

impl FromStr for Rule {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|rule| rule.name() == name);
        found.ok_or_else(|| format!("no rule is called {name:?}: there are double-sided, culled"))
    }
}

/// A method's figures at one resolution.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
pub struct Cost {
    /// What made the map.
    pub method: Method,
    /// What a cube has in common with the pair; a pair has both.
    pub budget: Budget,
    /// Texels across each map of the pair that it is set against.
    pub pair: u32,
    /// Texels across each of its own squares.
    pub side: u32,
    /// Texels in all.
    pub texels: u64,
    /// On the GPU.
    pub bytes: Bytes,
    /// The device's work for the map, made anew.
    pub gpu: Summary,
    /// The host's recording of the map, until the encoder is finished.
    pub cpu: Summary,
    /// How often it was measured.
    pub runs: usize,
    /// The lookups that read the map.
    pub lookups: Vec<LookupCost>,
    /// What the library's stages take; its own alone.
    pub stages: Option<Stages>,
}

/// How wrong a lookup is, and what it takes.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
pub struct LookupCost {
    /// The lookup.
    pub lookup: Lookup,
    /// Wrong answers, in parts per million, over all orientations of the maps.
    pub wrong_ppm: f64,
    /// The same on fronts alone, without the backs of double-sided surfaces.
    pub wrong_front_ppm: f64,
    /// Wrong answers of each orientation.
    pub wrong_ppm_by_orientation: Vec<f64>,
    /// Receivers that were asked in each orientation.
    pub samples: usize,
    /// The bias that was found best; `None` of lookups whose bias is fixed.
    pub bias: Option<Bias>,
    /// One pass over each screen.
    pub screens: Vec<ScreenTime>,
}

/// What a pass takes that asks a lookup at each pixel of a screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
pub struct ScreenTime {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// In a compute pass.
    pub compute: Summary,
    /// In a fragment pass.
    pub fragment: Summary,
}

/// What a time is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Timed {
    /// The map, made anew.
    Map,
    /// The map, made anew, and a pass over the screen of this number that looks it up.
    Lit {
        /// Number of the screen.
        screen: usize,
        /// What kind of pass.
        stage: PassStage,
    },
}

impl Timed {
    /// What *time* means without further words: map and compute pass over the first screen.
    pub const HEADLINE: Self = Self::Lit { screen: 0, stage: PassStage::Compute };

    /// All there are with this number of screens, the headline first.
    #[must_use]
    pub fn all(screens: usize) -> Vec<Self> {
        let lit = |stage| (0..screens).map(move |screen| Self::Lit { screen, stage });
        lit(PassStage::Compute).chain(lit(PassStage::Fragment)).chain([Self::Map]).collect()
    }

    /// What it is, for reports, with screens of these sizes.
    #[must_use]
    pub fn name(self, screens: &[(u32, u32)]) -> String {
        match self {
            Self::Map => "map alone".to_owned(),
            Self::Lit { screen, stage } => {
                let size = screens.get(screen).map_or_else(String::new, |(width, height)| format!(" {width}x{height}"));
                format!("map + {}{size}", stage.name())
            }
        }
    }
}

/// Shares of a recording's time, from the medians of recordings that stop early. Written out in milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
pub struct Stages {
    /// Leaving out, drawing what is small, recording what is large.
    #[serde(rename = "ms_cull", with = "as_milliseconds")]
    pub cull: Duration,
    /// Numbering texels.
    #[serde(rename = "ms_number", with = "as_milliseconds")]
    pub number: Duration,
    /// Which tiles large triangles touch.
    #[serde(rename = "ms_bin", with = "as_milliseconds")]
    pub bin: Duration,
    /// From tiles to maps.
    #[serde(rename = "ms_rasterise", with = "as_milliseconds")]
    pub rasterise: Duration,
}

impl Stages {
    /// In their order.
    #[must_use]
    pub fn times(&self) -> [Duration; 4] {
        [self.cull, self.number, self.bin, self.rasterise]
    }
}

impl Cost {
    /// Median of the device's time for the map, in milliseconds.
    #[must_use]
    pub fn milliseconds(&self) -> f64 {
        milliseconds(self.gpu.median)
    }

    /// The figures of one of its lookups.
    #[must_use]
    pub fn of(&self, lookup: Lookup) -> Option<&LookupCost> {
        self.lookups.iter().find(|cost| cost.lookup == lookup)
    }

    /// Wrong answers of a lookup, in parts per million.
    #[must_use]
    pub fn wrong_ppm(&self, lookup: Lookup) -> Option<f64> {
        self.of(lookup).map(|cost| cost.wrong_ppm)
    }

    /// Median time in milliseconds, of map and pass the sum of both medians. `None` if the pass wasn't timed.
    #[must_use]
    pub fn time(&self, lookup: Lookup, timed: Timed) -> Option<f64> {
        let Timed::Lit { screen, stage } = timed else { return Some(self.milliseconds()) };
        let pass = self.of(lookup)?.screens.get(screen)?.of(stage);
        Some(self.milliseconds() + milliseconds(pass.median))
    }
}

impl ScreenTime {
    /// The pass of one kind.
    #[must_use]
    pub fn of(&self, stage: PassStage) -> Summary {
        match stage {
            PassStage::Compute => self.compute,
            PassStage::Fragment => self.fragment,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_by_name() {
        for rule in Rule::ALL {
            assert_eq!(rule.name().parse(), Ok(rule));
            assert_eq!(serde_json::to_value(rule).unwrap(), rule.name());
        }
        assert!("both".parse::<Rule>().unwrap_err().contains("double-sided, culled"));
        for method in Method::ALL {
            assert_eq!(serde_json::to_value(method).unwrap(), method.name());
        }
    }
}
