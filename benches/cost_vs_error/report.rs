//! The figures as text: Markdown that reads well on a terminal.

mod errors;
mod readme;
mod scenes;

use crate::figures::{Figures, contestants, methods, rivals};
use dual_paraboloid::compare::baselines::{Budget, Method};
use dual_paraboloid::compare::cost::{
    Contestant, ERROR_FLOOR_PPM, ErrorPair, ErrorRatios, Origin, Ratio, RatioSummary, Ratios, SceneCosts, Timed,
};
use dual_paraboloid::compare::text::{Table, grouped};
use std::fmt::Write;

pub use errors::errors;
pub use readme::readme;
pub use scenes::details;

const NO_REAL_SCENES: &str = "\nThere are no real scenes: name their folder in DP_SCENES.\n";

/// The conditions, the main table, what is behind it, and a line for each scene.
pub fn summary(figures: &Figures) -> String {
    let mut text = format!(
        "# Cost against error\n\n{}; times: {}; {} samples, {} random orientations of all maps, seed {}, up to {} runs.\n",
        figures.adapter(),
        figures.conditions.clock,
        grouped(figures.conditions.samples as usize),
        figures.conditions.orientations,
        figures.conditions.seed,
        figures.conditions.runs
    );
    for rule in figures.rules() {
        let groups = figures.groups(rule);
        for (origin, scenes) in &groups {
            let _ = write!(
                text,
                "\n## {}, {rule}, R = {}\n\n{}",
                title(*origin),
                figures.main,
                main_table(figures, scenes)
            );
        }
        if !groups.iter().any(|(origin, _)| *origin == Origin::File) {
            text += NO_REAL_SCENES;
        }
    }
    let _ = write!(text, "\n{}\n", legend(figures));
    for rule in figures.rules() {
        for (origin, scenes) in figures.groups(rule) {
            let title = format!("{}, {rule}", title(origin));
            let _ = write!(text, "\n## Other times, {title}\n\n{}", other_times(figures, &scenes));
            let _ = write!(text, "\n## Map alone at equal size, {title}\n\n{}", equal_size(figures, &scenes));
            text += &scenes::tables(figures, &scenes, &title);
        }
    }
    if !figures.left_out.is_empty() {
        let _ = write!(text, "\n## Left out\n\n");
        figures.left_out.iter().for_each(|what| text += &format!("- {what}\n"));
    }
    text
}

fn title(origin: Origin) -> &'static str {
    match origin {
        Origin::File => "Real scenes",
        Origin::Code => "Scenes made in code",
    }
}

fn legend(figures: &Figures) -> String {
    let main = figures.main;
    format!(
        "\
All figures are this library's over the other's: below 1 it does better. *Time* is the {}, medians with all methods \
interleaved, where the other method is as wrong as this library at R = {main}: its curve of time against wrong answers, \
over the ladder {:?} with as many texels, is interpolated in logarithms. Where the curve doesn't reach that error there is \
a bound; columns `<` and `>` count upper and lower bounds. *Median* takes bounds for the ratio, with those that are lower \
bounds last; *mean* is geometric, of the ratios that are no bounds. *Wrong* are answers on the wrong side of a half \
against rays cast in double precision; their ratios have {ERROR_FLOOR_PPM} ppm added on both sides. *Equal texels*: six faces \
of a cube have as many as the pair; *equal bytes*: a light's maps take as many, error interpolated on the other's curve. \
*Pooled* is sum over sum; *wins* counts scenes where this library does better. The scenes `dense-*` count as one. Where \
nothing was wrong, curves have 3/n: {} ppm.",
        Timed::HEADLINE.name(&figures.conditions.screens),
        figures.conditions.resolutions,
        3e6 / f64::from(figures.conditions.samples),
    )
}

/// Against every other method and lookup: time at this library's error, error at equal texels and at equal bytes.
fn main_table(figures: &Figures, scenes: &[&SceneCosts]) -> Table {
    let mut head = vec!["against", "time: median", "worst", "in", "mean", "<", ">", "wins"];
    head.extend(["wrong, equal texels: median", "worst", "in", "mean", "pooled", "wins"]);
    head.extend(["wrong, equal bytes: median", "worst", "in", "mean", "pooled", "wins"]);
    let mut table = Table::new(&head);
    let main = figures.main;
    for rival in rivals(scenes) {
        let time = Ratios::new(scenes, |costs| costs.at_own_error(rival, Timed::HEADLINE, main)).summary();
        let errors = |of: fn(&SceneCosts, Contestant, u32) -> Option<ErrorPair>| {
            ErrorRatios::new(&scenes.iter().filter_map(|costs| of(costs, rival, main)).collect::<Vec<_>>())
        };
        let texels = errors(SceneCosts::errors_at_equal_texels);
        let bytes = errors(SceneCosts::errors_at_equal_bytes);
        let mut cells = vec![rival.name()];
        cells.extend(time_cells(&time));
        cells.extend([texels, bytes].iter().flat_map(error_cells));
        table.row(cells);
    }
    table
}

