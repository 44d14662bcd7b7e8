//! The figures as text: Markdown that reads well on a terminal.

use crate::figures::Figures;
use dual_paraboloid::compare::baselines::{Budget, Lookup, Method};
use dual_paraboloid::compare::cost::{Cost, LARGE_SCENE, Ratio, Ratios, Rule, SceneCosts};
use dual_paraboloid::compare::text::{Table, grouped};
use dual_paraboloid::compare::timing::{Summary, milliseconds};
use std::fmt::Write;

/// What times are shown of, scene by scene.
const SHOWN: [(Method, &str); 7] = [
    (Method::Paraboloid, "this"),
    (Method::Cube, "cube"),
    (Method::CubeUnculled, "not culled"),
    (Method::CubeRouted, "routed"),
    (Method::CubeMultiview, "multiview"),
    (Method::VertexWarp, "vertex warp"),
    (Method::DepthView, "plain view"),
];

/// What the library is held against at every resolution.
const YARDSTICKS: [(Method, &str); 3] =
    [(Method::Cube, "cube"), (Method::CubeRouted, "routed cube"), (Method::DepthView, "plain view")];

/// What it is held against at equal error.
const AT_EQUAL_ERROR: [(Method, Lookup, &str); 5] = [
    (Method::Cube, Lookup::CubeHardware, "cube, constant bias"),
    (Method::Cube, Lookup::CubePlane, "cube, plane bias"),
    (Method::CubeRouted, Lookup::CubeHardware, "routed cube, constant bias"),
    (Method::CubeRouted, Lookup::CubePlane, "routed cube, plane bias"),
    (Method::VertexWarp, Lookup::VertexWarp, "vertex warp"),
];

const LEGEND: &str = "\
Times are medians, in milliseconds, of maps made anew with all methods interleaved. Ratios are this library's time over \
the other's: below 1 it takes less. Means are geometric. *Equal texels*: six faces of a cube have as many as the pair; \
*equal side*: a face is as wide as one of the pair's maps. *Equal error*: both curves of time against wrong answers, \
over all sizes, interpolated in logarithms; the ratio is the median over errors spread evenly over the range that both \
span, so that no single error is picked. Where they span none, `<` and `>` give the bound at the error where they come \
closest, and means take it for the ratio. Wrong answers are in parts per million of the samples, against rays cast in \
double precision.";

/// The conditions, all ratios, and a line for each scene.
pub fn summary(figures: &Figures) -> String {
    let mut text = format!(
        "# Cost against error\n\n{}; times: {}; {} samples, seed {}, up to {} runs.\n\n{LEGEND}\n",
        figures.adapter,
        figures.clock,
        grouped(figures.samples as usize),
        figures.seed,
        figures.runs
    );
    for rule in figures.rules() {
        let _ = write!(text, "\n## Ratios, {rule}\n\n{}", ratios(figures, rule));
        let _ = write!(text, "\n## Scenes, {rule}, R = {}, equal texels\n\n{}", figures.main, scenes(figures, rule));
        let _ = write!(text, "\n## Stages, {rule}, R = {}\n\n{}", figures.main, stages(figures, rule));
    }
    if !figures.left_out.is_empty() {
        let _ = write!(text, "\n## Left out\n\n");
        figures.left_out.iter().for_each(|what| text += &format!("- {what}\n"));
    }
    text
}

/// Every figure, a table for each scene and rule.
pub fn details(figures: &Figures) -> String {
    figures.scenes.iter().fold("\n# All figures\n".to_owned(), |text, costs| {
        let title = format!("{}, {} triangles, {}", costs.scene, grouped(costs.triangles), costs.rule);
        text + &format!("\n## {title}\n\n{}", every_cost(costs))
    })
}

fn ratios(figures: &Figures, rule: Rule) -> Table {
    let scenes: Vec<&SceneCosts> = figures.of(rule).collect();
    let large = format!("from {} triangles", grouped(LARGE_SCENE));
    let mut table = Table::new(&["against", "at equal", &large, "all", "worst", "in"]);
    let mut add = |name: &str, equal: &str, ratios: Ratios| {
        let Some(worst) = ratios.worst() else { return };
        let mean = |mean: Option<f64>| mean.map_or("-".to_owned(), ratio_text);
        let cells = [equal.to_owned(), mean(ratios.large), mean(ratios.all), signed(worst), worst.scene.clone()];
        table.row([name.to_owned()].into_iter().chain(cells));
    };
    let mut at_size = |method, name, budget, pair, equal: &str| {
        add(name, &format!("{equal}, R = {pair}"), Ratios::at_equal_size(&scenes, method, budget, pair));
    };
    for (method, name) in YARDSTICKS {
        for &pair in &figures.resolutions {
            at_size(method, name, Budget::EqualTexels, pair, "texels");
        }
    }
    for (method, name) in SHOWN.into_iter().filter(|(method, _)| method.is_cube()) {
        at_size(method, name, Budget::EqualSide, figures.main, "side");
    }
    for (method, name) in [SHOWN[2], SHOWN[4], SHOWN[5]] {
        at_size(method, name, Budget::EqualTexels, figures.main, "texels");
    }
    for (method, lookup, name) in AT_EQUAL_ERROR {
        add(name, "error", Ratios::at_equal_error(&scenes, method, lookup));
    }
    table
}

