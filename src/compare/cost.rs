//! What maps cost and how wrong they are, over methods, resolutions and scenes: the comparison of the benchmark.
//!
//! A [`Subject`] is a scene with its light and its truth; [`Subject::costs`] measures all methods of a [`Plan`] at one
//! resolution. [`Curve`] compares two methods where they are equally wrong, [`Ratios`] over scenes.

mod curve;
mod ratios;
mod step;

pub use curve::{Curve, EqualError, Point, geometric_mean, pareto_front};
pub use ratios::{LARGE_SCENE, Ratio, Ratios};
pub use step::{Plan, Subject};

use std::fmt;
use std::str::FromStr;
use std::time::Duration;

use super::baselines::{Bias, Budget, Lookup, Method};
use super::timing::{Summary, as_milliseconds, milliseconds};
use crate::Sides;
use serde::Serialize;

/// Which sides of all meshes cast, for all methods alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
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
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    /// Bytes on the GPU, see [`Baseline::memory`](super::baselines::Baseline::memory).
    pub bytes: u64,
    /// The device's work.
    pub gpu: Summary,
    /// The host's recording, until the encoder is finished.
    pub cpu: Summary,
    /// How often it was measured.
    pub runs: usize,
    /// The errors of each lookup that reads the map.
    pub errors: Vec<LookupError>,
    /// What the library's stages take; its own alone.
    pub stages: Option<Stages>,
}

/// How wrong a lookup is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LookupError {
    /// The lookup.
    pub lookup: Lookup,
    /// Wrong answers, in parts per million of the samples.
    pub wrong_ppm: f64,
    /// The bias that was best; `None` of lookups whose bias is fixed.
    pub bias: Option<Bias>,
}

/// Shares of a recording's time, from the medians of recordings that stop early. Written out in milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Stages {
    /// Choosing triangles.
    #[serde(rename = "ms_route", serialize_with = "as_milliseconds")]
    pub route: Duration,
    /// Cutting those that would bend.
    #[serde(rename = "ms_split", serialize_with = "as_milliseconds")]
    pub split: Duration,
    /// The render pass.
    #[serde(rename = "ms_depth", serialize_with = "as_milliseconds")]
    pub depth: Duration,
}

impl Cost {
    /// Median of the device's time, in milliseconds.
    #[must_use]
    pub fn milliseconds(&self) -> f64 {
        milliseconds(self.gpu.median)
    }

    /// Wrong answers of a lookup, in parts per million.
    #[must_use]
    pub fn wrong_ppm(&self, lookup: Lookup) -> Option<f64> {
        self.errors.iter().find(|error| error.lookup == lookup).map(|error| error.wrong_ppm)
    }
}

/// All figures of one scene under one rule.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneCosts {
    /// The scene's name.
    pub scene: String,
    /// Its triangles, instances counted.
    pub triangles: usize,
    /// Which sides cast.
    pub rule: Rule,
    /// Of all methods and resolutions.
    pub costs: Vec<Cost>,
    /// What the device can't do, each with the reason.
    pub left_out: Vec<String>,
}

impl SceneCosts {
    /// A method's figures at one size. The budget matters for cubes alone.
    #[must_use]
    pub fn find(&self, method: Method, budget: Budget, pair: u32) -> Option<&Cost> {
        let fits =
            |cost: &&Cost| cost.method == method && cost.pair == pair && (cost.budget == budget || !method.is_cube());
        self.costs.iter().find(fits)
    }

    /// Time in milliseconds and wrong answers in parts per million of a method at all its sizes, the smallest first.
    #[must_use]
    pub fn points(&self, method: Method, lookup: Lookup) -> Vec<Point> {
        let mut of: Vec<&Cost> = self.costs.iter().filter(|cost| cost.method == method).collect();
        of.sort_by_key(|cost| cost.side);
        let point = |cost: &Cost| Some(Point { time: cost.milliseconds(), error: cost.wrong_ppm(lookup)? });
        of.into_iter().filter_map(point).collect()
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