/// Median, worst, where, mean, bounds on either side and wins.
fn time_cells(time: &RatioSummary) -> [String; 7] {
    let all = time.exact + time.at_most + time.at_least;
    [
        or_dash(time.median.map(signed)),
        or_dash(time.worst.as_ref().map(|(_, ratio)| signed(*ratio))),
        family(&time.worst),
        or_dash(time.mean.map(ratio_text)),
        time.at_most.to_string(),
        time.at_least.to_string(),
        format!("{} of {all}", time.wins),
    ]
}

/// Median, worst, where, mean, pooled and wins.
fn error_cells(errors: &ErrorRatios) -> [String; 6] {
    [
        or_dash(errors.median.map(ratio_text)),
        or_dash(errors.worst.as_ref().map(|(_, ratio)| ratio_text(*ratio))),
        family(&errors.worst),
        or_dash(errors.mean.map(ratio_text)),
        or_dash(errors.pooled.map(ratio_text)),
        format!("{} of {}", errors.wins, errors.of),
    ]
}

fn family<T>(worst: &Option<(String, T)>) -> String {
    or_dash(worst.as_ref().map(|(name, _)| name.clone()))
}

/// Median and worst of every kind of time, at this library's error, and of the headline's over the range of errors that
/// both curves share.
fn other_times(figures: &Figures, scenes: &[&SceneCosts]) -> Table {
    let timed = Timed::all(figures.conditions.screens.len());
    let names =
        timed.iter().map(|timed| timed.name(&figures.conditions.screens)).chain(["headline, shared errors".to_owned()]);
    let titles: Vec<String> = ["against".to_owned()].into_iter().chain(names).collect();
    let mut table = Table::new(&titles.iter().map(String::as_str).collect::<Vec<_>>());
    for rival in rivals(scenes) {
        let cell = |of: &dyn Fn(&SceneCosts) -> Option<Ratio>| median_and_worst(&Ratios::new(scenes, of).summary());
        let mut cells = vec![rival.name()];
        cells.extend(timed.iter().map(|&timed| cell(&|costs| costs.at_own_error(rival, timed, figures.main))));
        cells.push(cell(&|costs| costs.at_equal_error(rival, Timed::HEADLINE)));
        table.row(cells);
    }
    table
}

/// Median and worst of the map's time alone, at each size.
fn equal_size(figures: &Figures, scenes: &[&SceneCosts]) -> Table {
    let mut titles = vec!["against".to_owned(), format!("equal side, R = {}", figures.main)];
    titles.extend(figures.conditions.resolutions.iter().map(|pair| format!("equal texels, R = {pair}")));
    let mut table = Table::new(&titles.iter().map(String::as_str).collect::<Vec<_>>());
    for method in methods(scenes).into_iter().filter(|method| *method != Method::Paraboloid) {
        let cell = |budget, pair| {
            median_and_worst(&Ratios::new(scenes, |costs| costs.at_equal_size(method, budget, pair)).summary())
        };
        let sides = if method.is_cube() { cell(Budget::EqualSide, figures.main) } else { or_dash(None) };
        let texels = figures.conditions.resolutions.iter().map(|&pair| cell(Budget::EqualTexels, pair));
        table.row([method.to_string(), sides].into_iter().chain(texels));
    }
    table
}

fn median_and_worst(summary: &RatioSummary) -> String {
    let worst = summary.worst.as_ref().map(|(_, ratio)| *ratio);
    or_dash(summary.median.zip(worst).map(|(median, worst)| format!("{} ({})", signed(median), signed(worst))))
}

fn ppm(value: f64) -> String {
    format!("{value:.0}")
}

fn time(milliseconds: f64) -> String {
    format!("{milliseconds:.3}")
}

fn signed(ratio: Ratio) -> String {
    format!("{}{}", ratio.sign(), ratio_text(ratio.value()))
}

fn ratio_text(ratio: f64) -> String {
    format!("{ratio:.2}")
}

fn or_dash(text: Option<String>) -> String {
    text.unwrap_or_else(|| "-".to_owned())
}
