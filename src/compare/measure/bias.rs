//! The best bias of a lookup for one scene and resolution.
//!
//! Two parts of the bias are tried together on a grid, which grows until the best lies within it; then the steps around
//! the best are halved twice.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::compare::baselines::{Bias, Lookup};

/// Answers that a thread scores at a time.
const CHUNK: usize = 1 << 14;

/// Places of the finest grid to a step of the first one: halved twice.
const FINEST: u32 = 4;

/// What one part of a bias is tried at: 0, and from `first` on by powers of `ratio`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Scale {
    first: f32,
    ratio: f32,
    /// Steps of the first grid, from 0 on.
    steps: u32,
    /// Steps that the grid may grow to.
    limit: u32,
}

impl Scale {
    /// The value at a place of the finest grid: even from 0 to `first`, then even in logarithms.
    fn at(&self, place: u32) -> f32 {
        let step = place as f32 / FINEST as f32;
        if step < 1.0 { step * self.first } else { self.first * self.ratio.powf(step - 1.0) }
    }
}

/// The two parts of a lookup's bias, and what they are tried at.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    scales: [Scale; 2],
    /// What the first part is given in: 1, or world units.
    unit: f32,
    bias: fn(f32, f32) -> Bias,
}

/// Texel footprints: 0, and 0.25 to 4 by powers of 2, at most 64.
const FOOTPRINTS: Scale = Scale { first: 0.25, ratio: 2.0, steps: 5, limit: 9 };

/// Texel footprints of comparisons with planes, which need little: 0, and 0.0125 to 0.8 by powers of 2, at most 51.2.
const SMALL_FOOTPRINTS: Scale = Scale { first: 0.0125, ratio: 2.0, steps: 7, limit: 13 };

/// Shares of the farthest receiver's distance: 0, and 1e-5 to 0.1, two to a decade, at most 1.
const SHARES: Scale = Scale { first: 1e-5, ratio: 3.162_277_7, steps: 9, limit: 11 };

impl Grid {
    /// What to try for a lookup where the farthest receiver is `reach` world units from the light; `None` for lookups
    /// whose bias is fixed.
    pub(super) fn new(lookup: Lookup, reach: f32) -> Option<Self> {
        match lookup {
            Lookup::VertexWarp | Lookup::CubeHardware => Some(Self {
                scales: [SHARES, FOOTPRINTS],
                unit: reach,
                bias: |depth, normal| Bias { depth, normal, ..Bias::default() },
            }),
            Lookup::CubePlane => Some(Self {
                scales: [SMALL_FOOTPRINTS; 2],
                unit: 1.0,
                bias: |ray, normal| Bias { ray, normal, ..Bias::default() },
            }),
            _ => None,
        }
    }

    fn bias(&self, [first, second]: [u32; 2]) -> Bias {
        (self.bias)(self.unit * self.scales[0].at(first), self.scales[1].at(second))
    }

    /// The biases that were tried, the best first, each by its [`Score`].
    pub(super) fn search(&self, score: impl FnMut(Bias) -> Score) -> Vec<Bias> {
        let mut search = Search { grid: self, score, tried: BTreeMap::new() };
        search.coarse();
        search.refine();
        let mut all: Vec<([u32; 2], Score)> = search.tried.into_iter().collect();
        all.sort_by(|a, b| a.1.compare(&b.1));
        all.into_iter().map(|(place, _)| self.bias(place)).collect()
    }
}

/// How wrong a lookup's answers are: by decisions, and where these are equally wrong by the distance from the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Score {
    /// Answers on the wrong side of a half.
    pub(super) wrong: usize,
    /// Sum of how far answers are from 0 (dark) or 1 (lit).
    off: f64,
}

impl Score {
    /// Of no answers.
    pub(super) const WORST: Self = Self { wrong: usize::MAX, off: f64::INFINITY };

    /// Of answers where the light reaches or not; `None` where an answer doesn't count.
    pub(super) fn new(values: &[f32], lit: &[Option<bool>]) -> Self {
        let parts = values.par_chunks(CHUNK).zip(lit.par_chunks(CHUNK)).map(|(values, lit)| Self::of_part(values, lit));
        // In their order, so that the sum is the same every time.
        parts.collect::<Vec<_>>().into_iter().fold(Self { wrong: 0, off: 0.0 }, Self::plus)
    }

    fn of_part(values: &[f32], lit: &[Option<bool>]) -> Self {
        let counted = values.iter().zip(lit).filter_map(|(value, lit)| Some((*value, (*lit)?)));
        let scores = counted.map(|(value, lit)| Self {
            wrong: usize::from((value >= 0.5) != lit),
            off: f64::from((value - f32::from(u8::from(lit))).abs()),
        });
        scores.fold(Self { wrong: 0, off: 0.0 }, Self::plus)
    }

    fn plus(self, other: Self) -> Self {
        Self { wrong: self.wrong + other.wrong, off: self.off + other.off }
    }

    pub(super) fn compare(&self, other: &Self) -> Ordering {
        self.wrong.cmp(&other.wrong).then(self.off.total_cmp(&other.off))
    }
}

struct Search<'a, F> {
    grid: &'a Grid,
    score: F,
    /// By places of the finest grid; of equally good ones the smallest bias comes first.
    tried: BTreeMap<[u32; 2], Score>,
}

