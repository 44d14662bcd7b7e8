//! What edges that are exact to the mesh gain: over the votes, and over cubes that are as wrong.

use super::{error_cells, or_dash, ppm, time_cells, title};
use crate::figures::Figures;
use dual_paraboloid::compare::baselines::{Lookup, Method};
use dual_paraboloid::compare::cost::{
    Contestant, ErrorPair, ErrorRatios, OwnErrors, OwnLookup, Ratios, Rule, SceneCosts, Timed,
};
use dual_paraboloid::compare::error_figures::ShadowError;
use dual_paraboloid::compare::text::Table;
use std::fmt::Write;

const LEGEND: &str = "\
*Over votes-v1*: wrong answers over those of the frozen lookup `votes-v1` on a ray-cast map, in the light's own orientation \
and with the scene's holes; *rule* is the exact lookup in double precision on that map. *Far*: the most of a scene, in parts \
per million; *creases*: the largest share of a scene's lit creases that is darker than 0.9, in parts per million. *Equal \
error*: this library's figure over what the other takes for the error that this library has at that R, over all \
orientations; bytes are those of a light.";

/// Rivals at equal error: the hardware's comparison and this library's votes in a cube that the hardware draws, and this
/// library's walk in a cube of its own.
const RIVALS: [Contestant; 3] = [
    Contestant { method: Method::Cube, lookup: Lookup::CubeHardware },
    Contestant { method: Method::Cube, lookup: Lookup::CubePlane },
    Contestant { method: Method::CubeCompute, lookup: Lookup::CubeWalk },
];

/// Against these at a quarter of the resolution.
const VOTES_IN_A_CUBE: Contestant = RIVALS[1];

/// All tables, over real scenes, over those made in code, and over all.
pub fn exact(figures: &Figures) -> String {
    let mut groups: Vec<(&str, Vec<&SceneCosts>)> =
        figures.groups(Rule::DoubleSided).into_iter().map(|(origin, scenes)| (title(origin), scenes)).collect();
    if groups.len() > 1 {
        groups.push(("All scenes", groups.iter().flat_map(|(_, scenes)| scenes.iter().copied()).collect()));
    }
    let mut text = format!("# Exact edges\n\n{}\n\n{LEGEND}\n", figures.adapter());
    for (of, scenes) in &groups {
        let _ = write!(text, "\n## Over votes-v1, {of}\n\n{}", over_votes(scenes, &figures.conditions.own));
        let small = small(figures);
        let what = format!("R = {small} over the cube with the same votes at the texels of R = {}", figures.main);
        let _ = write!(text, "\n## {what}, {of}\n\n{}", fewer_texels(scenes, small, figures.main));
        let _ = write!(text, "\n## Equal error, {of}\n\n{}", equal_error(scenes, &figures.conditions.own));
    }
    text
}

/// The resolution nearest to a quarter of the main one.
fn small(figures: &Figures) -> u32 {
    let far = |resolution: u32| (4.0 * f64::from(resolution) / f64::from(figures.main)).ln().abs();
    let all = figures.conditions.resolutions.iter().copied();
    all.min_by(|a, b| far(*a).total_cmp(&far(*b))).unwrap_or(figures.main)
}

/// A line for each resolution and lookup, and for the rule.
fn over_votes(scenes: &[&SceneCosts], resolutions: &[u32]) -> Table {
    let mut head = vec!["lookup", "R", "median", "worst", "in", "mean", "pooled", "wins"];
    head.extend(["far", "votes-v1 far", "creases"]);
    let mut table = Table::new(&head);
    let mut lookups: Vec<Lookup> = Vec::new();
    for of in scenes.iter().flat_map(|costs| &costs.own).flat_map(|errors| &errors.lookups) {
        if !lookups.contains(&of.lookup) {
            lookups.push(of.lookup);
        }
    }
    for &resolution in resolutions {
        for lookup in lookups.iter().copied().map(Some).chain([None]) {
            let read = |errors: &OwnErrors| errors.lookups.iter().find(|of| Some(of.lookup) == lookup).cloned();
            let shadow = |errors: &OwnErrors| match lookup {
                Some(_) => read(errors).map(|of| of.shadow),
                None => Some(errors.rule),
            };
            let name = lookup.map_or("rule", Lookup::name);
            let cells = row(scenes, resolution, shadow, |errors| read(errors));
            table.row([name.to_owned(), resolution.to_string()].into_iter().chain(cells));
        }
    }
    table
}

