//! What is drawn in which color, and the legend.

use dual_paraboloid::compare::baselines::{Lookup, Method};
use plotters::coord::Shift;
use plotters::prelude::*;

/// A method, with the lookup whose errors are drawn.
#[derive(Clone, Copy)]
pub struct Series {
    pub method: Method,
    pub lookup: Option<Lookup>,
    pub label: &'static str,
    /// From the palette of Okabe and Ito, which color-blind people can tell apart.
    pub color: RGBColor,
}

const BLACK: RGBColor = RGBColor(0, 0, 0);
const ORANGE: RGBColor = RGBColor(230, 159, 0);
const SKY_BLUE: RGBColor = RGBColor(86, 180, 233);
const GREEN: RGBColor = RGBColor(0, 158, 115);
const BLUE: RGBColor = RGBColor(0, 114, 178);
const VERMILION: RGBColor = RGBColor(213, 94, 0);
const PURPLE: RGBColor = RGBColor(204, 121, 167);
const GREY: RGBColor = RGBColor(150, 150, 150);

const fn series(method: Method, lookup: Option<Lookup>, label: &'static str, color: RGBColor) -> Series {
    Series { method, lookup, label, color }
}

/// Curves of time against error. The cube has both its lookups, its variants the better one; what is drawn last is
/// on top.
pub const BY_ERROR: [Series; 7] = [
    series(Method::VertexWarp, Some(Lookup::VertexWarp), "vertex warp", SKY_BLUE),
    series(Method::CubeUnculled, Some(Lookup::CubePlane), "cube, not culled, plane bias", GREY),
    series(Method::CubeMultiview, Some(Lookup::CubePlane), "cube, multiview, plane bias", PURPLE),
    series(Method::CubeRouted, Some(Lookup::CubePlane), "cube, routed, plane bias", GREEN),
    series(Method::Cube, Some(Lookup::CubeHardware), "cube, constant bias", ORANGE),
    series(Method::Cube, Some(Lookup::CubePlane), "cube, plane bias", VERMILION),
    series(Method::Paraboloid, Some(Lookup::Paraboloid), "this library", BLUE),
];

/// Curves of time alone.
pub const BY_TIME: [Series; 7] = [
    series(Method::VertexWarp, None, "vertex warp", SKY_BLUE),
    series(Method::CubeUnculled, None, "cube, not culled", GREY),
    series(Method::CubeMultiview, None, "cube, multiview", PURPLE),
    series(Method::DepthView, None, "plain view", BLACK),
    series(Method::CubeRouted, None, "cube, routed", GREEN),
    series(Method::Cube, None, "cube", VERMILION),
    series(Method::Paraboloid, None, "this library", BLUE),
];

/// Route, split and depth.
pub const STAGES: [(&str, RGBColor); 3] = [("route", SKY_BLUE), ("split", ORANGE), ("depth", BLUE)];

/// Marks of the cube's time beside the stages.
pub const CUBE_MARK: (&str, RGBColor) = ("cube, all of it", VERMILION);

impl Series {
    /// Width of its line: this library's stands out.
    pub fn width(&self) -> u32 {
        if self.method == Method::Paraboloid { 3 } else { 2 }
    }
}

/// Ink of all text and axes.
pub const INK: RGBColor = RGBColor(40, 40, 40);

/// Half the height of a legend's line.
const HALF_LINE: i32 = 9;

/// Pixels that a letter of the legend takes, generously: the font is the viewer's.
const LETTER: i32 = 8;

/// How a legend marks an entry.
pub enum Mark {
    Line(u32),
    Bar,
    Tick,
    Ring,
}

/// Draws marks with their labels from left to right, and on the next line where there is no room.
pub fn legend<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    entries: &[(&str, RGBColor, Mark)],
) -> Result<(), DrawingAreaErrorKind<DB::ErrorType>> {
    let width = area.dim_in_pixel().0 as i32;
    let (mut x, mut y) = (0, HALF_LINE);
    for (label, color, mark) in entries {
        let needed = 40 + LETTER * label.chars().count() as i32;
        if x > 0 && x + needed > width {
            (x, y) = (0, y + 2 * HALF_LINE);
        }
        match mark {
            Mark::Line(stroke) => {
                area.draw(&PathElement::new(vec![(x, y), (x + 24, y)], color.stroke_width(*stroke)))?;
                area.draw(&Circle::new((x + 12, y), 3, color.filled()))?;
            }
            Mark::Bar => area.draw(&Rectangle::new([(x + 4, y - 5), (x + 20, y + 6)], color.filled()))?,
            Mark::Tick => {
                area.draw(&PathElement::new(vec![(x + 12, y - 8), (x + 12, y + 8)], color.stroke_width(3)))?
            }
            Mark::Ring => area.draw(&Circle::new((x + 12, y), 6, color.stroke_width(1)))?,
        }
        let style = ("sans-serif", 15).into_font().color(&INK);
        area.draw(&Text::new((*label).to_owned(), (x + 30, y - 7), style))?;
        x += needed;
    }
    Ok(())
}
