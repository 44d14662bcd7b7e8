//! Errors beside each other, at every resolution where this library's were counted by all definitions.

use super::{error_cells, or_dash, ppm, rivals, title};
use crate::figures::{Figures, contestants};
use dual_paraboloid::compare::baselines::Budget;
use dual_paraboloid::compare::cost::{
    Contestant, ERROR_FLOOR_PPM, ErrorRatios, LookupCost, Origin, OwnErrors, OwnLookup, Rule, SceneCosts, error_ratio,
};
use dual_paraboloid::compare::text::{Table, grouped};
use std::fmt::Write;

const LEGEND: &str = "\
Errors are parts per million of the receivers that a renderer lights: points drawn over the scene by area over squared \
distance, on sides that face the light, against rays cast in double precision.";

const RIVALS_LEGEND: &str = "\
Wrong answers over all orientations. Every bias of the other methods that can be chosen is the best for the scene and the \
resolution; `shipped` are engines' defaults. Cubes have as many texels as the pair. Scenes are without their holes, of \
which the others know nothing.";

const FRONTS_LEGEND: &str = "\
Only scenes where receivers lie on backs of double-sided surfaces. A file that marks all of its materials double-sided \
makes a renderer light the insides of its solids too; those of closed pieces don't count, but a piece with a gap has \
no inside.";

const OWN_LEGEND: &str = "\
*Ideal* is the frozen lookup `votes-v1` on a ray-cast map, *rule* this library's exact lookup there, in double precision; *disagree*: where lookup and ideal decide differently; \
*energy*: wrong answers weighed by the cosine too, with no cut-off at grazing; *far*: wrong and farther than 1.5 texels, of a pair of \
1024, from any shadow boundary; *backs*: receivers on the backs of double-sided surfaces, and *wrong, fronts* without them; \
*creases*: answers to lit receivers in concave creases, where 1 is right; *pixels*: wrong at the pixels \
of the scene's camera, asked over each pixel, and *points*, asked at their middles alone; *value*: mean absolute difference \
there from the lit share of the pixel, and from the truth at its middle. Texels of the map: *holes* are empty where there is a caster, *phantoms* the reverse, *strays* wrong and more than a \
texel from any silhouette; *depth p99* is the relative depth error that 99 % of the right ones stay below.";

/// All tables of errors, the comparison of real scenes first.
pub fn errors(figures: &Figures) -> String {
    let groups = figures.groups(Rule::DoubleSided);
    let of = &figures.conditions;
    let mut text = format!(
        "# Errors\n\n{}; {} samples and a camera of {}x{} pixels a scene, {} random orientations, seed {}.\n",
        figures.adapter(),
        grouped(of.samples as usize),
        of.camera.0,
        of.camera.1,
        of.orientations,
        of.seed
    );
    for (origin, scenes) in &groups {
        let what = "This library's wrong answers over others'";
        let _ = write!(text, "\n## {what}, {}\n\n{}", title(*origin), ratios(scenes, &of.own));
    }
    if !groups.iter().any(|(origin, _)| *origin == Origin::File) {
        text += super::NO_REAL_SCENES;
    }
    let _ = write!(
        text,
        "\nRatios have {ERROR_FLOOR_PPM} ppm added on both sides; below 1 this library is less wrong. *Mean* is geometric, \
         *pooled* is sum over sum, the scenes `dense-*` count as one. {LEGEND}\n"
    );
    for (origin, scenes) in &groups {
        let _ = write!(
            text,
            "\n## Wrong answers of all methods, {}\n\n{}",
            title(*origin),
            compared(scenes, &of.own, |of| of.wrong_ppm)
        );
    }
    let _ = write!(text, "\n{RIVALS_LEGEND}\n");
    for (origin, scenes) in &groups {
        let with_backs: Vec<&SceneCosts> = scenes.iter().copied().filter(|costs| has_backs(costs)).collect();
        if !with_backs.is_empty() {
            let table = compared(&with_backs, &of.own, |of| of.wrong_front_ppm);
            let _ = write!(text, "\n## The same on fronts alone, {}\n\n{table}\n{FRONTS_LEGEND}\n", title(*origin));
        }
    }
    for (origin, scenes) in &groups {
        let _ = write!(text, "\n## This library and what its maps allow, {}\n\n{}", title(*origin), own(scenes));
    }
    let _ = write!(text, "\n{OWN_LEGEND}\n");
    text
}

