//! One method's errors over another's, over many scenes.

use super::geometric_mean;
use serde::Serialize;

/// Parts per million that are added to both errors of a ratio: below that an error is too small for its ratio to mean
/// anything.
pub const ERROR_FLOOR_PPM: f64 = 10.0;

/// Two methods' wrong answers in one scene, in parts per million.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorPair {
    /// What the scene counts as: scenes of one name count once.
    pub family: String,
    /// The library's.
    pub own_ppm: f64,
    /// The other's.
    pub other_ppm: f64,
}

/// The library's errors over another's: what is published together. Below 1 the library is less wrong.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ErrorRatios {
    /// The middle one of the families' ratios, the upper of two.
    pub median: Option<f64>,
    /// Geometric mean over the families.
    pub mean: Option<f64>,
    /// Sum of the library's errors over the sum of the other's. A family enters with its mean errors.
    pub pooled: Option<f64>,
    /// The family in which the library does worst, and its ratio.
    pub worst: Option<(String, f64)>,
    /// Families in which the library is less wrong; ties are none.
    pub wins: usize,
    /// How many families there are.
    pub of: usize,
}

/// `own` over `other`, both in parts per million and both with [`ERROR_FLOOR_PPM`] added.
#[must_use]
pub fn error_ratio(own_ppm: f64, other_ppm: f64) -> f64 {
    (own_ppm + ERROR_FLOOR_PPM) / (other_ppm + ERROR_FLOOR_PPM)
}

impl ErrorRatios {
    /// Of all scenes' errors.
    #[must_use]
    pub fn new(pairs: &[ErrorPair]) -> Self {
        let families: Vec<Family> = families(pairs);
        let ratios: Vec<f64> = families.iter().map(|family| family.ratio).collect();
        let sum = |of: fn(&Family) -> f64| families.iter().map(|family| of(family) + ERROR_FLOOR_PPM).sum::<f64>();
        let worst = families.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio));
        let mut sorted = ratios.clone();
        sorted.sort_by(f64::total_cmp);
        Self {
            median: sorted.get(sorted.len() / 2).copied(),
            mean: geometric_mean(&ratios),
            pooled: (!families.is_empty()).then(|| sum(|family| family.own_ppm) / sum(|family| family.other_ppm)),
            worst: worst.map(|family| (family.name.clone(), family.ratio)),
            wins: ratios.iter().filter(|ratio| **ratio < 1.0).count(),
            of: families.len(),
        }
    }
}

/// The scenes of one family.
struct Family {
    name: String,
    /// Geometric mean of their ratios.
    ratio: f64,
    /// Mean of the library's errors.
    own_ppm: f64,
    /// Mean of the other's errors.
    other_ppm: f64,
}

/// One entry for each family, in the order of their first scenes.
fn families(pairs: &[ErrorPair]) -> Vec<Family> {
    let mut names: Vec<&str> = Vec::new();
    for pair in pairs {
        if !names.contains(&pair.family.as_str()) {
            names.push(&pair.family);
        }
    }
    let family = |name: &str| {
        let of: Vec<&ErrorPair> = pairs.iter().filter(|pair| pair.family == name).collect();
        let ratios: Vec<f64> = of.iter().map(|pair| error_ratio(pair.own_ppm, pair.other_ppm)).collect();
        let mean = |error: fn(&ErrorPair) -> f64| of.iter().map(|pair| error(pair)).sum::<f64>() / of.len() as f64;
        let ratio = geometric_mean(&ratios)?;
        let (own_ppm, other_ppm) = (mean(|pair| pair.own_ppm), mean(|pair| pair.other_ppm));
        Some(Family { name: name.to_owned(), ratio, own_ppm, other_ppm })
    };
    names.into_iter().filter_map(family).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn pair(family: &str, own_ppm: f64, other_ppm: f64) -> ErrorPair {
        ErrorPair { family: family.to_owned(), own_ppm, other_ppm }
    }

    #[test]
    fn ten_parts_per_million_are_added_to_both() {
        assert_eq!(error_ratio(0.0, 0.0), 1.0);
        assert_eq!(error_ratio(0.0, 990.0), 0.01);
        assert_eq!(error_ratio(30.0, 10.0), 2.0);
    }

    #[test]
    fn five_figures_of_three_scenes() {
        // Ratios 0.5, 4 and 1; sums 10 + 390 + 90 + 30 over 30 + 90 + 90 + 30.
        let ratios = ErrorRatios::new(&[pair("a", 10.0, 30.0), pair("b", 390.0, 90.0), pair("c", 90.0, 90.0)]);
        assert_relative_eq!(ratios.mean.unwrap(), 2f64.cbrt(), max_relative = 1e-12);
        assert_relative_eq!(ratios.pooled.unwrap(), 520.0 / 240.0, max_relative = 1e-12);
        assert_eq!((ratios.median, ratios.worst), (Some(1.0), Some(("b".to_owned(), 4.0))));
        assert_eq!((ratios.wins, ratios.of), (1, 3));
        assert_eq!(ErrorRatios::new(&[]), ErrorRatios::default());
    }

    #[test]
    fn a_family_counts_once() {
        // Dense: ratios 20/80 and 80/70; mean errors 40 and 65.
        let ratios = ErrorRatios::new(&[pair("dense", 10.0, 70.0), pair("a", 30.0, 10.0), pair("dense", 70.0, 60.0)]);
        let dense = (0.25 * (80.0 / 70.0f64)).sqrt();
        assert_relative_eq!(ratios.mean.unwrap(), (dense * 2.0).sqrt(), max_relative = 1e-12);
        assert_relative_eq!(ratios.pooled.unwrap(), (50.0 + 40.0) / (75.0 + 20.0), max_relative = 1e-12);
        assert_eq!((ratios.wins, ratios.of), (1, 2));
    }
}
