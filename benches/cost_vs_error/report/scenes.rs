//! Tables with a line for each scene, and all figures.

use super::{contestants, methods, or_dash, ppm, rivals, signed, time};
use crate::figures::Figures;
use dual_paraboloid::compare::baselines::{Budget, Method};
use dual_paraboloid::compare::cost::{BreakEven, Contestant, Cost, LookupCost, SceneCosts, Timed};
use dual_paraboloid::compare::text::{Table, grouped};
use dual_paraboloid::compare::timing::{Summary, milliseconds};

/// All tables by scene, at the main resolution.
pub fn tables(figures: &Figures, scenes: &[&SceneCosts], title: &str) -> String {
    let main = figures.main;
    let headline = Timed::HEADLINE.name(&figures.conditions.screens);
    let tables = [
        (format!("Time at this library's error at R = {main}"), times_at_own_error(scenes, main)),
        (format!("Wrong answers (ppm), equal texels, R = {main}"), wrong_answers(scenes, main)),
        (format!("{headline} (ms), equal texels, R = {main}"), headline_times(scenes, main)),
        (format!("Map alone (ms), equal texels, R = {main}"), map_times(scenes, main)),
        (format!("MB: a light + the scene + workspace, equal texels, R = {main}"), bytes(scenes, main)),
        ("Lights with which this library takes no more bytes, equal texels".to_owned(), even_at_texels(scenes, main)),
        ("Lights with which this library takes no more bytes, equal error".to_owned(), even_at_error(scenes, main)),
        (format!("Stages (ms), R = {main}"), stages(scenes, main)),
    ];
    tables.iter().fold(String::new(), |text, (what, table)| text + &format!("\n## {what}, {title}\n\n{table}"))
}

fn times_at_own_error(scenes: &[&SceneCosts], main: u32) -> Table {
    by_scene(scenes, &rivals(scenes), Contestant::name, |costs, rival| {
        costs.at_own_error(rival, Timed::HEADLINE, main).map(signed)
    })
}

fn wrong_answers(scenes: &[&SceneCosts], main: u32) -> Table {
    by_scene(scenes, &contestants(scenes), Contestant::name, |costs, of| {
        costs.find(of.method, Budget::EqualTexels, main)?.wrong_ppm(of.lookup).map(ppm)
    })
}

fn headline_times(scenes: &[&SceneCosts], main: u32) -> Table {
    by_scene(scenes, &contestants(scenes), Contestant::name, |costs, of| {
        costs.find(of.method, Budget::EqualTexels, main)?.time(of.lookup, Timed::HEADLINE).map(time)
    })
}

fn map_times(scenes: &[&SceneCosts], main: u32) -> Table {
    by_scene(scenes, &methods(scenes), method_name, |costs, method| {
        costs.find(method, Budget::EqualTexels, main).map(|cost| time(cost.milliseconds()))
    })
}

fn bytes(scenes: &[&SceneCosts], main: u32) -> Table {
    let megabytes = |bytes: u64| format!("{:.1}", bytes as f64 / 1e6);
    by_scene(scenes, &methods(scenes), method_name, |costs, method| {
        let bytes = costs.find(method, Budget::EqualTexels, main)?.bytes;
        Some([bytes.per_light, bytes.scene, bytes.workspace].map(megabytes).join(" + "))
    })
}

fn even_at_texels(scenes: &[&SceneCosts], main: u32) -> Table {
    let others: Vec<Method> = methods(scenes).into_iter().filter(|method| *method != Method::Paraboloid).collect();
    by_scene(scenes, &others, method_name, |costs, method| {
        costs.break_even_at_equal_texels(method, main).map(break_even)
    })
}

fn even_at_error(scenes: &[&SceneCosts], main: u32) -> Table {
    by_scene(scenes, &rivals(scenes), Contestant::name, |costs, rival| {
        costs.break_even_at_own_error(rival, main).map(break_even)
    })
}

fn method_name(method: Method) -> String {
    method.to_string()
}

/// A line for each scene, a column for each of `columns`.
fn by_scene<T: Copy>(
    scenes: &[&SceneCosts],
    columns: &[T],
    name: impl Fn(T) -> String,
    cell: impl Fn(&SceneCosts, T) -> Option<String>,
) -> Table {
    let names: Vec<String> = columns.iter().map(|&column| name(column)).collect();
    let head = ["scene", "triangles"].into_iter().chain(names.iter().map(String::as_str));
    let mut table = Table::new(&head.collect::<Vec<_>>());
    for costs in scenes {
        let own = [costs.scene.clone(), grouped(costs.triangles)];
        table.row(own.into_iter().chain(columns.iter().map(|&column| or_dash(cell(costs, column)))));
    }
    table
}

fn break_even(lights: BreakEven) -> String {
    match lights {
        BreakEven::Always => "any".to_owned(),
        BreakEven::From(lights) => format!("from {}", grouped(lights as usize)),
        BreakEven::UpTo(lights) => format!("up to {}", grouped(lights as usize)),
        BreakEven::Never => "never".to_owned(),
    }
}

fn stages(scenes: &[&SceneCosts], main: u32) -> Table {
    let mut table = Table::new(&["scene", "triangles", "cull", "number", "bin", "rasterise", "recording, CPU us"]);
    for costs in scenes {
        let own = costs.find(Method::Paraboloid, Budget::EqualTexels, main);
        let Some((own, stages)) = own.and_then(|own| Some((own, own.stages?))) else { continue };
        let times = stages.times().map(|stage| time(milliseconds(stage)));
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
    for (width, height) in &figures.conditions.screens {
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