/// Ratios over the scenes, and the worst of what no ratio says.
fn row(
    scenes: &[&SceneCosts],
    resolution: u32,
    shadow: impl Fn(&OwnErrors) -> Option<ShadowError>,
    lookup: impl Fn(&OwnErrors) -> Option<OwnLookup>,
) -> Vec<String> {
    let of_size = |costs: &&SceneCosts| {
        Some((costs.family().to_owned(), costs.own.iter().find(|of| of.resolution == resolution)?.clone()))
    };
    let all: Vec<(String, OwnErrors)> = scenes.iter().filter_map(of_size).collect();
    let pair = |(family, errors): &(String, OwnErrors)| {
        let own_ppm = shadow(errors)?.wrong_ppm;
        Some(ErrorPair { family: family.clone(), own_ppm, other_ppm: errors.ideal.wrong_ppm })
    };
    let ratios = ErrorRatios::new(&all.iter().filter_map(pair).collect::<Vec<_>>());
    let most = |of: &dyn Fn(&OwnErrors) -> Option<f64>| {
        or_dash(all.iter().filter_map(|(_, errors)| of(errors)).reduce(f64::max).map(ppm))
    };
    let mut cells = error_cells(&ratios).to_vec();
    cells.push(most(&|errors| Some(shadow(errors)?.far_wrong_ppm)));
    cells.push(most(&|errors| Some(errors.ideal.far_wrong_ppm)));
    cells.push(most(&|errors| Some(lookup(errors)?.creases?.below_ppm)));
    cells
}

/// Ratios, and each scene's answers.
fn fewer_texels(scenes: &[&SceneCosts], small: u32, main: u32) -> Table {
    let mut table = Table::new(&["scene", "this library", "cube", "median", "worst", "in", "mean", "pooled", "wins"]);
    let pairs: Vec<(&str, ErrorPair)> = scenes
        .iter()
        .filter_map(|costs| Some((costs.scene.as_str(), costs.errors_at_texels(small, VOTES_IN_A_CUBE, main)?)))
        .collect();
    let ratios = ErrorRatios::new(&pairs.iter().map(|(_, pair)| pair.clone()).collect::<Vec<_>>());
    let all = ["all".to_owned(), or_dash(None), or_dash(None)];
    table.row(all.into_iter().chain(error_cells(&ratios)));
    for (scene, pair) in pairs {
        let dashes = [(); 6].map(|()| or_dash(None));
        table.row([scene.to_owned(), ppm(pair.own_ppm), ppm(pair.other_ppm)].into_iter().chain(dashes));
    }
    table
}

/// Times of map and lookup, and bytes, a line for each rival and resolution.
fn equal_error(scenes: &[&SceneCosts], resolutions: &[u32]) -> Table {
    let mut head = vec!["against", "R", "time: median", "worst", "in", "mean", "<", ">", "wins"];
    head.extend(["bytes: median", "worst", "in", "mean", "<", ">", "wins"]);
    let mut table = Table::new(&head);
    for rival in RIVALS {
        for &resolution in resolutions {
            let time = Ratios::new(scenes, |costs| costs.at_own_error(rival, Timed::HEADLINE, resolution)).summary();
            let bytes = Ratios::new(scenes, |costs| costs.bytes_at_own_error(rival, resolution)).summary();
            let cells = [time_cells(&time), time_cells(&bytes)].concat();
            table.row([rival.name(), resolution.to_string()].into_iter().chain(cells));
        }
    }
    table
}