impl<F: FnMut(Bias) -> Score> Search<'_, F> {
    fn attempt(&mut self, place: [u32; 2]) {
        if !self.tried.contains_key(&place) {
            let score = (self.score)(self.grid.bias(place));
            self.tried.insert(place, score);
        }
    }

    fn best(&self) -> [u32; 2] {
        let best = self.tried.iter().min_by(|a, b| a.1.compare(b.1));
        best.map_or([0; 2], |(place, _)| *place)
    }

    /// The first grid, and further steps of an axis while the best lies at its end.
    fn coarse(&mut self) {
        let mut last = self.grid.scales.map(|scale| scale.steps);
        loop {
            for first in 0..=last[0] {
                (0..=last[1]).for_each(|second| self.attempt([FINEST * first, FINEST * second]));
            }
            let best = self.best();
            let grows =
                [0, 1].map(|axis| best[axis] == FINEST * last[axis] && last[axis] < self.grid.scales[axis].limit);
            if grows == [false; 2] {
                return;
            }
            for axis in 0..2 {
                last[axis] += u32::from(grows[axis]);
            }
        }
    }

    /// Half steps and then quarter steps around the best, until none of them is better.
    fn refine(&mut self) {
        let limits = self.grid.scales.map(|scale| FINEST * scale.limit);
        for stride in [FINEST / 2, FINEST / 4] {
            loop {
                let centre = self.best();
                let around = |axis: usize| {
                    [centre[axis].saturating_sub(stride), centre[axis], (centre[axis] + stride).min(limits[axis])]
                };
                for first in around(0) {
                    around(1).into_iter().for_each(|second| self.attempt([first, second]));
                }
                if self.best() == centre {
                    break;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lookup whose errors grow with the distance from a known bias, in steps of the grid.
    fn found(lookup: Lookup, reach: f32, known: Bias) -> (Bias, Vec<Bias>) {
        let grid = Grid::new(lookup, reach).expect("a lookup with a bias");
        let mut tried = Vec::new();
        let distance = |a: f32, b: f32, least: f32| (f64::from(a.max(least)) / f64::from(b.max(least))).ln().abs();
        let all = grid.search(|bias| {
            tried.push(bias);
            let off = distance(bias.depth, known.depth, 1e-6 * reach)
                + distance(bias.ray, known.ray, 0.002)
                + distance(bias.normal, known.normal, 0.002);
            Score { wrong: (10.0 * off) as usize, off }
        });
        (all[0], tried)
    }

    fn close(a: f32, b: f32, factor: f32) -> bool {
        (a == 0.0 && b == 0.0) || (a / b).max(b / a) <= factor
    }

    #[test]
    fn the_known_bias_is_found() {
        let known = Bias { depth: 0.02, normal: 0.7, ..Bias::default() };
        let (bias, tried) = found(Lookup::CubeHardware, 20.0, known);
        // Half a finest step: sqrt(10)^(1/8), 2^(1/8).
        assert!(close(bias.depth, known.depth, 1.16) && close(bias.normal, known.normal, 1.1), "{bias:?}");
        // The first grid is 10 x 6.
        assert!(tried.len() < 100, "{}", tried.len());
        let plane = Bias { ray: 0.06, normal: 0.3, ..Bias::default() };
        let (bias, _) = found(Lookup::CubePlane, 20.0, plane);
        assert!(close(bias.ray, plane.ray, 1.1) && close(bias.normal, plane.normal, 1.1), "{bias:?}");
    }

    #[test]
    fn a_best_at_the_border_extends_the_grid() {
        let known = Bias { depth: 0.001, normal: 24.0, ..Bias::default() };
        let (bias, tried) = found(Lookup::VertexWarp, 1.0, known);
        assert!(close(bias.normal, known.normal, 1.1) && close(bias.depth, known.depth, 1.16), "{bias:?}");
        // Beyond the best too: it is inside.
        assert!(tried.iter().any(|bias| bias.normal == 32.0));
        assert!(tried.iter().all(|bias| bias.depth <= 0.11));
    }

    #[test]
    fn the_ends_are_0_and_the_limit() {
        let (bias, _) = found(Lookup::CubeHardware, 5.0, Bias::default());
        assert_eq!(bias, Bias::default());
        let far = Bias { depth: 1e3, normal: 1e6, ..Bias::default() };
        let (bias, tried) = found(Lookup::CubeHardware, 5.0, far);
        assert!(close(bias.depth, 5.0, 1.0001) && bias.normal == 64.0, "{bias:?}");
        assert!(tried.iter().all(|bias| bias.depth < 5.001 && bias.normal <= 64.0));
    }

    #[test]
    fn fixed_biases_have_no_grid() {
        for lookup in
            [Lookup::Paraboloid, Lookup::Votes, Lookup::Filtered, Lookup::VertexWarpShipped, Lookup::CubeShipped]
        {
            assert!(Grid::new(lookup, 1.0).is_none() && lookup.default_bias().is_none(), "{lookup:?}");
        }
    }

    #[test]
    fn scores_by_hand() {
        let lit = [Some(true), Some(true), None, Some(true), Some(false)];
        let score = Score::new(&[1.0, 0.75, 0.0, 0.25, 0.5], &lit);
        assert_eq!(score, Score { wrong: 2, off: 0.0 + 0.25 + 0.75 + 0.5 });
        let many = Score::new(&[0.25; 3 * CHUNK + 1], &[Some(true); 3 * CHUNK + 1]);
        assert_eq!(many, Score { wrong: 3 * CHUNK + 1, off: 0.75 * (3 * CHUNK + 1) as f64 }, "over several threads");
        let fewer = Score { wrong: 1, off: 9.0 };
        let nearer = Score { wrong: 2, off: 1.0 };
        assert_eq!([fewer.compare(&score), nearer.compare(&score)], [Ordering::Less; 2]);
    }
}
