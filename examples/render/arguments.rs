//! The command line.

use crate::camera::View;
use crate::filter::FilterName;
use clap::Parser;
use glam::{UVec2, Vec3};
use std::path::PathBuf;

/// Render a scene with point-light shadows to a PNG.
#[derive(Parser)]
#[command(name = "render")]
pub struct Arguments {
    /// A .glb or .gltf file. Without one, a pillared hall made in code
    pub scene: Option<PathBuf>,
    /// Position of a light, in world units; may be given several times. Without one, the file's point lights, or else
    /// a place that suits the scene
    #[arg(long = "light", value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub lights: Vec<Vec3>,
    /// How far the lights reach. Without it, as far as the file says, or past the whole scene
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    pub range: Option<f32>,
    /// Texels across each hemisphere's map
    #[arg(long, value_name = "N", default_value_t = 512)]
    pub resolution: u32,
    /// How soft the shadows are
    #[arg(long, value_enum, default_value_t = FilterName::Sharp)]
    pub filter: FilterName,
    /// Radius of the lights in world units, for --filter soft. Without it, half a hundredth of their range
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    pub light_radius: Option<f32>,
    /// Where the camera is. Without it, where it suits the scene
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub camera: Option<Vec3>,
    /// What is in the middle of the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub look_at: Option<Vec3>,
    /// Vertical angle of view in degrees
    #[arg(long, value_name = "DEG", value_parser = angle_of_view)]
    pub fov: Option<f32>,
    /// Pixels of the picture
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x720")]
    pub size: UVec2,
    /// What to show
    #[arg(long, value_enum, default_value_t = View::Lit)]
    pub view: View,
    /// Write the first light's pair of depth maps too
    #[arg(long, value_name = "MAP.png")]
    pub map: Option<PathBuf>,
    /// Where to write the picture; folders are made
    #[arg(short, long, value_name = "OUT.png", default_value = "out/render.png")]
    pub output: PathBuf,
}

fn point(text: &str) -> Result<Vec3, String> {
    let wrong = || format!("{text:?} is not three finite numbers like 1.5,-2,0");
    let numbers: Vec<f32> =
        text.split(',').map(|number| number.trim().parse().map_err(|_| wrong())).collect::<Result<_, _>>()?;
    let point = Vec3::from_array(numbers.try_into().map_err(|_| wrong())?);
    if point.is_finite() { Ok(point) } else { Err(wrong()) }
}

fn angle_of_view(text: &str) -> Result<f32, String> {
    let degrees = text.parse().ok().filter(|degrees| (1.0..=170.0).contains(degrees));
    degrees.ok_or_else(|| format!("{text:?} is not an angle of 1 to 170 degrees"))
}

fn size(text: &str) -> Result<UVec2, String> {
    let pixels = text
        .split_once(['x', 'X'])
        .and_then(|(width, height)| Some(UVec2::new(width.parse().ok()?, height.parse().ok()?)))
        .filter(|pixels| pixels.min_element() > 0);
    pixels.ok_or_else(|| format!("{text:?} is not a width and a height like 1280x720"))
}
