//! The figures as pictures, in SVG.

mod axis;
mod panels;
mod series;
mod stages;

use crate::figures::Figures;
use anyhow::{anyhow, ensure};
use dual_paraboloid::compare::cost::{Rule, SceneCosts};
use panels::Panels;
use plotters::coord::Shift;
use plotters::prelude::*;
use series::INK;
use std::path::Path;

/// Height of a picture's title, in pixels.
const TITLE: u32 = 52;

/// Writes all pictures of all rules that were measured, and returns the files' names.
pub fn write_all(folder: &Path, figures: &Figures) -> anyhow::Result<Vec<String>> {
    let mut names = Vec::new();
    for rule in figures.rules() {
        let scenes: Vec<&SceneCosts> = figures.of(rule).collect();
        let page = Page { folder, figures, rule };
        let panels = Panels::by_error(figures, &scenes);
        names.push(
            page.write("error-time", panels.size(), "Error against time", |area| panels.error_against_time(area))?,
        );
        let panels = Panels::by_time(figures, &scenes);
        names.push(page.write("time-resolution", panels.size(), "The map's time against resolution", |area| {
            panels.time_against_resolution(area)
        })?);
        let panels = Panels::single(figures, &scenes);
        names.push(page.write("time-triangles", panels.size(), "The map's time against triangles", |area| {
            panels.time_against_triangles(area)
        })?);
        names.push(page.write("stages", stages::size(scenes.len()), "Time of the stages", |area| {
            stages::draw(area, figures, &scenes)
        })?);
    }
    Ok(names)
}

/// What all pictures of one rule have in common.
struct Page<'a> {
    folder: &'a Path,
    figures: &'a Figures,
    rule: Rule,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

impl Page<'_> {
    /// Writes one picture with its title, and returns the file's name.
    fn write(
        &self,
        name: &str,
        (width, height): (u32, u32),
        title: &str,
        draw: impl FnOnce(&Area) -> anyhow::Result<()>,
    ) -> anyhow::Result<String> {
        let file = format!("{name}-{}.svg", self.rule.name());
        let path = self.folder.join(&file);
        let root = SVGBackend::new(&path, (width, height + TITLE)).into_drawing_area();
        root.fill(&WHITE)?;
        let (head, body) = root.split_vertically(TITLE);
        let text = |text: String, y, size: u32| Text::new(text, (16, y), ("sans-serif", size).into_font().color(&INK));
        head.draw(&text(format!("{title}, {}", self.rule), 10, 20))?;
        head.draw(&text(format!("{}, {}", self.figures.adapter(), self.figures.conditions.clock), 34, 13))?;
        draw(&body)?;
        root.present().map_err(|error| anyhow!("can't write {}: {error}", path.display()))?;
        ensure!(path.is_file(), "{} was not written", path.display());
        Ok(file)
    }
}
