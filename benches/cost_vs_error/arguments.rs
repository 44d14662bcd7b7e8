//! The command line.

use crate::figures::Conditions;
use clap::Parser;
use dual_paraboloid::compare::baselines::Method;
use dual_paraboloid::compare::cost::{LADDER, Rule};
use dual_paraboloid::compare::measure::{SCENES_IN_CODE, select_scenes};
use dual_paraboloid::compare::scene::{SceneError, scene_files, scenes_dir};
use dual_paraboloid::compare::text::parse_size;
use dual_paraboloid::compare::timing::Clock;
use std::path::PathBuf;
use std::time::Duration;

/// Cost against error: this library and other ways to make a point light's shadow map.
#[derive(Parser)]
#[command(name = "cost_vs_error")]
pub struct Arguments {
    /// Scenes, separated by commas: made in code (hall, few-large, many-small, many-small-N, dense-N, long-hall),
    /// files, or parts of the names of files in `DP_SCENES`. Without it, those of the comparison and all files
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub scenes: Vec<String>,
    /// Texels across each map of the pair, separated by commas; the ladder 64, 128, ... 4096 without it. Cubes have as
    /// many texels in all, and at the one nearest to 1024 there are cubes as wide too
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..))]
    pub resolution: Vec<u32>,
    /// Methods, separated by commas; all without it
    #[arg(long, value_name = "METHOD", value_delimiter = ',', default_values_t = Method::ALL)]
    pub methods: Vec<Method>,
    /// Which sides cast, separated by commas: double-sided, culled
    #[arg(long, value_name = "RULE", value_delimiter = ',', default_value = "double-sided")]
    pub rules: Vec<Rule>,
    /// Points of each scene to ask for their shadow
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(1..))]
    pub samples: u32,
    /// Random orientations of all maps that errors are counted in
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    pub orientations: u32,
    /// Number that the points and the orientations are drawn with
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// Pixels of the screens whose lookups are timed, separated by commas; the first is part of the headline's time
    #[arg(long, value_name = "WxH", value_delimiter = ',', default_value = "1920x1080,3840x2160", value_parser = parse_size)]
    pub screens: Vec<(u32, u32)>,
    /// Texels across each map of the pair at which this library's errors are counted by all definitions, separated by
    /// commas; those of the ladder from 256 to 2048 without it
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..))]
    pub own: Vec<u32>,
    /// Pixels of the scene's camera for these errors
    #[arg(long, value_name = "WxH", default_value = "1920x1080", value_parser = parse_size)]
    pub camera: (u32, u32),
    /// How often to make each map, and each pass over the screen, for the time it takes
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    pub runs: u32,
    /// How long that may take for each scene and resolution; then there are fewer runs, but at least five
    #[arg(long, value_name = "SECONDS", default_value = "3", value_parser = parse_seconds)]
    pub seconds: Duration,
    /// Write to a folder: tables, pictures, and the figures of each scene as soon as they are there
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Measure nothing: make tables and pictures of the figures that earlier runs wrote to these folders, separated by
    /// commas. Of a scene in several of them the last one's figures count
    #[arg(long, value_name = "DIR", value_delimiter = ',')]
    pub merge: Vec<PathBuf>,
    /// Only see whether everything works: two small scenes, tiny maps and screens, few points, one run
    #[arg(long)]
    pub quick: bool,
    /// What cargo says to a benchmark.
    #[arg(long, hide = true)]
    bench: bool,
}

fn parse_seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    seconds.ok_or_else(|| format!("{text:?} is no number of seconds"))
}

impl Arguments {
    /// The command line, filled in.
    pub fn read() -> Self {
        let mut arguments = Self::parse();
        if arguments.resolution.is_empty() {
            arguments.resolution = if arguments.quick { vec![32, 64] } else { LADDER.to_vec() };
        }
        if arguments.own.is_empty() {
            let middle = |resolution: &u32| arguments.quick || (256..=2048).contains(resolution);
            arguments.own = arguments.resolution.iter().copied().filter(middle).collect();
        }
        if !arguments.quick {
            return arguments;
        }
        if arguments.scenes.is_empty() {
            arguments.scenes = ["few-large", "many-small-20"].map(str::to_owned).to_vec();
        }
        let screens = vec![(64, 36), (96, 54)];
        Self { samples: 500, orientations: 2, camera: screens[0], screens, runs: 1, ..arguments }
    }

    /// What figures of several runs must have in common.
    pub fn conditions(&self, clock: Clock) -> Conditions {
        Conditions {
            clock,
            samples: self.samples,
            orientations: self.orientations,
            seed: self.seed,
            runs: self.runs,
            screens: self.screens.clone(),
            camera: self.camera,
            resolutions: self.resolution.clone(),
            own: self.own.clone(),
        }
    }

    /// The names of the scenes, for [`find_scene`](dual_paraboloid::compare::measure::find_scene).
    pub fn scene_names(&self) -> Result<Vec<String>, SceneError> {
        if !self.scenes.is_empty() {
            return select_scenes(&self.scenes);
        }
        let files = scenes_dir().map_or(Ok(Vec::new()), |folder| scene_files(&folder))?;
        let files = files.into_iter().map(|path| path.to_string_lossy().into_owned());
        Ok(SCENES_IN_CODE.map(str::to_owned).into_iter().chain(files).collect())
    }
}
