//! Time against error: the best of a method over its resolutions, and two methods at equal error.

/// Errors of the range that two curves share at which they are compared.
const SAMPLES: usize = 33;

/// What a method costs at one resolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Above 0, in any unit.
    pub time: f64,
    /// Above 0, in any unit.
    pub error: f64,
}

/// What a method needs for each error: its points that no other one beats in both, joined by straight lines in the
/// logarithms of time and error.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Time rises and error falls, both strictly.
    points: Vec<Point>,
}

/// One method's time over another's where both are equally wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EqualError {
    /// They share a range of errors.
    Ratio {
        /// The median over errors spread evenly, by their logarithm, over the range that both curves span.
        ratio: f64,
        /// The ends of that range.
        errors: (f64, f64),
    },
    /// The first is more accurate at its worst than the second at its best: the ratio at that error is at most this.
    AtMost(f64),
    /// The first is less accurate at its best than the second at its worst: the ratio at that error is at least this.
    AtLeast(f64),
}

impl EqualError {
    /// The ratio, or the bound of it.
    #[must_use]
    pub fn value(self) -> f64 {
        match self {
            Self::Ratio { ratio, .. } | Self::AtMost(ratio) | Self::AtLeast(ratio) => ratio,
        }
    }

    /// `""`, `"<"` or `">"`, for reports.
    #[must_use]
    pub fn sign(self) -> &'static str {
        match self {
            Self::Ratio { .. } => "",
            Self::AtMost(_) => "<",
            Self::AtLeast(_) => ">",
        }
    }
}

impl Curve {
    /// The curve through a method's points; those without a finite time and error above 0 are left out.
    #[must_use]
    pub fn new(points: &[Point]) -> Self {
        let usable = |point: &Point| [point.time, point.error].iter().all(|x| x.is_finite() && *x > 0.0);
        let points: Vec<Point> = points.iter().copied().filter(usable).collect();
        Self { points: pareto_front(&points).into_iter().map(|index| points[index]).collect() }
    }

    /// The time for an error between the curve's ends.
    #[must_use]
    pub fn time_at(&self, error: f64) -> Option<f64> {
        let after = self.points.iter().position(|point| point.error <= error)?;
        if after == 0 {
            return (self.points[0].error == error).then_some(self.points[0].time);
        }
        let (a, b) = (self.points[after - 1], self.points[after]);
        let share = (error / a.error).ln() / (b.error / a.error).ln();
        Some(a.time * (b.time / a.time).powf(share))
    }

    /// This curve's time over another's at equal error; `None` if either is empty.
    #[must_use]
    pub fn at_equal_error(&self, other: &Self) -> Option<EqualError> {
        let ((cheap, best), (other_cheap, other_best)) = (self.ends()?, other.ends()?);
        if cheap.error < other_best.error {
            return Some(EqualError::AtMost(cheap.time / other_best.time));
        }
        if best.error > other_cheap.error {
            return Some(EqualError::AtLeast(best.time / other_cheap.time));
        }
        let (low, high) = (best.error.max(other_best.error), cheap.error.min(other_cheap.error));
        let at = |sample| (low * (high / low).powf(sample as f64 / (SAMPLES - 1) as f64)).clamp(low, high);
        let ratio = |error| Some(self.time_at(error)? / other.time_at(error)?);
        let mut ratios: Vec<f64> = (0..SAMPLES).map(at).filter_map(ratio).collect();
        ratios.sort_by(f64::total_cmp);
        let ratio = *ratios.get(ratios.len() / 2)?;
        Some(EqualError::Ratio { ratio, errors: (low, high) })
    }

    /// The cheapest and the most accurate point.
    fn ends(&self) -> Option<(Point, Point)> {
        Some((*self.points.first()?, *self.points.last()?))
    }
}

/// Which points no other one beats in both time and error; their indices, the cheapest first.
#[must_use]
pub fn pareto_front(points: &[Point]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let key = |&index: &usize| (points[index].time, points[index].error);
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
        Curve::new(&points.iter().map(|&(time, error)| Point { time, error }).collect::<Vec<_>>())
    }

    #[test]
    fn only_points_that_none_beats_are_kept() {
        let points = [(3.0, 10.0), (1.0, 40.0), (2.0, 50.0), (4.0, 10.0), (1.0, 60.0), (0.0, 1.0), (9.0, f64::NAN)];
        assert_eq!(curve(&points), curve(&[(1.0, 40.0), (3.0, 10.0)]));
    }

    #[test]
    fn time_is_a_power_of_error_between_points() {
        // time = 8 / error^1.5
        let curve = curve(&[(1.0, 4.0), (8.0, 1.0)]);
        for error in [1.0, 1.7, 3.0, 4.0] {
            assert_relative_eq!(curve.time_at(error).unwrap(), 8.0 / error.powf(1.5), max_relative = 1e-12);
        }
        assert_eq!((curve.time_at(0.9), curve.time_at(4.1)), (None, None));
    }

    #[test]
    fn the_ratio_at_equal_error_is_that_of_shifted_curves() {
        let of = |factor: f64, errors: &[f64]| {
            curve(&errors.iter().map(|error| (factor * error.powf(-0.8), *error)).collect::<Vec<_>>())
        };
        let (a, b) = (of(3.0, &[100.0, 50.0, 20.0]), of(4.0, &[70.0, 10.0]));
        let Some(EqualError::Ratio { ratio, errors }) = a.at_equal_error(&b) else { panic!("they share errors") };
        assert_relative_eq!(ratio, 0.75, max_relative = 1e-9);
        assert_eq!(errors, (20.0, 70.0));
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
        assert_eq!(accurate.at_equal_error(&rough), Some(EqualError::AtMost(0.5)));
        assert_eq!(rough.at_equal_error(&accurate), Some(EqualError::AtLeast(2.0)));
        assert_eq!(rough.at_equal_error(&curve(&[])), None);
        let (touch, one) = (curve(&[(2.0, 10.0), (3.0, 5.0)]), curve(&[(6.0, 10.0)]));
        assert_eq!(touch.at_equal_error(&one), Some(EqualError::Ratio { ratio: 2.0 / 6.0, errors: (10.0, 10.0) }));
    }

    #[test]
    fn geometric_means() {
        assert_relative_eq!(geometric_mean(&[0.5, 2.0, 8.0]).unwrap(), 2.0, max_relative = 1e-12);
        assert_eq!(geometric_mean(&[]), None);
    }
}
