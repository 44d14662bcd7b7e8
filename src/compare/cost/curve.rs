//! Cost against error: the best of a method over its sizes, and two methods where they are equally wrong.

use serde::Serialize;

/// Errors of the range that two curves share at which they are compared.
const SAMPLES: usize = 33;

/// What a method costs at one size, and how wrong it is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Time or bytes; above 0, in any unit.
    pub cost: f64,
    /// Above 0, in any unit; see [`shown_error`].
    pub error: f64,
}

/// The error that a curve shows, in parts per million, for `wrong_ppm` found among `samples` answers.
///
/// It is 3/n at least: of n answers without any wrong one the error is below that with 95 % confidence (the rule of
/// three). So a method that was never wrong keeps its place on the curve, and no curve claims more than was sampled.
#[must_use]
pub fn shown_error(wrong_ppm: f64, samples: usize) -> f64 {
    wrong_ppm.max(3e6 / samples.max(1) as f64)
}

/// What a method needs for each error: its points that no other one beats in both, joined by straight lines in the
/// logarithms of cost and error.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Cost rises and error falls, both strictly.
    points: Vec<Point>,
}

/// A number read off a curve, or the bound that the curve's nearer end gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reading {
    /// Between the curve's ends.
    Exact(f64),
    /// Beyond an end: the method's own figure is at most this.
    AtMost(f64),
    /// Beyond an end: the method's own figure is at least this.
    AtLeast(f64),
}

/// One method's figure over another's where both are equal in something else.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ratio {
    /// Both curves reach the place where they are compared.
    Exact(f64),
    /// One doesn't reach it: the ratio is at most this.
    AtMost(f64),
    /// One doesn't reach it: the ratio is at least this.
    AtLeast(f64),
}

impl Ratio {
    /// The ratio, or the bound of it.
    #[must_use]
    pub fn value(self) -> f64 {
        match self {
            Self::Exact(ratio) | Self::AtMost(ratio) | Self::AtLeast(ratio) => ratio,
        }
    }

    /// The ratio, if it is no bound.
    #[must_use]
    pub fn exact(self) -> Option<f64> {
        match self {
            Self::Exact(ratio) => Some(ratio),
            Self::AtMost(_) | Self::AtLeast(_) => None,
        }
    }

    /// `""`, `"<"` or `">"`, for reports.
    #[must_use]
    pub fn sign(self) -> &'static str {
        match self {
            Self::Exact(_) => "",
            Self::AtMost(_) => "<",
            Self::AtLeast(_) => ">",
        }
    }

    /// `own` over what was read off another's curve.
    #[must_use]
    pub fn over(own: f64, other: Reading) -> Self {
        match other {
            Reading::Exact(other) => Self::Exact(own / other),
            Reading::AtMost(other) => Self::AtLeast(own / other),
            Reading::AtLeast(other) => Self::AtMost(own / other),
        }
    }
}

impl Curve {
    /// The curve through a method's points; those without a finite cost and error above 0 are left out.
    #[must_use]
    pub fn new(points: &[Point]) -> Self {
        let usable = |point: &Point| [point.cost, point.error].iter().all(|x| x.is_finite() && *x > 0.0);
        let points: Vec<Point> = points.iter().copied().filter(usable).collect();
        Self { points: pareto_front(&points).into_iter().map(|index| points[index]).collect() }
    }

    /// What an error of at most `error` costs; `None` of an empty curve. Above the cheapest point's error it is at most
    /// that one's cost, below the most accurate point's at least that one's.
    #[must_use]
    pub fn cost_at(&self, error: f64) -> Option<Reading> {
        let (cheap, best) = self.ends()?;
        if error > cheap.error {
            return Some(Reading::AtMost(cheap.cost));
        }
        let Some(after) = self.points.iter().position(|point| point.error <= error) else {
            return Some(Reading::AtLeast(best.cost));
        };
        let (a, b) = (self.points[after.saturating_sub(1)], self.points[after]);
        Some(Reading::Exact(interpolated((a.error, a.cost), (b.error, b.cost), error)))
    }

