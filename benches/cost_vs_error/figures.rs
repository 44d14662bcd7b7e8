//! All that was measured, and under which conditions.

use dual_paraboloid::compare::baselines::Method;
use dual_paraboloid::compare::cost::{Contestant, Origin, Rule, SceneCosts, Timed};
use dual_paraboloid::compare::timing::Clock;
use serde_json::{Value, json};

/// What the report and the pictures are made from.
pub struct Figures {
    /// Name and driver of the device.
    pub adapter: String,
    pub clock: Clock,
    pub samples: u32,
    pub orientations: u32,
    pub seed: u64,
    pub runs: u32,
    /// Pixels of the screens over which lookups were timed.
    pub screens: Vec<(u32, u32)>,
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

    /// The scenes of one rule in groups that are reported apart: real ones first, if there are any.
    pub fn groups(&self, rule: Rule) -> Vec<(Origin, Vec<&SceneCosts>)> {
        let of = |origin| (origin, self.of(rule).filter(|costs| costs.origin == origin).collect::<Vec<_>>());
        [Origin::File, Origin::Code].map(of).into_iter().filter(|(_, scenes)| !scenes.is_empty()).collect()
    }

    /// What the times are, with their unit: a title for axes and columns.
    pub fn time_title(&self) -> &'static str {
        match self.clock {
            Clock::Timestamps => "GPU time (ms)",
            Clock::Wall => "time, submit to idle (ms)",
        }
    }

    /// What the headline's time is: a title for axes.
    pub fn lit_title(&self) -> String {
        format!("{} (ms)", Timed::HEADLINE.name(&self.screens))
    }

    /// What errors are, and where they end: a title for axes.
    pub fn error_title(&self) -> String {
        format!("wrong answers (ppm), {} or more", 3e6 / f64::from(self.samples))
    }

    pub fn to_json(&self) -> Value {
        json!({
            "adapter": self.adapter,
            "clock": self.clock,
            "samples": self.samples,
            "orientations": self.orientations,
            "screens": self.screens,
            "seed": self.seed,
            "runs": self.runs,
            "main": self.main,
            "scenes": self.scenes,
            "left_out": self.left_out,
        })
    }
}

/// All methods with all their lookups that any scene has, in the order of the methods; this library first.
pub fn contestants(scenes: &[&SceneCosts]) -> Vec<Contestant> {
    let mut found: Vec<Contestant> = Vec::new();
    for contestant in scenes.iter().flat_map(|costs| costs.contestants()) {
        if !found.contains(&contestant) {
            found.push(contestant);
        }
    }
    let place = |of: &Contestant| Method::ALL.iter().position(|method| *method == of.method);
    found.sort_by_key(|of| (*of != Contestant::OWN, place(of)));
    found
}

/// [`contestants`] without this library.
pub fn rivals(scenes: &[&SceneCosts]) -> Vec<Contestant> {
    contestants(scenes).into_iter().filter(|of| *of != Contestant::OWN).collect()
}

/// All methods that any scene has, this library first.
pub fn methods(scenes: &[&SceneCosts]) -> Vec<Method> {
    let measured = |method: &Method| scenes.iter().any(|costs| costs.costs.iter().any(|cost| cost.method == *method));
    Method::ALL.into_iter().filter(measured).collect()
}

/// The one nearest to 1024, by factor.
pub fn main_resolution(resolutions: &[u32]) -> u32 {
    let far = |resolution: u32| (f64::from(resolution) / 1024.0).ln().abs();
    resolutions.iter().copied().min_by(|a, b| far(*a).total_cmp(&far(*b))).unwrap_or(1024)
}
