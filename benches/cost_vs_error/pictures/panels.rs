//! Curves: a panel for each scene, or one for all.

use super::Area;
use super::axis::Axis;
use super::series::{Entry, INK, Mark, Series, Shape, by_error, by_time, legend, legend_height};
use crate::figures::Figures;
use dual_paraboloid::compare::baselines::{Budget, Lookup, Method};
use dual_paraboloid::compare::cost::{Contestant, Cost, Point, SceneCosts, Timed, pareto_front};
use dual_paraboloid::compare::text::grouped;
use plotters::chart::ChartContext;
use plotters::prelude::*;
use std::cmp::Ordering;

/// Size of one panel among several, in pixels.
const PANEL: (u32, u32) = (420, 310);
const COLUMNS: u32 = 3;
/// Size of a panel that stands alone.
const SINGLE: (u32, u32) = (900, 510);
/// Pixels beside a legend.
const MARGIN: u32 = 16;
/// What marks the points that no other one beats in both time and error.
const FRONT: &str = "on the Pareto front";

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;

/// A picture of curves under one legend.
pub struct Panels<'a> {
    figures: &'a Figures,
    scenes: &'a [&'a SceneCosts],
    series: Vec<Series>,
    last: Option<&'static str>,
    rows: u32,
    panel: (u32, u32),
    columns: u32,
}

impl<'a> Panels<'a> {
    /// Time against error, a panel for each scene.
    pub fn by_error(figures: &'a Figures, scenes: &'a [&'a SceneCosts]) -> Self {
        Self { series: by_error(scenes), last: Some(FRONT), ..Self::by_time(figures, scenes) }
    }

    /// The map's time, a panel for each scene.
    pub fn by_time(figures: &'a Figures, scenes: &'a [&'a SceneCosts]) -> Self {
        let (series, rows) = (by_time(scenes), (scenes.len() as u32).div_ceil(COLUMNS));
        Self { figures, scenes, series, last: None, rows, panel: PANEL, columns: COLUMNS }
    }

    /// The map's time, one panel over all scenes.
    pub fn single(figures: &'a Figures, scenes: &'a [&'a SceneCosts]) -> Self {
        Self { rows: 1, panel: SINGLE, columns: 1, ..Self::by_time(figures, scenes) }
    }

    /// Size of the picture, in pixels.
    pub fn size(&self) -> (u32, u32) {
        let width = self.columns * self.panel.0;
        (width, self.legend_height(width) + self.panel.1 * self.rows)
    }

    fn legend_height(&self, width: u32) -> u32 {
        let labels: Vec<&str> = self.entries().iter().map(|(label, ..)| *label).collect();
        legend_height(&labels, width - 2 * MARGIN) + 10
    }

    fn entries(&self) -> Vec<Entry<'_>> {
        let lines = self.series.iter().rev();
        let lines = lines.map(|of| (of.label.as_str(), of.color, Mark::Line(of.width(), of.shape)));
        lines.chain(self.last.map(|label| (label, INK, Mark::Front))).collect()
    }

    /// Draws the legend, and returns the panels.
    fn split<'b>(&self, area: &Area<'b>) -> anyhow::Result<Vec<Area<'b>>> {
        let (head, body) = area.split_vertically(self.legend_height(area.dim_in_pixel().0));
        legend(&head.margin(0, 0, MARGIN, MARGIN), &self.entries())?;
        Ok(body.split_evenly((self.rows as usize, self.columns as usize)))
    }

    /// A point for each resolution, both logarithmic, and the Pareto front over all methods.
    pub fn error_against_time(&self, area: &Area) -> anyhow::Result<()> {
        for (panel, costs) in self.split(area)?.iter().zip(self.scenes) {
            let curves: Vec<Vec<Point>> = self.series.iter().map(|series| error_curve(costs, series)).collect();
            let all: Vec<Point> = curves.concat();
            let axes =
                (Axis::logarithmic(all.iter().map(|at| at.cost)), Axis::logarithmic(all.iter().map(|at| at.error)));
            let titles = (self.figures.lit_title(), self.figures.error_title());
            let mut chart = start(panel, &title(costs), axes, (&titles.0, &titles.1))?;
            for (series, points) in self.series.iter().zip(&curves) {
                draw_curve(&mut chart, series, &points.iter().map(|at| (at.cost, at.error)).collect::<Vec<_>>())?;
            }
            let front = pareto_front(&all).into_iter().map(|index| (all[index].cost, all[index].error));
            chart.draw_series(front.map(|at| Circle::new(at, 6, INK.stroke_width(1))))?;
        }
        Ok(())
    }

