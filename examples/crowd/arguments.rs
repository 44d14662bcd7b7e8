//! The command line.

use clap::{Parser, value_parser};
use std::path::PathBuf;

/// Measure many lights over a crowd that moves, beside cube maps, and render some of its frames to PNGs.
#[derive(Parser)]
#[command(name = "crowd")]
pub struct Arguments {
    /// Lamps, in a grid over the plaza
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = value_parser!(u32).range(1..=256))]
    pub lights: u32,
    /// Figures on the plaza, of 990 triangles each
    #[arg(long, value_name = "N", default_value_t = 1000)]
    pub instances: u32,
    /// How many of them walk; all, if not given
    #[arg(long, value_name = "N")]
    pub walking: Option<u32>,
    /// How far a lamp reaches, in metres; the next one is 8 away
    #[arg(long, value_name = "M", default_value_t = 12.0)]
    pub range: f32,
    /// Frames to measure
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = value_parser!(u32).range(1..))]
    pub frames: u32,
    /// Texels across each hemisphere's map; the cubes have as many texels in all
    #[arg(long, value_name = "N", default_value_t = 512)]
    pub resolution: u32,
    /// Frames to render, evenly over a second
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub pictures: u32,
    /// Folder for the pictures; it is made
    #[arg(short, long, value_name = "DIR", default_value = "out/crowd")]
    pub output: PathBuf,
    /// Write the figures as JSON too
    #[arg(long, value_name = "OUT.json")]
    pub json: Option<PathBuf>,
}