fn scenes(figures: &Figures, rule: Rule) -> Table {
    let scenes: Vec<&SceneCosts> = figures.of(rule).collect();
    let mut head = vec!["scene", "triangles"];
    head.extend(SHOWN.map(|(_, name)| name));
    head.extend(["this / cube", "equal error: constant", "plane", "wrong: this", "constant", "plane", "warp"]);
    let mut table = Table::new(&head);
    let equal =
        [Lookup::CubeHardware, Lookup::CubePlane].map(|lookup| Ratios::at_equal_error(&scenes, Method::Cube, lookup));
    for costs in &scenes {
        let find = |method| costs.find(method, Budget::EqualTexels, figures.main);
        let wrong = |method, lookup| or_dash(find(method).and_then(|cost| cost.wrong_ppm(lookup)).map(ppm));
        let own = find(Method::Paraboloid).zip(find(Method::Cube));
        let mut cells = vec![costs.scene.clone(), grouped(costs.triangles)];
        cells.extend(SHOWN.map(|(method, _)| or_dash(find(method).map(|cost| time(cost.milliseconds())))));
        cells.push(or_dash(own.map(|(own, cube)| ratio_text(own.milliseconds() / cube.milliseconds()))));
        cells.extend(equal.iter().map(|ratios| or_dash(ratios.of(&costs.scene).map(signed))));
        cells.push(wrong(Method::Paraboloid, Lookup::Paraboloid));
        cells.push(wrong(Method::Cube, Lookup::CubeHardware));
        cells.push(wrong(Method::Cube, Lookup::CubePlane));
        cells.push(wrong(Method::VertexWarp, Lookup::VertexWarp));
        table.row(cells);
    }
    table
}

fn stages(figures: &Figures, rule: Rule) -> Table {
    let mut table = Table::new(&["scene", "triangles", "route", "split", "depth", "recording, CPU us"]);
    for costs in figures.of(rule) {
        let own = costs.find(Method::Paraboloid, Budget::EqualTexels, figures.main);
        let Some((own, stages)) = own.and_then(|own| Some((own, own.stages?))) else { continue };
        let times = [stages.route, stages.split, stages.depth].map(|stage| time(milliseconds(stage)));
        let recording = format!("{:.0}", 1000.0 * milliseconds(own.cpu.median));
        table.row([costs.scene.clone(), grouped(costs.triangles)].into_iter().chain(times).chain([recording]));
    }
    table
}

fn every_cost(costs: &SceneCosts) -> Table {
    let mut table = Table::new(&[
        "method",
        "equal",
        "R",
        "side",
        "texels",
        "MB",
        "GPU ms",
        "min",
        "max",
        "CPU ms",
        "min",
        "max",
        "runs",
        "wrong",
        "plane bias",
    ]);
    for cost in &costs.costs {
        let equal = match (cost.method.is_cube(), cost.budget) {
            (false, _) => "both",
            (true, Budget::EqualTexels) => "texels",
            (true, Budget::EqualSide) => "side",
        };
        let mut cells = vec![cost.method.to_string(), equal.to_owned(), cost.pair.to_string(), cost.side.to_string()];
        cells.extend([grouped(cost.texels as usize), format!("{:.1}", cost.bytes as f64 / 1e6)]);
        cells.extend([cost.gpu, cost.cpu].iter().flat_map(three));
        cells.push(cost.runs.to_string());
        cells.extend(errors(cost));
        table.row(cells);
    }
    table
}

/// The wrong answers of a method's own lookup, and of the plane bias where that is another.
fn errors(cost: &Cost) -> [String; 2] {
    let own = cost.method.lookups().first().and_then(|lookup| cost.wrong_ppm(*lookup));
    [own, cost.wrong_ppm(Lookup::CubePlane)].map(|wrong| or_dash(wrong.map(ppm)))
}

fn three(summary: &Summary) -> [String; 3] {
    [summary.median, summary.min, summary.max].map(|duration| time(milliseconds(duration)))
}

fn time(milliseconds: f64) -> String {
    format!("{milliseconds:.3}")
}

fn ppm(value: f64) -> String {
    format!("{value:.0}")
}

fn signed(ratio: &Ratio) -> String {
    format!("{}{}", ratio.sign, ratio_text(ratio.ratio))
}

fn ratio_text(ratio: f64) -> String {
    format!("{ratio:.2}")
}

fn or_dash(text: Option<String>) -> String {
    text.unwrap_or_else(|| "-".to_owned())
}
