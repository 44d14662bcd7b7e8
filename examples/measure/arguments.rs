//! The command line.

use crate::filter::FilterName;
use clap::{Parser, ValueEnum};
use dual_paraboloid::compare::baselines::{Lookup, Method};
use dual_paraboloid::compare::error_figures::SAMPLES;
use dual_paraboloid::compare::scene::STATED_SIZE;
use glam::Vec3;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// Measure the errors and the time of shadow maps of a scene.
#[derive(Parser)]
#[command(name = "measure")]
pub struct Arguments {
    /// A .glb or .gltf file, or a scene made in code: hall, few-large, many-small, many-small-N, dense-N (say
    /// dense-1m), long-hall
    pub scene: String,
    /// Position of the light, in world units. Without it, the scene's own point light, or else a place that suits it
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub light: Option<Vec3>,
    /// How far the light reaches. Without it, as far as the scene's own light does, or past the whole scene
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    pub range: Option<f32>,
    /// Texels across each square of a map: a hemisphere's, or a cube's face
    #[arg(long, value_name = "N", default_value_t = 1024)]
    pub resolution: u32,
    /// Texels of a map in all, the same for every method, in place of --resolution
    #[arg(long, value_name = "N", conflicts_with = "resolution", value_parser = clap::value_parser!(u64).range(1..))]
    pub texels: Option<u64>,
    /// Methods, separated by commas: paraboloid, vertex-warp, cube, cube-plane, cube-unculled, cube-16,
    /// cube-routed, cube-multiview, cube-compute, depth-view
    #[arg(long = "method", value_name = "METHOD", value_delimiter = ',', default_value = "paraboloid")]
    pub methods: Vec<Entry>,
    /// How `paraboloid` decides where the texels around a receiver disagree, and by which rule the ray-cast map beside it
    /// is read: by the triangles that they show, or by their votes alone
    #[arg(long, value_enum, default_value_t = Rule::Exact)]
    pub rule: Rule,
    /// How the lookup of `paraboloid` softens shadows
    #[arg(long, value_enum, default_value_t = FilterName::Sharp)]
    pub filter: FilterName,
    /// Radius of the light in world units, for --filter soft. Without it, half a hundredth of its range
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    pub light_radius: Option<f32>,
    /// Points of the scene to ask for their shadow, beside those that graze
    #[arg(long, value_name = "N", default_value_t = SAMPLES as u32, value_parser = clap::value_parser!(u32).range(1..))]
    pub samples: u32,
    /// Pixels of the view that errors at pixels are of
    #[arg(long, value_name = "WxH", value_parser = size, default_value_t = Size(STATED_SIZE))]
    pub size: Size,
    /// Number that the points are drawn with
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// How often to make each map for the time it takes
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    pub runs: u32,
    /// Write the figures: an object for one method, a list of them for several
    #[arg(long, value_name = "OUT.json")]
    pub json: Option<PathBuf>,
    /// Write pictures of where the errors are, to a folder
    #[arg(long, value_name = "DIR")]
    pub pictures: Option<PathBuf>,
}

/// How the library's lookup decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Rule {
    /// `dp_shadow` of the lookup without triangles.
    Votes,
    /// `dp_shadow`.
    Exact,
}

/// A row of the table: a method with one of its lookups.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    pub method: Method,
    /// None reads a depth view.
    pub lookup: Option<Lookup>,
}

impl Entry {
    pub fn name(self) -> &'static str {
        if self.is_cube_plane() { "cube-plane" } else { self.method.name() }
    }

    /// The lookup that is judged: `paraboloid` has the one of the light's filter, or that of the votes.
    pub fn judged(self, rule: Rule) -> Option<Lookup> {
        match (self.lookup, rule) {
            (Some(Lookup::Paraboloid), Rule::Exact) => Some(Lookup::Filtered),
            (Some(Lookup::Paraboloid), Rule::Votes) => Some(Lookup::Votes),
            (lookup, _) => lookup,
        }
    }

    /// Whether it has a time of its own; that of `cube-plane` is the time of `cube`.
    pub fn is_timed(self) -> bool {
        !self.is_cube_plane()
    }

    fn is_cube_plane(self) -> bool {
        self.method == Method::Cube && self.lookup == Some(Lookup::CubePlane)
    }

    /// Texels across one square of its map.
    pub fn side(self, arguments: &Arguments) -> u32 {
        arguments.texels.map_or(arguments.resolution, |texels| {
            let side = (texels as f64 / f64::from(self.method.squares())).sqrt().round();
            (side as u32).max(1)
        })
    }
}

impl FromStr for Entry {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        if name == "cube-plane" {
            return Ok(Self { method: Method::Cube, lookup: Some(Lookup::CubePlane) });
        }
        let method: Method = name.parse().map_err(|error| format!("{error}, cube-plane"))?;
        Ok(Self { method, lookup: method.lookups().first().copied() })
    }
}

/// Width and height in pixels.
#[derive(Debug, Clone, Copy)]
pub struct Size(pub [u32; 2]);

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [width, height] = self.0;
        write!(f, "{width}x{height}")
    }
}

fn size(text: &str) -> Result<Size, String> {
    let pixels = |text: &str| text.parse::<u32>().ok().filter(|pixels| (1..=4096).contains(pixels));
    let parsed = text.split_once('x').and_then(|(width, height)| Some([pixels(width)?, pixels(height)?]));
    parsed.map(Size).ok_or_else(|| format!("{text:?} is not like 1920x1080, with 1 to 4096 pixels each way"))
}

fn point(text: &str) -> Result<Vec3, String> {
    let wrong = || format!("{text:?} is not three finite numbers like 1.5,-2,0");
    let numbers: Vec<f32> =
        text.split(',').map(|number| number.trim().parse().map_err(|_| wrong())).collect::<Result<_, _>>()?;
    let point = Vec3::from_array(numbers.try_into().map_err(|_| wrong())?);
    if point.is_finite() { Ok(point) } else { Err(wrong()) }
}
