//! Tables with a line for each scene, and all figures.

use super::{contestants, methods, or_dash, ppm, rivals, signed, time};
use crate::figures::Figures;
use dual_paraboloid::compare::baselines::{Budget, Method};
use dual_paraboloid::compare::cost::{BreakEven, Contestant, Cost, LookupCost, SceneCosts, Timed};
use dual_paraboloid::compare::text::{Table, grouped};
use dual_paraboloid::compare::timing::{Summary, milliseconds};
use std::fmt::Write;

/// All tables by scene, at the main resolution.
pub fn tables(figures: &Figures, scenes: &[&SceneCosts], title: &str) -> String {
    let all = contestants(scenes);
    let names: Vec<String> = all.iter().map(|of| of.name()).collect();
    let rivals = rivals(scenes);
    let rival_names: Vec<String> = rivals.iter().map(|of| of.name()).collect();
    let method_names: Vec<String> = methods(scenes).iter().map(ToString::to_string).collect();
    let main = figures.main;
    let own = |costs: &SceneCosts, rival| or_dash(costs.at_own_error(rival, Timed::HEADLINE, main).map(signed));
    let find = |costs: &SceneCosts, method| costs.find(method, Budget::EqualTexels, main).cloned();
    let wrong = |costs: &SceneCosts, of: Contestant| {
        or_dash(find(costs, of.method).and_then(|cost| cost.wrong_ppm(of.lookup)).map(ppm))
    };
    let headline = |costs: &SceneCosts, of: Contestant| {
        or_dash(find(costs, of.method).and_then(|cost| cost.time(of.lookup, Timed::HEADLINE)).map(time))
    };
    let map = |costs: &SceneCosts, method| or_dash(find(costs, method).map(|cost| time(cost.milliseconds())));
    let mut text = String::new();
    let mut add = |what: &str, table: Table| {
        let _ = write!(text, "\n## {what}, {title}\n\n{table}");
    };
    add(&format!("Time at this library's error at R = {main}"), by_scene(scenes, &rival_names, &rivals, own));
    add(&format!("Wrong answers (ppm), equal texels, R = {main}"), by_scene(scenes, &names, &all, wrong));
    let what = format!("{} (ms), equal texels, R = {main}", Timed::HEADLINE.name(&figures.screens));
    add(&what, by_scene(scenes, &names, &all, headline));
    add(&format!("Map alone (ms), equal texels, R = {main}"), by_scene(scenes, &method_names, &methods(scenes), map));
    let even = |costs: &SceneCosts, of| or_dash(costs.break_even_at_own_error(of, main).map(break_even));
    let even_texels =
        |costs: &SceneCosts, method| or_dash(costs.break_even_at_equal_texels(method, main).map(break_even));
    add(&format!("MB: a light + the scene + workspace, R = {main}"), bytes(scenes, main));
    add(
        "Lights from which this library takes no more bytes, equal error",
        by_scene(scenes, &rival_names, &rivals, even),
    );
    let (other_names, others) = (&method_names[1.min(method_names.len())..], &methods(scenes)[..]);
    let others = &others[1.min(others.len())..];
    add(
        "Lights from which this library takes no more bytes, equal texels",
        by_scene(scenes, other_names, others, even_texels),
    );
    add(&format!("Stages (ms), R = {main}"), stages(scenes, main));
    text
}

/// A line for each scene, a column for each of `columns`.
fn by_scene<T: Copy>(
    scenes: &[&SceneCosts],
    names: &[String],
    columns: &[T],
    cell: impl Fn(&SceneCosts, T) -> String,
) -> Table {
    let head = ["scene", "triangles"].into_iter().chain(names.iter().map(String::as_str));
    let mut table = Table::new(&head.collect::<Vec<_>>());
    for costs in scenes {
        let own = [costs.scene.clone(), grouped(costs.triangles)];
        table.row(own.into_iter().chain(columns.iter().map(|&column| cell(costs, column))));
    }
    table
}

fn bytes(scenes: &[&SceneCosts], main: u32) -> Table {
    let all = methods(scenes);
    let names: Vec<String> = all.iter().map(ToString::to_string).collect();
    let megabytes = |bytes: u64| format!("{:.1}", bytes as f64 / 1e6);
    by_scene(scenes, &names, &all, |costs, method| {
        let bytes = costs.find(method, Budget::EqualTexels, main).map(|cost| cost.bytes);
        or_dash(bytes.map(|of| [of.per_light, of.scene, of.workspace].map(megabytes).join(" + ")))
    })
}