    /// The error for a cost of at most `cost`; `None` of an empty curve. Below the cheapest point it is at least that
    /// one's, beyond the dearest at most that one's.
    #[must_use]
    pub fn error_at(&self, cost: f64) -> Option<Reading> {
        let (cheap, best) = self.ends()?;
        if cost < cheap.cost {
            return Some(Reading::AtLeast(cheap.error));
        }
        let Some(after) = self.points.iter().position(|point| point.cost >= cost) else {
            return Some(Reading::AtMost(best.error));
        };
        let (a, b) = (self.points[after.saturating_sub(1)], self.points[after]);
        Some(Reading::Exact(interpolated((a.cost, a.error), (b.cost, b.error), cost)))
    }

    /// This curve's cost over another's at equal error: the median over errors spread evenly, by their logarithm, over
    /// the range that both curves span. Where they span none it is the bound at the error where they come closest.
    /// `None` if either is empty.
    #[must_use]
    pub fn at_equal_error(&self, other: &Self) -> Option<Ratio> {
        let ((cheap, best), (other_cheap, other_best)) = (self.ends()?, other.ends()?);
        if cheap.error < other_best.error {
            return Some(Ratio::AtMost(cheap.cost / other_best.cost));
        }
        if best.error > other_cheap.error {
            return Some(Ratio::AtLeast(best.cost / other_cheap.cost));
        }
        let (low, high) = (best.error.max(other_best.error), cheap.error.min(other_cheap.error));
        let at = |sample| (low * (high / low).powf(sample as f64 / (SAMPLES - 1) as f64)).clamp(low, high);
        let ratio = |error| match (self.cost_at(error)?, other.cost_at(error)?) {
            (Reading::Exact(own), Reading::Exact(other)) => Some(own / other),
            _ => None,
        };
        let mut ratios: Vec<f64> = (0..SAMPLES).map(at).filter_map(ratio).collect();
        ratios.sort_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).copied().map(Ratio::Exact)
    }

    /// The cheapest and the most accurate point.
    fn ends(&self) -> Option<(Point, Point)> {
        Some((*self.points.first()?, *self.points.last()?))
    }
}

/// The value at `x` of the power function through two points.
fn interpolated(a: (f64, f64), b: (f64, f64), x: f64) -> f64 {
    if a.0 == b.0 {
        return b.1;
    }
    let share = (x / a.0).ln() / (b.0 / a.0).ln();
    a.1 * (b.1 / a.1).powf(share)
}

/// Which points no other one beats in both cost and error; their indices, the cheapest first.
#[must_use]
pub fn pareto_front(points: &[Point]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let key = |&index: &usize| (points[index].cost, points[index].error);
    order.sort_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal));
    let mut least = f64::INFINITY;
    order.retain(|&index| {
        let better = points[index].error < least;
        least = least.min(points[index].error);
        better
    });
    order
}

