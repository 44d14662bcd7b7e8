//! What is drawn in which color and with which marks, and the legend.

use crate::figures::{contestants, methods};
use dual_paraboloid::compare::baselines::{Lookup, Method};
use dual_paraboloid::compare::cost::{Contestant, SceneCosts};
use plotters::coord::Shift;
use plotters::prelude::*;

/// A method, with the lookup whose errors are drawn.
#[derive(Clone)]
pub struct Series {
    pub method: Method,
    pub lookup: Option<Lookup>,
    pub label: String,
    pub color: RGBColor,
    pub shape: Shape,
}

/// The mark at a curve's points: one for each lookup of a method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    Disc,
    Triangle,
    Cross,
    Ring,
}

const SHAPES: [Shape; 4] = [Shape::Disc, Shape::Triangle, Shape::Cross, Shape::Ring];

const ORANGE: RGBColor = RGBColor(230, 159, 0);
const SKY_BLUE: RGBColor = RGBColor(86, 180, 233);
const BLUE: RGBColor = RGBColor(0, 114, 178);
const GREEN: RGBColor = RGBColor(0, 158, 115);
const VERMILION: RGBColor = RGBColor(213, 94, 0);

/// Colors of the methods, in their order: the palette of Okabe and Ito, which color-blind people can tell apart, and
/// further ones.
const PALETTE: [RGBColor; 10] = [
    BLUE,
    SKY_BLUE,
    VERMILION,
    ORANGE,
    GREEN,
    RGBColor(204, 121, 167),
    RGBColor(150, 150, 150),
    RGBColor(0, 0, 0),
    RGBColor(120, 80, 40),
    RGBColor(170, 170, 0),
];

/// The stages that are timed, and their colours.
pub const STAGES: [(&str, RGBColor); 4] = [("cull", SKY_BLUE), ("number", GREEN), ("bin", ORANGE), ("rasterise", BLUE)];

/// Marks of the cube's time beside the stages.
pub const CUBE_MARK: (&str, RGBColor) = ("cube, all of it", VERMILION);

/// Curves of time against error, one for each lookup of each method. What is drawn last is on top: this library.
pub fn by_error(scenes: &[&SceneCosts]) -> Vec<Series> {
    let series = |of: Contestant| {
        let place = of.method.lookups().iter().position(|lookup| *lookup == of.lookup).unwrap_or(0);
        Series {
            method: of.method,
            lookup: Some(of.lookup),
            label: of.name(),
            color: color(of.method),
            shape: SHAPES[place % SHAPES.len()],
        }
    };
    contestants(scenes).into_iter().rev().map(series).collect()
}

/// Curves of the map's time alone, one for each method.
pub fn by_time(scenes: &[&SceneCosts]) -> Vec<Series> {
    let series = |method: Method| {
        let label = if method == Method::Paraboloid { "this library".to_owned() } else { method.to_string() };
        Series { method, lookup: None, label, color: color(method), shape: Shape::Disc }
    };
    methods(scenes).into_iter().rev().map(series).collect()
}

fn color(method: Method) -> RGBColor {
    let place = Method::ALL.iter().position(|of| *of == method).unwrap_or(0);
    PALETTE[place % PALETTE.len()]
}

impl Series {
    /// Width of its line: this library's stands out.
    pub fn width(&self) -> u32 {
        if self.method == Method::Paraboloid { 3 } else { 1 }
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
    Line(u32, Shape),
    Bar,
    Tick,
    Front,
}

/// An entry of a legend.
pub type Entry<'a> = (&'a str, RGBColor, Mark);

/// Where entries go, from left to right and on the next line where there is no room; and the height of all.
fn layout(labels: &[&str], width: i32) -> (Vec<(i32, i32)>, i32) {
    let (mut x, mut y) = (0, HALF_LINE);
    let mut places = Vec::new();
    for label in labels {
        let needed = 40 + LETTER * label.chars().count() as i32;
        if x > 0 && x + needed > width {
            (x, y) = (0, y + 2 * HALF_LINE);
        }
        places.push((x, y));
        x += needed;
    }
    (places, y + HALF_LINE)
}

/// Height of a legend over so many pixels.
pub fn legend_height(labels: &[&str], width: u32) -> u32 {
    layout(labels, width as i32).1 as u32
}

/// Draws marks with their labels.
pub fn legend<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    entries: &[Entry],
) -> Result<(), DrawingAreaErrorKind<DB::ErrorType>> {
    let labels: Vec<&str> = entries.iter().map(|(label, ..)| *label).collect();
    let (places, _) = layout(&labels, area.dim_in_pixel().0 as i32);
    for ((label, color, mark), (x, y)) in entries.iter().zip(places) {
        match mark {
            Mark::Line(stroke, shape) => {
                area.draw(&PathElement::new(vec![(x, y), (x + 24, y)], color.stroke_width(*stroke)))?;
                match shape {
                    Shape::Disc => area.draw(&Circle::new((x + 12, y), 3, color.filled()))?,
                    Shape::Triangle => area.draw(&TriangleMarker::new((x + 12, y), 5, color.filled()))?,
                    Shape::Cross => area.draw(&Cross::new((x + 12, y), 4, color.stroke_width(2)))?,
                    Shape::Ring => area.draw(&Circle::new((x + 12, y), 4, color.stroke_width(1)))?,
                }
            }
            Mark::Bar => area.draw(&Rectangle::new([(x + 4, y - 5), (x + 20, y + 6)], color.filled()))?,
            Mark::Tick => {
                area.draw(&PathElement::new(vec![(x + 12, y - 8), (x + 12, y + 8)], color.stroke_width(3)))?
            }
            Mark::Front => area.draw(&Circle::new((x + 12, y), 6, color.stroke_width(1)))?,
        }
        let style = ("sans-serif", 15).into_font().color(&INK);
        area.draw(&Text::new((*label).to_owned(), (x + 30, y - 7), style))?;
    }
    Ok(())
}
