//! One method's time over another's, over many scenes.

use super::{Curve, SceneCosts, geometric_mean};
use crate::compare::baselines::{Budget, Lookup, Method};
use serde::Serialize;

/// Triangles from which on a scene counts as large.
pub const LARGE_SCENE: usize = 250_000;

/// The library's time over another's in one scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ratio {
    /// The scene's name.
    pub scene: String,
    /// Its triangles.
    pub triangles: usize,
    /// The ratio, or the bound of it: below 1 the library takes less.
    pub ratio: f64,
    /// `""` for a ratio, `"<"` and `">"` for its upper and lower bound, see [`EqualError`](super::EqualError).
    pub sign: &'static str,
}

/// The library's time over another's, in all scenes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ratios {
    /// Scene by scene.
    pub scenes: Vec<Ratio>,
    /// Geometric mean over scenes of [`LARGE_SCENE`] triangles and more, bounds taken for ratios.
    pub large: Option<f64>,
    /// Geometric mean over all scenes, bounds taken for ratios.
    pub all: Option<f64>,
}

impl Ratios {
    /// Against a method at the size that goes with a pair of `pair` texels across each map.
    #[must_use]
    pub fn at_equal_size(scenes: &[&SceneCosts], method: Method, budget: Budget, pair: u32) -> Self {
        Self::new(scenes, |costs| {
            let own = costs.find(Method::Paraboloid, budget, pair)?;
            Some((own.milliseconds() / costs.find(method, budget, pair)?.milliseconds(), ""))
        })
    }

    /// Against a method with a lookup, where both are equally wrong: [`Curve::at_equal_error`] over all sizes.
    #[must_use]
    pub fn at_equal_error(scenes: &[&SceneCosts], method: Method, lookup: Lookup) -> Self {
        Self::new(scenes, |costs| {
            let own = Curve::new(&costs.points(Method::Paraboloid, Lookup::Paraboloid));
            let equal = own.at_equal_error(&Curve::new(&costs.points(method, lookup)))?;
            Some((equal.value(), equal.sign()))
        })
    }

    fn new(scenes: &[&SceneCosts], ratio: impl Fn(&SceneCosts) -> Option<(f64, &'static str)>) -> Self {
        let found = scenes.iter().filter_map(|costs| {
            let (ratio, sign) = ratio(costs).filter(|(ratio, _)| ratio.is_finite() && *ratio > 0.0)?;
            Some(Ratio { scene: costs.scene.clone(), triangles: costs.triangles, ratio, sign })
        });
        let scenes: Vec<Ratio> = found.collect();
        let mean = |least| {
            let of = scenes.iter().filter(|ratio| ratio.triangles >= least);
            geometric_mean(&of.map(|ratio| ratio.ratio).collect::<Vec<_>>())
        };
        Self { large: mean(LARGE_SCENE), all: mean(0), scenes }
    }

    /// The scene in which the library compares worst.
    #[must_use]
    pub fn worst(&self) -> Option<&Ratio> {
        self.scenes.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio))
    }

    /// The ratio of one scene.
    #[must_use]
    pub fn of(&self, scene: &str) -> Option<&Ratio> {
        self.scenes.iter().find(|ratio| ratio.scene == scene)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::cost::{Cost, LookupError, Rule};
    use crate::compare::timing::Summary;
    use approx::assert_relative_eq;
    use std::time::Duration;

    fn cost(method: Method, pair: u32, milliseconds: u64, wrong_ppm: f64) -> Cost {
        let median = Duration::from_millis(milliseconds);
        let time = Summary { median, min: median, max: median };
        Cost {
            method,
            budget: Budget::EqualTexels,
            pair,
            side: method.side(pair, Budget::EqualTexels),
            texels: 0,
            bytes: 0,
            gpu: time,
            cpu: time,
            runs: 1,
            errors: method.lookups().iter().map(|&lookup| LookupError { lookup, wrong_ppm, bias: None }).collect(),
            stages: None,
        }
    }

    fn scene(name: &str, triangles: usize, costs: Vec<Cost>) -> SceneCosts {
        SceneCosts { scene: name.to_owned(), triangles, rule: Rule::DoubleSided, costs, left_out: Vec::new() }
    }

    #[test]
    fn means_over_scenes() {
        let pair = |own, cube| vec![cost(Method::Paraboloid, 64, own, 10.0), cost(Method::Cube, 64, cube, 20.0)];
        let scenes = [scene("a", 1_000, pair(8, 4)), scene("b", 250_000, pair(2, 4)), scene("c", 10, vec![])];
        let scenes: Vec<&SceneCosts> = scenes.iter().collect();
        let ratios = Ratios::at_equal_size(&scenes, Method::Cube, Budget::EqualTexels, 64);
        assert_eq!(ratios.scenes.len(), 2);
        assert_relative_eq!(ratios.all.unwrap(), 1.0, max_relative = 1e-12);
        assert_relative_eq!(ratios.large.unwrap(), 0.5, max_relative = 1e-12);
        assert_eq!(ratios.worst().map(|worst| worst.scene.as_str()), Some("a"));
        assert!(ratios.of("c").is_none());
        // Twice as accurate at the one size there is.
        let equal = Ratios::at_equal_error(&scenes, Method::Cube, Lookup::CubePlane);
        assert_eq!(equal.of("b").map(|ratio| (ratio.ratio, ratio.sign)), Some((0.5, "<")));
        let none = Ratios::at_equal_size(&scenes, Method::Cube, Budget::EqualTexels, 128);
        assert_eq!((none.all, none.worst()), (None, None));
    }
}
