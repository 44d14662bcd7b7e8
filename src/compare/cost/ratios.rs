//! One method's time over another's, over many scenes.

use super::{Ratio, SceneCosts, geometric_mean};
use serde::Serialize;

/// The library's figure over another's in one scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneRatio {
    /// The scene's name.
    pub scene: String,
    /// What the scene counts as, see [`SceneCosts::family`].
    pub family: String,
    /// The ratio, or the bound of it: below 1 the library does better.
    pub ratio: Ratio,
}

/// The library's figure over another's, in all scenes where both have one.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Ratios {
    /// Scene by scene.
    pub scenes: Vec<SceneRatio>,
}

/// What is published of [`Ratios`]. Scenes of a family count once.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct RatioSummary {
    /// The middle one, the upper of two, with bounds taken for the ratio. What is at least something goes last, since it
    /// may be anything above.
    pub median: Option<Ratio>,
    /// The family in which the library does worst, and the ratio there.
    pub worst: Option<(String, Ratio)>,
    /// Geometric mean of the ratios that are no bounds.
    pub mean: Option<f64>,
    /// How many these are.
    pub exact: usize,
    /// Families with an upper bound.
    pub at_most: usize,
    /// Families with a lower bound.
    pub at_least: usize,
    /// Families where the library surely does better.
    pub wins: usize,
}

impl Ratios {
    /// The ratios of the scenes that have one.
    #[must_use]
    pub fn new(scenes: &[&SceneCosts], ratio: impl Fn(&SceneCosts) -> Option<Ratio>) -> Self {
        let found = scenes.iter().filter_map(|costs| {
            let ratio = ratio(costs).filter(|ratio| ratio.value().is_finite() && ratio.value() > 0.0)?;
            Some(SceneRatio { scene: costs.scene.clone(), family: costs.family().to_owned(), ratio })
        });
        Self { scenes: found.collect() }
    }

    /// The ratio of one scene.
    #[must_use]
    pub fn of(&self, scene: &str) -> Option<Ratio> {
        self.scenes.iter().find(|ratio| ratio.scene == scene).map(|of| of.ratio)
    }

    /// What is published of them.
    #[must_use]
    pub fn summary(&self) -> RatioSummary {
        let mut families = self.families();
        let rank = |ratio: Ratio| match ratio {
            Ratio::AtLeast(least) => (1, least),
            Ratio::Exact(value) | Ratio::AtMost(value) => (0, value),
        };
        families.sort_by(|a, b| {
            let ((kind, value), (other_kind, other)) = (rank(a.1), rank(b.1));
            kind.cmp(&other_kind).then(value.total_cmp(&other))
        });
        let count = |fits: fn(&Ratio) -> bool| families.iter().filter(|(_, ratio)| fits(ratio)).count();
        let exact: Vec<f64> = families.iter().filter_map(|(_, ratio)| ratio.exact()).collect();
        RatioSummary {
            median: families.get(families.len() / 2).map(|(_, ratio)| *ratio),
            worst: families.iter().max_by(|a, b| a.1.value().total_cmp(&b.1.value())).cloned(),
            mean: geometric_mean(&exact),
            exact: exact.len(),
            at_most: count(|ratio| matches!(ratio, Ratio::AtMost(_))),
            at_least: count(|ratio| matches!(ratio, Ratio::AtLeast(_))),
            wins: count(|ratio| ratio.value() < 1.0 && !matches!(ratio, Ratio::AtLeast(_))),
        }
    }

    /// One ratio for each family, in the order of their first scenes. A family with bounds on both sides has none.
    fn families(&self) -> Vec<(String, Ratio)> {
        let mut families: Vec<(String, Vec<Ratio>)> = Vec::new();
        for SceneRatio { family, ratio, .. } in &self.scenes {
            match families.iter_mut().find(|(name, _)| name == family) {
                Some((_, ratios)) => ratios.push(*ratio),
                None => families.push((family.clone(), vec![*ratio])),
            }
        }
        families.into_iter().filter_map(|(name, ratios)| Some((name, family_ratio(&ratios)?))).collect()
    }
}

/// The geometric mean of a family's ratios: a bound if any of them is one, `None` of bounds on both sides.
fn family_ratio(ratios: &[Ratio]) -> Option<Ratio> {
    let mean = geometric_mean(&ratios.iter().map(|ratio| ratio.value()).collect::<Vec<_>>())?;
    let any = |fits: fn(&Ratio) -> bool| ratios.iter().any(fits);
    match (any(|ratio| matches!(ratio, Ratio::AtMost(_))), any(|ratio| matches!(ratio, Ratio::AtLeast(_)))) {
        (false, false) => Some(Ratio::Exact(mean)),
        (true, false) => Some(Ratio::AtMost(mean)),
        (false, true) => Some(Ratio::AtLeast(mean)),
        (true, true) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn ratios(of: &[(&str, &str, Ratio)]) -> Ratios {
        let one = |&(scene, family, ratio): &(&str, &str, Ratio)| SceneRatio {
            scene: scene.to_owned(),
            family: family.to_owned(),
            ratio,
        };
        Ratios { scenes: of.iter().map(one).collect() }
    }

    #[test]
    fn bounds_are_counted_and_not_averaged() {
        let all = ratios(&[
            ("a", "a", Ratio::Exact(0.5)),
            ("b", "b", Ratio::Exact(2.0)),
            ("c", "c", Ratio::AtMost(0.001)),
            ("d", "d", Ratio::AtLeast(0.9)),
            ("e", "e", Ratio::AtMost(0.7)),
        ]);
        let summary = all.summary();
        assert_relative_eq!(summary.mean.unwrap(), 1.0, max_relative = 1e-12);
        assert_eq!((summary.exact, summary.at_most, summary.at_least, summary.wins), (2, 2, 1, 3));
        // In order: < 0.001, 0.5, < 0.7, 2, > 0.9.
        assert_eq!(summary.median, Some(Ratio::AtMost(0.7)));
        assert_eq!(summary.worst, Some(("b".to_owned(), Ratio::Exact(2.0))));
        assert_eq!(all.of("d"), Some(Ratio::AtLeast(0.9)));
        assert_eq!(Ratios::default().summary(), RatioSummary::default());
    }

    #[test]
    fn a_family_counts_once() {
        let all = ratios(&[
            ("dense-1m", "dense", Ratio::Exact(0.25)),
            ("hall", "hall", Ratio::Exact(1.0)),
            ("dense-4m", "dense", Ratio::Exact(1.0)),
        ]);
        let summary = all.summary();
        assert_relative_eq!(summary.mean.unwrap(), 0.5f64.sqrt(), max_relative = 1e-12);
        assert_eq!((summary.exact, summary.wins), (2, 1));
        assert_eq!(all.scenes.len(), 3);
    }

    #[test]
    fn a_family_with_a_bound_has_a_bound() {
        use Ratio::{AtLeast, AtMost, Exact};
        assert_eq!(family_ratio(&[Exact(1.0), AtMost(4.0)]), Some(AtMost(2.0)));
        assert_eq!(family_ratio(&[AtLeast(1.0), Exact(4.0)]), Some(AtLeast(2.0)));
        assert_eq!(family_ratio(&[AtLeast(1.0), AtMost(4.0)]), None);
    }
}
