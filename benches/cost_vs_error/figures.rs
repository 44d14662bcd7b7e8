//! All that was measured, and under which conditions.

use dual_paraboloid::compare::cost::{Rule, SceneCosts};
use dual_paraboloid::compare::timing::Clock;
use serde_json::{Value, json};

/// What the report and the pictures are made from.
pub struct Figures {
    /// Name and driver of the device.
    pub adapter: String,
    pub clock: Clock,
    pub samples: u32,
    pub seed: u64,
    pub runs: u32,
    pub resolutions: Vec<u32>,
    /// The resolution that pictures and tables of one size are of.
    pub main: u32,
    /// A few with each rule.
    pub scenes: Vec<SceneCosts>,
    /// What wasn't measured, and why.
    pub left_out: Vec<String>,
}

impl Figures {
    /// Rules that any scene was measured with.
    pub fn rules(&self) -> impl Iterator<Item = Rule> {
        Rule::ALL.into_iter().filter(|rule| self.of(*rule).next().is_some())
    }

    /// The scenes' figures under one rule.
    pub fn of(&self, rule: Rule) -> impl Iterator<Item = &SceneCosts> {
        self.scenes.iter().filter(move |costs| costs.rule == rule)
    }

    /// What the times are, with their unit: a title for axes and columns.
    pub fn time_title(&self) -> &'static str {
        match self.clock {
            Clock::Timestamps => "GPU time (ms)",
            Clock::Wall => "time, submit to idle (ms)",
        }
    }

    pub fn to_json(&self) -> Value {
        json!({
            "adapter": self.adapter,
            "clock": self.clock,
            "samples": self.samples,
            "seed": self.seed,
            "runs": self.runs,
            "main": self.main,
            "scenes": self.scenes,
            "left_out": self.left_out,
        })
    }
}

/// The one nearest to 1024, by factor.
pub fn main_resolution(resolutions: &[u32]) -> u32 {
    let far = |resolution: u32| (f64::from(resolution) / 1024.0).ln().abs();
    resolutions.iter().copied().min_by(|a, b| far(*a).total_cmp(&far(*b))).unwrap_or(1024)
}
