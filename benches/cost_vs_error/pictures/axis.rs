//! Axes with ticks at round numbers, logarithmic or not.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use std::ops::Range;

/// Ticks that an axis has at most.
const MOST_TICKS: usize = 9;

/// One axis of a chart.
#[derive(Debug, Clone)]
pub struct Axis {
    range: Range<f64>,
    is_logarithmic: bool,
    ticks: Vec<(f64, String)>,
}

impl Axis {
    /// A logarithmic axis around values above 0, with room at both ends.
    pub fn logarithmic(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), value| (low.min(value), high.max(value)));
        let (low, high) = if low <= high && low > 0.0 { (low / 1.25, high * 1.25) } else { (0.5, 2.0) };
        let ticks = decade_ticks(low, high).into_iter().map(|value| (value, short(value))).collect();
        Self { range: low..high, is_logarithmic: true, ticks }
    }

    /// An axis from 0 to a little more than `high`.
    pub fn from_zero(high: f64) -> Self {
        let high = if high > 0.0 { 1.05 * high } else { 1.0 };
        let step = round_step(high / 6.0);
        let ticks = (0..).map(|k| f64::from(k) * step).take_while(|value| *value <= high);
        Self { range: 0.0..high, is_logarithmic: false, ticks: ticks.map(|value| (value, short(value))).collect() }
    }

    /// Names in a column from the top down, one a unit; the first is around `names.len() - 0.5`.
    pub fn names(names: &[String]) -> Self {
        let count = names.len() as f64;
        let ticks = names.iter().enumerate().map(|(k, name)| (count - 0.5 - k as f64, name.clone())).collect();
        Self { range: 0.0..count.max(1.0), is_logarithmic: false, ticks }
    }

    /// The same axis with ticks at these values and nowhere else.
    pub fn with_ticks(self, values: &[u32]) -> Self {
        let inside = values.iter().filter(|&&value| self.range.contains(&f64::from(value)));
        Self { ticks: inside.map(|&value| (f64::from(value), value.to_string())).collect(), ..self }
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let Range { start, end } = self.range;
        let share = if self.is_logarithmic {
            (value / start).ln() / (end / start).ln()
        } else {
            (value - start) / (end - start)
        };
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.iter().map(|(value, _)| *value).collect()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        self.ticks.iter().find(|(tick, _)| tick == value).map(|(_, text)| text.clone()).unwrap_or_default()
    }
}

/// As many round numbers between two as there is room for.
fn decade_ticks(low: f64, high: f64) -> Vec<f64> {
    let decades = (low.log10().floor() as i32)..=(high.log10().ceil() as i32);
    let within = |steps: &[f64]| -> Vec<f64> {
        let all = decades.clone().flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)));
        all.filter(|value| (low..=high).contains(value)).collect()
    };
    let candidates = [&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0][..], &[1.0, 2.0, 5.0], &[1.0, 3.0]];
    candidates.into_iter().map(within).find(|ticks| ticks.len() <= MOST_TICKS).unwrap_or_else(|| within(&[1.0]))
}

/// The round number just above.
fn round_step(least: f64) -> f64 {
    let decade = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|step| step * decade).find(|step| *step >= least).unwrap_or(10.0 * decade)
}

/// A round number in few letters: 0.25, 40, 2k, 17M.
fn short(value: f64) -> String {
    let (value, unit) = match value {
        value if value >= 1e6 => (value / 1e6, "M"),
        value if value >= 1e3 => (value / 1e3, "k"),
        value => (value, ""),
    };
    // Three digits, without zeros at the end.
    let text = format!("{value:.3}");
    format!("{}{unit}", text.trim_end_matches('0').trim_end_matches('.'))
}