/// The geometric mean; `None` of nothing.
#[must_use]
pub fn geometric_mean(values: &[f64]) -> Option<f64> {
    let sum: f64 = values.iter().map(|value| value.ln()).sum();
    (!values.is_empty()).then(|| (sum / values.len() as f64).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn curve(points: &[(f64, f64)]) -> Curve {
        Curve::new(&points.iter().map(|&(cost, error)| Point { cost, error }).collect::<Vec<_>>())
    }

    fn exact(reading: Option<Reading>) -> f64 {
        let Some(Reading::Exact(value)) = reading else { panic!("{reading:?} is no number on the curve") };
        value
    }

    #[test]
    fn only_points_that_none_beats_are_kept() {
        let points = [(3.0, 10.0), (1.0, 40.0), (2.0, 50.0), (4.0, 10.0), (1.0, 60.0), (0.0, 1.0), (9.0, f64::NAN)];
        assert_eq!(curve(&points), curve(&[(1.0, 40.0), (3.0, 10.0)]));
    }

    #[test]
    fn cost_and_error_are_powers_of_each_other_between_points() {
        // cost = 8 / error^1.5
        let curve = curve(&[(1.0, 4.0), (8.0, 1.0)]);
        for error in [1.0, 1.7, 3.0, 4.0] {
            let cost = exact(curve.cost_at(error));
            assert_relative_eq!(cost, 8.0 / error.powf(1.5), max_relative = 1e-12);
            assert_relative_eq!(exact(curve.error_at(cost)), error, max_relative = 1e-12);
        }
        assert_eq!(curve.cost_at(0.9), Some(Reading::AtLeast(8.0)));
        assert_eq!(curve.cost_at(4.1), Some(Reading::AtMost(1.0)));
        assert_eq!(curve.error_at(0.9), Some(Reading::AtLeast(4.0)));
        assert_eq!(curve.error_at(8.1), Some(Reading::AtMost(1.0)));
        assert_eq!((Curve::new(&[]).cost_at(1.0), Curve::new(&[]).error_at(1.0)), (None, None));
    }

    #[test]
    fn a_method_that_is_never_wrong_stays_on_its_curve() {
        assert_eq!(shown_error(0.0, 1_000_000), 3.0);
        assert_eq!(shown_error(0.0, 0), 3e6);
        assert_eq!(shown_error(1.0, 1_000_000), 3.0);
        assert_eq!(shown_error(7.5, 1_000_000), 7.5);
        let perfect = curve(&[1.0, 2.0, 4.0].map(|cost| (cost, shown_error(0.0, 1_000_000))));
        assert_eq!(perfect.cost_at(3.0), Some(Reading::Exact(1.0)));
        // Another one reaches that error at four times the cost, and a third one never.
        let late = curve(&[(1.0, 300.0), (2.0, 30.0), (4.0, shown_error(0.0, 1_000_000))]);
        assert_eq!(perfect.at_equal_error(&late), Some(Ratio::Exact(0.25)));
        assert_eq!(perfect.at_equal_error(&curve(&[(1.0, 300.0), (5.0, 6.0)])), Some(Ratio::AtMost(0.2)));
    }

    #[test]
    fn the_ratio_at_equal_error_is_that_of_shifted_curves() {
        let of = |factor: f64, errors: &[f64]| {
            curve(&errors.iter().map(|error| (factor * error.powf(-0.8), *error)).collect::<Vec<_>>())
        };
        let (a, b) = (of(3.0, &[100.0, 50.0, 20.0]), of(4.0, &[70.0, 10.0]));
        let Some(Ratio::Exact(ratio)) = a.at_equal_error(&b) else { panic!("they share errors") };
        assert_relative_eq!(ratio, 0.75, max_relative = 1e-9);
        let back = b.at_equal_error(&a).unwrap().value();
        assert_relative_eq!(back, 1.0 / 0.75, max_relative = 1e-9);
    }

    #[test]
    fn the_median_is_what_counts() {
        // Twice as slow at one end, a hundredth at the other, where it is steep for a short while.
        let a = curve(&[(2.0, 100.0), (4.0, 10.0), (4.1, 9.9), (400.0, 9.8)]);
        let b = curve(&[(1.0, 100.0), (2.0, 10.0), (2.1, 9.8)]);
        let ratio = a.at_equal_error(&b).unwrap().value();
        assert_relative_eq!(ratio, 2.0, max_relative = 1e-6);
    }

    #[test]
    fn curves_apart_give_bounds() {
        let (accurate, rough) = (curve(&[(3.0, 9.0), (5.0, 4.0)]), curve(&[(1.0, 80.0), (6.0, 10.0)]));
        assert_eq!(accurate.at_equal_error(&rough), Some(Ratio::AtMost(0.5)));
        assert_eq!(rough.at_equal_error(&accurate), Some(Ratio::AtLeast(2.0)));
        assert_eq!(rough.at_equal_error(&curve(&[])), None);
        let (touch, one) = (curve(&[(2.0, 10.0), (3.0, 5.0)]), curve(&[(6.0, 10.0)]));
        assert_eq!(touch.at_equal_error(&one), Some(Ratio::Exact(2.0 / 6.0)));
    }

    #[test]
    fn a_figure_over_a_reading() {
        assert_eq!(Ratio::over(3.0, Reading::Exact(2.0)), Ratio::Exact(1.5));
        // The other takes at least 2, so that this is at most 1.5 times as much.
        assert_eq!(Ratio::over(3.0, Reading::AtLeast(2.0)), Ratio::AtMost(1.5));
        assert_eq!(Ratio::over(3.0, Reading::AtMost(2.0)), Ratio::AtLeast(1.5));
        assert_eq!([Ratio::Exact(1.0), Ratio::AtMost(1.0), Ratio::AtLeast(1.0)].map(Ratio::sign), ["", "<", ">"]);
    }

    #[test]
    fn geometric_means() {
        assert_relative_eq!(geometric_mean(&[0.5, 2.0, 8.0]).unwrap(), 2.0, max_relative = 1e-12);
        assert_eq!(geometric_mean(&[]), None);
    }
}
