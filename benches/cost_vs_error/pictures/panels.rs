//! Curves: a panel for each scene, or one for all.

use super::Area;
use super::axis::Axis;
use super::series::{BY_ERROR, BY_TIME, INK, Mark, Series, legend};
use crate::figures::Figures;
use dual_paraboloid::compare::baselines::{Budget, Method};
use dual_paraboloid::compare::cost::{Cost, Point, SceneCosts, pareto_front};
use dual_paraboloid::compare::text::grouped;
use plotters::chart::ChartContext;
use plotters::prelude::*;
use std::cmp::Ordering;

/// Size of one panel among several, in pixels.
const PANEL: (u32, u32) = (420, 310);
const COLUMNS: u32 = 3;
const LEGEND: u32 = 46;
/// Size of a panel that stands alone, with its legend.
pub const SINGLE: (u32, u32) = (900, 560);

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;

/// What a series looks like in a scene; empty where it isn't in it.
type CurveOf<'a> = &'a dyn Fn(&SceneCosts, &Series) -> Vec<(f64, f64)>;

/// Size of a picture with this number of panels.
pub fn size(panels: usize) -> (u32, u32) {
    (COLUMNS * PANEL.0, LEGEND + PANEL.1 * (panels as u32).div_ceil(COLUMNS))
}

/// A panel for each scene: a point for each resolution, both logarithmic, and the Pareto front over all methods.
pub fn error_against_time(area: &Area, figures: &Figures, scenes: &[&SceneCosts]) -> anyhow::Result<()> {
    let curve = |costs: &SceneCosts, series: &Series| match series.lookup {
        Some(lookup) => in_order(&costs.points(series.method, lookup)),
        None => Vec::new(),
    };
    let front = ("on the Pareto front", INK, Mark::Ring);
    let panels = with_legend(area, scenes, &BY_ERROR, &curve, Some(front))?;
    for (panel, costs) in panels.iter().zip(scenes) {
        let curves: Vec<Vec<(f64, f64)>> = BY_ERROR.iter().map(|series| curve(costs, series)).collect();
        let all: Vec<(f64, f64)> = curves.concat();
        let axes = (Axis::logarithmic(all.iter().map(|at| at.0)), Axis::logarithmic(all.iter().map(|at| at.1)));
        let mut chart = start(panel, &title(costs), axes, (figures.time_title(), "wrong answers (ppm)"))?;
        for (series, points) in BY_ERROR.iter().zip(curves) {
            draw_curve(&mut chart, series, &points)?;
        }
        let points: Vec<Point> = all.iter().map(|&(time, error)| Point { time, error }).collect();
        let front: Vec<(f64, f64)> = pareto_front(&points).into_iter().map(|index| all[index]).collect();
        chart.draw_series(front.into_iter().map(|at| Circle::new(at, 6, INK.stroke_width(1))))?;
    }
    Ok(())
}

/// A panel for each scene, cubes with as many texels as the pair.
pub fn time_against_resolution(area: &Area, figures: &Figures, scenes: &[&SceneCosts]) -> anyhow::Result<()> {
    let curve = |costs: &SceneCosts, series: &Series| of_method(costs, series.method);
    let panels = with_legend(area, scenes, &BY_TIME, &curve, None)?;
    for (panel, costs) in panels.iter().zip(scenes) {
        let curves: Vec<Vec<(f64, f64)>> = BY_TIME.iter().map(|series| curve(costs, series)).collect();
        let all: Vec<(f64, f64)> = curves.concat();
        let x = Axis::logarithmic(all.iter().map(|at| at.0)).with_ticks(&figures.resolutions);
        let axes = (x, Axis::logarithmic(all.iter().map(|at| at.1)));
        let titles = ("texels across a hemisphere; cubes have as many in all", figures.time_title());
        let mut chart = start(panel, &title(costs), axes, titles)?;
        for (series, points) in BY_TIME.iter().zip(curves) {
            draw_curve(&mut chart, series, &points)?;
        }
    }
    Ok(())
}