fn break_even(lights: BreakEven) -> String {
    match lights {
        BreakEven::Always => "1".to_owned(),
        BreakEven::From(lights) => grouped(lights as usize),
        BreakEven::UpTo(lights) => format!("up to {}", grouped(lights as usize)),
        BreakEven::Never => "never".to_owned(),
    }
}

fn stages(scenes: &[&SceneCosts], main: u32) -> Table {
    let mut table = Table::new(&["scene", "triangles", "route", "split", "depth", "recording, CPU us"]);
    for costs in scenes {
        let own = costs.find(Method::Paraboloid, Budget::EqualTexels, main);
        let Some((own, stages)) = own.and_then(|own| Some((own, own.stages?))) else { continue };
        let times = [stages.route, stages.split, stages.depth].map(|stage| time(milliseconds(stage)));
        let recording = format!("{:.0}", 1000.0 * milliseconds(own.cpu.median));
        table.row([costs.scene.clone(), grouped(costs.triangles)].into_iter().chain(times).chain([recording]));
    }
    table
}

/// Every figure: of each scene and rule a table of maps and one of lookups.
pub fn details(figures: &Figures) -> String {
    figures.scenes.iter().fold("\n# All figures\n".to_owned(), |text, costs| {
        let title = format!("{}, {} triangles, {}", costs.scene, grouped(costs.triangles), costs.rule);
        text + &format!("\n## {title}\n\n{}\n{}", maps(costs), lookups(figures, costs))
    })
}

fn maps(costs: &SceneCosts) -> Table {
    let mut table = Table::new(&[
        "map",
        "equal",
        "R",
        "side",
        "texels",
        "bytes a light",
        "of the scene",
        "workspace",
        "GPU ms",
        "min",
        "max",
        "CPU ms",
        "min",
        "max",
        "runs",
    ]);
    for cost in &costs.costs {
        let mut cells = place(cost);
        let bytes = [cost.texels, cost.bytes.per_light, cost.bytes.scene, cost.bytes.workspace];
        cells.extend(bytes.map(|count| grouped(count as usize)));
        cells.extend([cost.gpu, cost.cpu].iter().flat_map(three));
        cells.push(cost.runs.to_string());
        table.row(cells);
    }
    table
}

fn lookups(figures: &Figures, costs: &SceneCosts) -> Table {
    let mut head: Vec<String> =
        ["map", "equal", "R", "side", "lookup", "wrong", "min", "max"].map(str::to_owned).to_vec();
    for (width, height) in &figures.screens {
        for stage in ["compute", "fragment"] {
            head.extend([format!("{stage} {width}x{height} ms"), "min".to_owned(), "max".to_owned()]);
        }
    }
    let mut table = Table::new(&head.iter().map(String::as_str).collect::<Vec<_>>());
    for cost in &costs.costs {
        for of in &cost.lookups {
            let mut cells = place(cost);
            cells.push(of.lookup.name().to_owned());
            cells.extend([of.wrong_ppm, least(of), most(of)].map(ppm));
            cells.extend(
                of.screens.iter().flat_map(|screen| [screen.compute, screen.fragment]).flat_map(|of| three(&of)),
            );
            table.row(cells);
        }
    }
    table
}

/// The method and its size.
fn place(cost: &Cost) -> Vec<String> {
    let equal = match (cost.method.is_cube(), cost.budget) {
        (false, _) => "both",
        (true, Budget::EqualTexels) => "texels",
        (true, Budget::EqualSide) => "side",
    };
    vec![cost.method.to_string(), equal.to_owned(), cost.pair.to_string(), cost.side.to_string()]
}

/// Wrong answers in the best of the orientations.
fn least(of: &LookupCost) -> f64 {
    of.wrong_ppm_by_orientation.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Wrong answers in the worst of the orientations.
fn most(of: &LookupCost) -> f64 {
    of.wrong_ppm_by_orientation.iter().copied().fold(0.0, f64::max)
}

fn three(summary: &Summary) -> [String; 3] {
    [summary.median, summary.min, summary.max].map(|duration| time(milliseconds(duration)))
}
