//! The tables of the project's README, to be pasted.

use super::{median_and_worst, or_dash, ppm, ratio_text, signed};
use crate::figures::{Figures, rivals};
use dual_paraboloid::compare::baselines::{Budget, Lookup, Method};
use dual_paraboloid::compare::cost::{
    Contestant, ErrorPair, ErrorRatios, Origin, OwnLookup, Ratios, Rule, SceneCosts, Timed,
};
use dual_paraboloid::compare::text::{Table, grouped};

/// The tables, over real scenes where there are any; the table by scene has all.
pub fn readme(figures: &Figures) -> String {
    let groups = figures.groups(Rule::DoubleSided);
    let all: Vec<&SceneCosts> = groups.iter().flat_map(|(_, scenes)| scenes.iter().copied()).collect();
    let headline = groups.iter().map(|(_, scenes)| scenes.as_slice()).next().unwrap_or_default();
    let of = match groups.first() {
        Some((Origin::Code, _)) => "scenes made in code",
        _ => "real scenes",
    };
    let (main, adapter) = (figures.main, figures.adapter());
    let tables = [
        (format!("How wrong, {of}, R = {main}"), wrong(headline, main, SceneCosts::errors_at_equal_texels)),
        (format!("The same at equal bytes of a light, {of}, R = {main}"), {
            wrong(headline, main, SceneCosts::errors_at_equal_bytes)
        }),
        (format!("By scene, R = {main}"), by_scene(&all, main)),
        (format!("How fast, {of}"), times(figures, headline)),
    ];
    let of_all = format!("{adapter}, {} orientations", figures.conditions.orientations);
    tables
        .iter()
        .fold(format!("# README\n\n{of_all}\n"), |text, (title, table)| text + &format!("\n## {title}\n\n{table}"))
}

/// A method and its lookup, to a reader who doesn't know the comparison's names.
fn name(of: Contestant) -> String {
    match (of.method, of.lookup) {
        (Method::Paraboloid, Lookup::Paraboloid) => "this library".to_owned(),
        (Method::Paraboloid, Lookup::Votes) => "this library's votes alone".to_owned(),
        (Method::CubeCompute, Lookup::CubeWalk) => "the same rasteriser on six faces, the same walk".to_owned(),
        (Method::CubeCompute, Lookup::CubePlane) => "the same rasteriser on six faces, plane votes".to_owned(),
        (Method::Cube, Lookup::CubePlane) => "cube, plane votes".to_owned(),
        (Method::Cube, Lookup::CubeHardware) => "cube, hardware comparison".to_owned(),
        (Method::Cube, Lookup::CubeShipped) => "cube, shipped bias (bevy's)".to_owned(),
        (Method::Cube16, Lookup::CubeHardware) => "16-bit cube, hardware comparison".to_owned(),
        (Method::VertexWarp, Lookup::VertexWarp) => "vertex warp, the technique as published".to_owned(),
        (Method::VertexWarp, Lookup::VertexWarpShipped) => "vertex warp, shipped bias (Godot's)".to_owned(),
        _ => of.name(),
    }
}

/// The rivals whose maps are their own, each with all its lookups.
fn own_maps(scenes: &[&SceneCosts]) -> Vec<Contestant> {
    rivals(scenes).into_iter().filter(|of| of.method.same_map() == of.method).collect()
}

fn wrong(scenes: &[&SceneCosts], main: u32, pair: fn(&SceneCosts, Contestant, u32) -> Option<ErrorPair>) -> Table {
    let mut table = Table::new(&["wrong answers, this library over", "median", "worst", "mean", "pooled", "wins"]);
    for rival in own_maps(scenes) {
        let pairs = scenes.iter().filter_map(|costs| pair(costs, rival, main));
        let ratios = ErrorRatios::new(&pairs.collect::<Vec<_>>());
        let worst = ratios.worst.as_ref().map(|(scene, ratio)| format!("{} ({scene})", ratio_text(*ratio)));
        table.row([
            name(rival),
            or_dash(ratios.median.map(ratio_text)),
            or_dash(worst),
            or_dash(ratios.mean.map(ratio_text)),
            or_dash(ratios.pooled.map(ratio_text)),
            format!("{} of {}", ratios.wins, ratios.of),
        ]);
    }
    table
}

/// Wrong answers of this library and of the best of each kind of rival; then this library with the scene's holes.
fn by_scene(scenes: &[&SceneCosts], main: u32) -> Table {
    let computed = [Method::Paraboloid, Method::CubeCompute].into_iter();
    let all = |method: Method| method.lookups().iter().map(move |&lookup| Contestant { method, lookup });
    let others = [(Method::Cube, Lookup::CubeHardware), (Method::VertexWarp, Lookup::VertexWarp)];
    let others = others.map(|(method, lookup)| Contestant { method, lookup });
    let shown: Vec<Contestant> = computed.flat_map(all).chain(others).collect();
    let names: Vec<String> = shown.iter().map(|of| name(*of)).collect();
    let mut head = vec!["scene", "triangles"];
    head.extend(names.iter().map(String::as_str));
    head.extend(["with holes: this", "ideal", "pixels", "creases"]);
    let mut table = Table::new(&head);
    for costs in scenes {
        let wrong = |of: &Contestant| {
            let cost = costs.find(of.method, Budget::EqualTexels, main)?;
            cost.wrong_ppm(of.lookup).map(ppm)
        };
        let mut cells = vec![costs.scene.clone(), grouped(costs.triangles)];
        cells.extend(shown.iter().map(|of| or_dash(wrong(of))));
        let errors = costs.own.iter().find(|errors| errors.resolution == main);
        let own = |of: fn(&OwnLookup) -> Option<String>| or_dash(errors.and_then(|errors| of(errors.own()?)));
        cells.push(own(|of| Some(ppm(of.shadow.wrong_ppm))));
        cells.push(or_dash(errors.map(|errors| ppm(errors.ideal.wrong_ppm))));
        cells.push(own(|of| Some(ppm(of.pixels?.pixels.wrong_ppm))));
        cells.push(own(|of| Some(format!("{:.0} %", 1e-4 * of.creases?.below_ppm))));
        table.row(cells);
    }
    table
}

/// The map's time at equal texels, and what an answer as good takes: map and lookups.
fn times(figures: &Figures, scenes: &[&SceneCosts]) -> Table {
    let sizes = &figures.conditions.own;
    let mut head = vec!["this library over".to_owned()];
    head.extend(sizes.iter().map(|size| format!("map, R = {size}")));
    head.extend(["equal error: median", "worst", "mean", "<", ">", "wins"].map(str::to_owned));
    let mut table = Table::new(&head.iter().map(String::as_str).collect::<Vec<_>>());
    for rival in own_maps(scenes) {
        let map = |&size: &u32| {
            let ratio = |costs: &SceneCosts| costs.at_equal_size(rival.method, Budget::EqualTexels, size);
            median_and_worst(&Ratios::new(scenes, ratio).summary())
        };
        let time = Ratios::new(scenes, |costs| costs.at_own_error(rival, Timed::HEADLINE, figures.main)).summary();
        let worst = time.worst.as_ref().map(|(scene, ratio)| format!("{} ({scene})", signed(*ratio)));
        let mut cells = vec![name(rival)];
        cells.extend(sizes.iter().map(map));
        cells.extend([or_dash(time.median.map(signed)), or_dash(worst), or_dash(time.mean.map(ratio_text))]);
        cells.extend([time.at_most.to_string(), time.at_least.to_string()]);
        cells.push(format!("{} of {}", time.wins, time.exact + time.at_most + time.at_least));
        table.row(cells);
    }
    table
}
