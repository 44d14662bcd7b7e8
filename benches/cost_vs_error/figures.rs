//! All that was measured, and under which conditions.

use anyhow::{Context, ensure};
use dual_paraboloid::compare::baselines::Method;
use dual_paraboloid::compare::cost::{Contestant, Origin, Rule, SceneCosts, Timed};
use dual_paraboloid::compare::measure::SCENES_IN_CODE;
use dual_paraboloid::compare::timing::Clock;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// What is the same for all scenes that are set beside each other.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
pub struct Conditions {
    pub clock: Clock,
    pub samples: u32,
    pub orientations: u32,
    pub seed: u64,
    pub runs: u32,
    /// Pixels of the screens over which lookups were timed.
    pub screens: Vec<(u32, u32)>,
    /// Pixels of the camera for this library's errors.
    pub camera: (u32, u32),
    pub resolutions: Vec<u32>,
    /// Where this library's errors are counted by all definitions.
    pub own: Vec<u32>,
}

/// A scene under one rule, with all that its figures depend on: the contents of a file.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
pub struct Measured {
    /// Name and driver of the device.
    pub adapter: String,
    pub conditions: Conditions,
    pub costs: SceneCosts,
}

/// What the report and the pictures are made from.
pub struct Figures {
    pub conditions: Conditions,
    /// The resolution that pictures and tables of one size are of.
    pub main: u32,
    /// Names and drivers of the devices; more than one if several runs are set beside each other.
    pub adapters: Vec<String>,
    /// A few with each rule.
    pub scenes: Vec<SceneCosts>,
    /// What wasn't measured, and why.
    pub left_out: Vec<String>,
}

impl Measured {
    /// Writes it to a folder under a name of its own.
    pub fn write(&self, folder: &Path) -> anyhow::Result<()> {
        let path = folder.join(format!("{}-{}.json", self.costs.scene, self.costs.rule.name()));
        let text = format!("{:#}\n", serde_json::to_value(self)?);
        std::fs::write(&path, text).with_context(|| format!("can't write {}", path.display()))
    }

    /// All in these folders; of a scene in several the last one's.
    pub fn read_all(folders: &[PathBuf]) -> anyhow::Result<Vec<Self>> {
        let mut all: Vec<Self> = Vec::new();
        for folder in folders {
            for path in files(folder).with_context(|| format!("can't read {}", folder.display()))? {
                let text = std::fs::read(&path).with_context(|| format!("can't read {}", path.display()))?;
                let measured: Self = serde_json::from_slice(&text)
                    .with_context(|| format!("{} holds no figures of a scene", path.display()))?;
                let same = |of: &Self| (&of.costs.scene, of.costs.rule) == (&measured.costs.scene, measured.costs.rule);
                all.retain(|of| !same(of));
                all.push(measured);
            }
        }
        ensure!(!all.is_empty(), "there are no figures in the folders of --merge");
        Ok(all)
    }
}

/// The figures' files in a folder, by name.
fn files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
    let mut paths = entries.collect::<std::io::Result<Vec<_>>>()?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "json"));
    paths.sort();
    Ok(paths)
}

impl Figures {
    /// Nothing yet.
    pub fn new(conditions: Conditions, left_out: Vec<String>) -> Self {
        let main = main_resolution(&conditions.resolutions);
        Self { conditions, main, adapters: Vec::new(), scenes: Vec::new(), left_out }
    }

    /// Sets scenes beside each other, real ones by name and after those made in code.
    pub fn merge(all: Vec<Measured>) -> anyhow::Result<Self> {
        let mut figures = Self::new(all[0].conditions.clone(), Vec::new());
        for measured in all {
            let (scene, conditions) = (&measured.costs.scene, &measured.conditions);
            ensure!(*conditions == figures.conditions, "{scene} was measured under other conditions: {conditions:?}");
            figures.add(measured);
        }
        let in_code = |name: &str| SCENES_IN_CODE.iter().position(|of| *of == name).unwrap_or(SCENES_IN_CODE.len());
        figures.scenes.sort_by_key(|costs| (costs.origin == Origin::File, in_code(&costs.scene), costs.scene.clone()));
        Ok(figures)
    }

    /// Adds a scene.
    pub fn add(&mut self, measured: Measured) {
        let Measured { adapter, costs, .. } = measured;
        if !self.adapters.contains(&adapter) {
            self.adapters.push(adapter);
        }
        self.left_out.extend(costs.left_out.iter().map(|what| format!("{}, {}: {what}", costs.scene, costs.rule)));
        self.scenes.push(costs);
    }

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

    /// All devices.
    pub fn adapter(&self) -> String {
        self.adapters.join("; ")
    }

    /// What the times are, with their unit: a title for axes and columns.
    pub fn time_title(&self) -> &'static str {
        match self.conditions.clock {
            Clock::Timestamps => "GPU time (ms)",
            Clock::Wall => "time, submit to idle (ms)",
        }
    }

    /// What the headline's time is: a title for axes.
    pub fn lit_title(&self) -> String {
        format!("{} (ms)", Timed::HEADLINE.name(&self.conditions.screens))
    }

    /// What errors are, and where they end: a title for axes.
    pub fn error_title(&self) -> String {
        format!("wrong answers (ppm), {} or more", 3e6 / f64::from(self.conditions.samples))
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