/// A line for each other method and resolution.
fn ratios(scenes: &[&SceneCosts], resolutions: &[u32]) -> Table {
    let mut table = Table::new(&["against", "R", "median", "worst", "in", "mean", "pooled", "wins"]);
    for rival in rivals(scenes) {
        for &resolution in resolutions {
            let pairs = scenes.iter().filter_map(|costs| costs.errors_at_equal_texels(rival, resolution));
            let cells = error_cells(&ErrorRatios::new(&pairs.collect::<Vec<_>>()));
            table.row([rival.name(), resolution.to_string()].into_iter().chain(cells));
        }
    }
    table
}

/// Whether any receiver is on the back of a double-sided surface.
fn has_backs(costs: &SceneCosts) -> bool {
    costs.own.iter().flat_map(|errors| &errors.lookups).any(|of| of.shadow.back_fraction > 0.0)
}

/// Wrong answers of all methods, a line for each scene and resolution.
fn compared(scenes: &[&SceneCosts], resolutions: &[u32], wrong_ppm: fn(&LookupCost) -> f64) -> Table {
    let all = contestants(scenes);
    let names: Vec<String> = all.iter().map(|of| of.name()).collect();
    let head = ["scene", "triangles", "R"].into_iter().chain(names.iter().map(String::as_str));
    let mut table = Table::new(&head.collect::<Vec<_>>());
    for costs in scenes {
        for &resolution in resolutions {
            let wrong =
                |of: &Contestant| costs.find(of.method, Budget::EqualTexels, resolution)?.of(of.lookup).map(wrong_ppm);
            let cells = all.iter().map(|of| or_dash(wrong(of).map(ppm)));
            table.row(place(costs, resolution).into_iter().chain(cells));
        }
    }
    table
}

/// This library's figures, a line for each scene, resolution and lookup.
fn own(scenes: &[&SceneCosts]) -> Table {
    let mut head = vec!["scene", "triangles", "R", "lookup"];
    head.extend([
        "wrong",
        "ideal",
        "ratio",
        "rule",
        "disagree",
        "energy",
        "far",
        "ideal far",
        "backs (%)",
        "wrong, fronts",
    ]);
    head.extend(["creases: mean", "least 0.1 %", "below 0.9 (ppm)", "pixels", "value", "value, point"]);
    head.extend(["points", "value", "value, point"]);
    head.extend(["holes", "phantoms", "strays", "depth p99"]);
    let mut table = Table::new(&head);
    for costs in scenes {
        for errors in &costs.own {
            for of in &errors.lookups {
                table.row(place(costs, errors.resolution).into_iter().chain(own_cells(errors, of)));
            }
        }
    }
    table
}

fn own_cells(errors: &OwnErrors, of: &OwnLookup) -> Vec<String> {
    let (shadow, ideal, map) = (&of.shadow, &errors.ideal, &errors.map);
    let mut cells = vec![of.lookup.name().to_owned(), ppm(shadow.wrong_ppm), ppm(ideal.wrong_ppm)];
    cells.push(format!("{:.3}", error_ratio(shadow.wrong_ppm, ideal.wrong_ppm)));
    cells.push(ppm(errors.rule.wrong_ppm));
    cells.extend([of.disagree_ppm, shadow.wrong_energy_ppm, shadow.far_wrong_ppm, ideal.far_wrong_ppm].map(ppm));
    cells.extend([format!("{:.1}", 100.0 * shadow.back_fraction), ppm(shadow.wrong_front_ppm)]);
    cells.extend(of.creases.map_or([(); 3].map(|()| or_dash(None)), |creases| {
        [format!("{:.3}", creases.mean), format!("{:.3}", creases.q001), ppm(creases.below_ppm)]
    }));
    for at in [of.pixels.map(|errors| errors.pixels), of.pixels.map(|errors| errors.points)] {
        cells.extend(at.map_or([(); 3].map(|()| or_dash(None)), |error| {
            [ppm(error.wrong_ppm), format!("{:.5}", error.value_error), format!("{:.5}", error.value_error_point)]
        }));
    }
    cells.extend([map.holes, map.phantoms, map.strays].map(|count| count.to_string()));
    cells.push(format!("{:.1e}", map.depth_error_p99));
    cells
}

fn place(costs: &SceneCosts, resolution: u32) -> [String; 3] {
    [costs.scene.clone(), grouped(costs.triangles), resolution.to_string()]
}