/// One panel over all scenes, at the main resolution. Lines join the scenes that differ in the number alone.
pub fn time_against_triangles(area: &Area, figures: &Figures, scenes: &[&SceneCosts]) -> anyhow::Result<()> {
    let time = |costs: &SceneCosts, series: &Series| {
        let cost = costs.find(series.method, Budget::EqualTexels, figures.main)?;
        Some((costs.triangles as f64, cost.milliseconds()))
    };
    let curve = |costs: &SceneCosts, series: &Series| time(costs, series).into_iter().collect();
    let panel = &with_legend(area, scenes, &BY_TIME, &curve, None)?[0];
    let of = |series: &Series| -> Vec<(f64, f64)> { scenes.iter().filter_map(|costs| time(costs, series)).collect() };
    let all: Vec<(f64, f64)> = BY_TIME.iter().flat_map(&of).collect();
    let axes = (Axis::logarithmic(all.iter().map(|at| at.0)), Axis::logarithmic(all.iter().map(|at| at.1)));
    let caption = format!("{} texels across a hemisphere, cubes with as many; lines: dense scenes", figures.main);
    let mut chart = start(panel, &caption, axes, ("triangles", figures.time_title()))?;
    for series in &BY_TIME {
        chart.draw_series(of(series).into_iter().map(|at| Circle::new(at, 3, series.color.filled())))?;
        let dense = scenes.iter().filter(|costs| costs.scene.starts_with("dense-"));
        let points: Vec<(f64, f64)> = dense.filter_map(|costs| time(costs, series)).collect();
        draw_curve(&mut chart, series, &sorted(points))?;
    }
    Ok(())
}

/// Time against error from the smallest map to the largest.
fn in_order(points: &[Point]) -> Vec<(f64, f64)> {
    points.iter().filter(|at| at.time > 0.0 && at.error > 0.0).map(|at| (at.time, at.error)).collect()
}

/// Time of a method against the resolution of the pair.
fn of_method(costs: &SceneCosts, method: Method) -> Vec<(f64, f64)> {
    let point = |cost: &Cost| (f64::from(cost.pair), cost.milliseconds());
    let fits = |cost: &&Cost| cost.method == method && cost.budget == Budget::EqualTexels;
    sorted(costs.costs.iter().filter(fits).map(point).collect())
}

fn sorted(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
    points
}

fn title(costs: &SceneCosts) -> String {
    format!("{}, {} triangles", costs.scene, grouped(costs.triangles))
}

/// Draws the legend of the series that any scene has, and returns the panels.
fn with_legend<'a>(
    area: &Area<'a>,
    scenes: &[&SceneCosts],
    all: &[Series],
    curve: CurveOf,
    last: Option<(&'static str, RGBColor, Mark)>,
) -> anyhow::Result<Vec<Area<'a>>> {
    let (head, body) = area.split_vertically(LEGEND);
    let drawn = all.iter().rev().filter(|series| scenes.iter().any(|costs| !curve(costs, series).is_empty()));
    let entries = drawn.map(|series| (series.label, series.color, Mark::Line(series.width())));
    let entries: Vec<_> = entries.chain(last).collect();
    legend(&head.margin(0, 0, 16, 16), &entries)?;
    let (width, height) = body.dim_in_pixel();
    if (width, height + LEGEND) == SINGLE {
        return Ok(vec![body]);
    }
    Ok(body.split_evenly(((height / PANEL.1) as usize, COLUMNS as usize)))
}

/// A chart with its caption and axes.
fn start<'a, 'b>(
    area: &'a Area<'b>,
    caption: &str,
    (x, y): (Axis, Axis),
    (x_title, y_title): (&str, &str),
) -> anyhow::Result<Chart<'a, 'b>> {
    let mut chart = ChartBuilder::on(area)
        .caption(caption, ("sans-serif", 16).into_font().color(&INK))
        .margin(10)
        .margin_right(16)
        .x_label_area_size(44)
        .y_label_area_size(62)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .x_desc(x_title)
        .y_desc(y_title)
        .bold_line_style(RGBColor(225, 225, 225))
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .label_style(("sans-serif", 13).into_font().color(&INK))
        .draw()?;
    Ok(chart)
}

fn draw_curve(chart: &mut Chart, series: &Series, points: &[(f64, f64)]) -> anyhow::Result<()> {
    chart.draw_series(LineSeries::new(points.iter().copied(), series.color.stroke_width(series.width())))?;
    chart.draw_series(points.iter().map(|&at| Circle::new(at, 3, series.color.filled())))?;
    Ok(())
}
