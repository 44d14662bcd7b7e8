//! How long each stage takes, a bar for each scene.

use super::Area;
use super::axis::Axis;
use super::series::{CUBE_MARK, INK, Mark, STAGES, legend};
use crate::figures::Figures;
use dual_paraboloid::compare::baselines::{Budget, Method};
use dual_paraboloid::compare::cost::{SceneCosts, Stages};
use dual_paraboloid::compare::timing::milliseconds;
use plotters::prelude::*;

const WIDTH: u32 = 900;
const BAR: u32 = 34;
/// Legend above and axis below the bars.
const AROUND: u32 = 120;

/// Size of a picture with this number of scenes.
pub fn size(scenes: usize) -> (u32, u32) {
    (WIDTH, AROUND + BAR * scenes as u32)
}

/// A bar of stages for each scene at the main resolution, and a mark at the culled cube's time with as many texels.
pub fn draw(area: &Area, figures: &Figures, scenes: &[&SceneCosts]) -> anyhow::Result<()> {
    let (head, body) = area.split_vertically(36);
    let bars = STAGES.map(|(name, color)| (name, color, Mark::Bar));
    let entries: Vec<_> = bars.into_iter().chain([(CUBE_MARK.0, CUBE_MARK.1, Mark::Tick)]).collect();
    legend(&head.margin(0, 0, 16, 16), &entries)?;
    let rows: Vec<Row> = scenes.iter().map(|costs| Row::new(figures, costs)).collect();
    let longest = rows.iter().map(Row::end).fold(0.0, f64::max);
    let names: Vec<String> = rows.iter().map(|row| row.scene.clone()).collect();
    let mut chart = ChartBuilder::on(&body)
        .margin(10)
        .margin_right(24)
        .x_label_area_size(44)
        .y_label_area_size(170)
        .build_cartesian_2d(Axis::from_zero(longest), Axis::names(&names))?;
    let title = format!("{}, {} texels across a hemisphere", figures.time_title(), figures.main);
    chart
        .configure_mesh()
        .x_desc(title)
        .disable_y_mesh()
        .bold_line_style(RGBColor(225, 225, 225))
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .label_style(("sans-serif", 13).into_font().color(&INK))
        .draw()?;
    for (place, row) in rows.iter().rev().enumerate() {
        let y = place as f64 + 0.5;
        let bars = row.bars().into_iter().zip(STAGES);
        chart.draw_series(
            bars.map(|((from, to), (_, color))| Rectangle::new([(from, y - 0.3), (to, y + 0.3)], color.filled())),
        )?;
        let mark = row
            .cube
            .map(|time| PathElement::new(vec![(time, y - 0.42), (time, y + 0.42)], CUBE_MARK.1.stroke_width(3)));
        chart.draw_series(mark)?;
    }
    Ok(())
}

/// What is drawn of a scene; times in milliseconds.
struct Row {
    scene: String,
    stages: Option<Stages>,
    cube: Option<f64>,
}

impl Row {
    fn new(figures: &Figures, costs: &SceneCosts) -> Self {
        let find = |method| costs.find(method, Budget::EqualTexels, figures.main);
        Self {
            scene: costs.scene.clone(),
            stages: find(Method::Paraboloid).and_then(|cost| cost.stages),
            cube: find(Method::Cube).map(|cost| cost.milliseconds()),
        }
    }

    /// Beginning and end of each stage.
    fn bars(&self) -> Vec<(f64, f64)> {
        let Some(stages) = self.stages else { return Vec::new() };
        let mut start = 0.0;
        let bar = |time| {
            let end = start + milliseconds(time);
            (std::mem::replace(&mut start, end), end)
        };
        stages.times().map(bar).to_vec()
    }

    fn end(&self) -> f64 {
        self.bars().last().map_or(0.0, |bar| bar.1).max(self.cube.unwrap_or(0.0))
    }
}