    /// Cubes with as many texels as the pair.
    pub fn time_against_resolution(&self, area: &Area) -> anyhow::Result<()> {
        for (panel, costs) in self.split(area)?.iter().zip(self.scenes) {
            let curves: Vec<Vec<(f64, f64)>> =
                self.series.iter().map(|series| of_method(costs, series.method)).collect();
            let all: Vec<(f64, f64)> = curves.concat();
            let x = Axis::logarithmic(all.iter().map(|at| at.0)).with_ticks(&self.figures.conditions.resolutions);
            let axes = (x, Axis::logarithmic(all.iter().map(|at| at.1)));
            let titles = ("texels across a hemisphere; cubes have as many in all", self.figures.time_title());
            let mut chart = start(panel, &title(costs), axes, titles)?;
            for (series, points) in self.series.iter().zip(&curves) {
                draw_curve(&mut chart, series, points)?;
            }
        }
        Ok(())
    }

    /// All scenes at the main resolution. Lines join the scenes that differ in the number alone.
    pub fn time_against_triangles(&self, area: &Area) -> anyhow::Result<()> {
        let (figures, scenes) = (self.figures, self.scenes);
        let time = |costs: &SceneCosts, series: &Series| {
            let cost = costs.find(series.method, Budget::EqualTexels, figures.main)?;
            Some((costs.triangles as f64, cost.milliseconds()))
        };
        let of =
            |series: &Series| -> Vec<(f64, f64)> { scenes.iter().filter_map(|costs| time(costs, series)).collect() };
        let all: Vec<(f64, f64)> = self.series.iter().flat_map(&of).collect();
        let axes = (Axis::logarithmic(all.iter().map(|at| at.0)), Axis::logarithmic(all.iter().map(|at| at.1)));
        let caption = format!("{} texels across a hemisphere, cubes with as many; lines: dense scenes", figures.main);
        let panel = &self.split(area)?[0];
        let mut chart = start(panel, &caption, axes, ("triangles", figures.time_title()))?;
        for series in &self.series {
            draw_marks(&mut chart, series, &of(series))?;
            let dense = scenes.iter().filter(|costs| costs.family() == "dense");
            let points: Vec<(f64, f64)> = dense.filter_map(|costs| time(costs, series)).collect();
            draw_curve(&mut chart, series, &sorted(points))?;
        }
        Ok(())
    }
}

/// Time of map and lookup against error, from the smallest map to the largest.
fn error_curve(costs: &SceneCosts, series: &Series) -> Vec<Point> {
    let of = |lookup: Lookup| costs.time_points(Contestant { method: series.method, lookup }, Timed::HEADLINE);
    let points = series.lookup.map(of).unwrap_or_default();
    points.into_iter().filter(|at| at.cost > 0.0).collect()
}

/// Time of a method's map against the resolution of the pair.
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
    draw_marks(chart, series, points)
}

fn draw_marks(chart: &mut Chart, series: &Series, points: &[(f64, f64)]) -> anyhow::Result<()> {
    let (color, points) = (series.color, points.iter().copied());
    match series.shape {
        Shape::Disc => chart.draw_series(points.map(|at| Circle::new(at, 3, color.filled())))?,
        Shape::Triangle => chart.draw_series(points.map(|at| TriangleMarker::new(at, 5, color.filled())))?,
        Shape::Cross => chart.draw_series(points.map(|at| Cross::new(at, 4, color.stroke_width(2))))?,
        Shape::Ring => chart.draw_series(points.map(|at| Circle::new(at, 4, color.stroke_width(1))))?,
    };
    Ok(())
}
