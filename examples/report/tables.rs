//! The figures as tables.

use crate::subject::Measured;
use dual_paraboloid::compare::cost::{Contestant, ERROR_FLOOR_PPM, ErrorPair, ErrorRatios, Origin, error_ratio};
use dual_paraboloid::compare::text::{Table, grouped};
use std::fmt::Write;

const LEGEND: &str = "\
Errors are parts per million of the receivers that a renderer lights: points drawn over the scene by area over squared \
distance, on sides that face the light, against rays cast in double precision.";

const RIVALS_LEGEND: &str = "\
Wrong answers over all orientations. Every bias of the other methods that can be chosen is the best for the scene and the \
resolution; `shipped` are engines' defaults. Cubes have as many texels as the pair. Scenes are without their holes, of \
which the others know nothing.";

const OWN_LEGEND: &str = "\
*Ideal* is the frozen lookup `votes-v1` on a ray-cast map; *disagree*: where library and ideal decide differently; \
*energy*: wrong answers weighed by the cosine too, with no cut-off at grazing; *far*: wrong and farther than 1.5 texels, of a pair of \
1024, from any shadow boundary; *creases*: answers to lit receivers in concave creases, where 1 is right; *pixels*: wrong at the pixels \
of the scene's camera; *value*: mean absolute difference there from the lit share of the pixel, and from the truth at its \
middle. Texels of the map: *holes* are empty where there is a caster, *phantoms* the reverse, *strays* wrong and more than a \
texel from any silhouette; *depth p99* is the relative depth error that 99 % of the right ones stay below.";

/// All tables, the comparison of real scenes first. Without any, scenes made in code give it.
pub fn all(all: &[Measured]) -> String {
    let of = |origin| all.iter().filter(|of| of.origin == origin).collect::<Vec<_>>();
    let groups = [("real scenes", of(Origin::File)), ("scenes made in code", of(Origin::Code))];
    let groups: Vec<_> = groups.iter().filter(|(_, measured)| !measured.is_empty()).collect();
    let mut text = String::new();
    for (title, measured) in &groups {
        let _ = write!(text, "\n## This library's wrong answers over others', {title}\n\n{}", ratios(measured));
    }
    if of(Origin::File).is_empty() {
        text += "\nThere are no real scenes: name their folder in DP_SCENES.\n";
    }
    let _ = write!(
        text,
        "\nRatios have {ERROR_FLOOR_PPM} ppm added on both sides; below 1 this library is less wrong. *Mean* is geometric, \
         *pooled* is sum over sum, the scenes `dense-*` count as one. {LEGEND}\n"
    );
    for (title, measured) in &groups {
        let _ = write!(text, "\n## Wrong answers of all methods, {title}\n\n{}", compared(measured));
    }
    let _ = write!(text, "\n{RIVALS_LEGEND}\n");
    for (title, measured) in &groups {
        let _ = write!(text, "\n## This library and what its maps allow, {title}\n\n{}", own(measured));
    }
    let _ = write!(text, "\n{OWN_LEGEND}\n");
    text
}

/// All methods but this library, in the order in which they were measured.
fn rivals(measured: &[&Measured]) -> Vec<Contestant> {
    let mut found = Vec::new();
    for (contestant, _) in measured.iter().flat_map(|of| &of.compared) {
        if *contestant != Contestant::OWN && !found.contains(contestant) {
            found.push(*contestant);
        }
    }
    found
}

fn wrong(of: &Measured, contestant: Contestant) -> Option<f64> {
    of.compared.iter().find(|(measured, _)| *measured == contestant).map(|(_, ppm)| *ppm)
}

/// A line for each other method and resolution.
fn ratios(measured: &[&Measured]) -> Table {
    let mut table = Table::new(&["against", "R", "median", "worst", "in", "mean", "pooled", "wins"]);
    let mut resolutions: Vec<u32> = measured.iter().map(|of| of.resolution).collect();
    resolutions.sort_unstable();
    resolutions.dedup();
    for rival in rivals(measured) {
        for &resolution in &resolutions {
            let pair = |of: &&Measured| {
                let family = of.origin.family(&of.scene).to_owned();
                Some(ErrorPair { family, own_ppm: wrong(of, Contestant::OWN)?, other_ppm: wrong(of, rival)? })
            };
            let of_size = measured.iter().copied().filter(|of| of.resolution == resolution);
            let ratios = ErrorRatios::new(&of_size.filter_map(|of| pair(&of)).collect::<Vec<_>>());
            let number = |ratio: Option<f64>| ratio.map_or_else(dash, |ratio| format!("{ratio:.2}"));
            table.row([
                rival.name(),
                resolution.to_string(),
                number(ratios.median),
                number(ratios.worst.as_ref().map(|worst| worst.1)),
                ratios.worst.map_or_else(dash, |worst| worst.0),
                number(ratios.mean),
                number(ratios.pooled),
                format!("{} of {}", ratios.wins, ratios.of),
            ]);
        }
    }
    table
}

/// Wrong answers of all methods, a line for each scene and resolution.
fn compared(measured: &[&Measured]) -> Table {
    let rivals = rivals(measured);
    let names: Vec<String> = [Contestant::OWN].iter().chain(&rivals).map(|of| of.name()).collect();
    let head = ["scene", "triangles", "R"].into_iter().chain(names.iter().map(String::as_str));
    let mut table = Table::new(&head.collect::<Vec<_>>());
    for of in measured {
        let all = [Contestant::OWN].into_iter().chain(rivals.iter().copied());
        table.row(place(of).into_iter().chain(all.map(|contestant| wrong(of, contestant).map_or_else(dash, ppm))));
    }
    table
}

/// This library's figures, a line for each scene and resolution.
fn own(measured: &[&Measured]) -> Table {
    let mut head = vec!["scene", "triangles", "R", "wrong", "ideal", "ratio", "disagree", "energy", "far", "ideal far"];
    head.extend(["creases: mean", "least 0.1 %", "below 0.9 (ppm)", "pixels", "value", "value, point"]);
    head.extend(["holes", "phantoms", "strays", "depth p99"]);
    let mut table = Table::new(&head);
    for of in measured {
        let (own, map) = (&of.own, &of.own.map);
        let mut cells = place(of).to_vec();
        cells.extend([ppm(own.shadow.wrong_ppm), ppm(own.ideal.wrong_ppm)]);
        cells.push(format!("{:.3}", error_ratio(own.shadow.wrong_ppm, own.ideal.wrong_ppm)));
        cells.extend([own.disagree_ppm, own.shadow.wrong_energy_ppm].map(ppm));
        cells.extend([own.shadow.far_wrong_ppm, own.ideal.far_wrong_ppm].map(ppm));
        cells.extend(own.creases.map_or([(); 3].map(|()| dash()), |creases| {
            [format!("{:.3}", creases.mean), format!("{:.3}", creases.q001), ppm(creases.below_ppm)]
        }));
        cells.extend(own.pixels.map_or([(); 3].map(|()| dash()), |pixels| {
            [ppm(pixels.wrong_ppm), format!("{:.5}", pixels.value_error), format!("{:.5}", pixels.value_error_point)]
        }));
        cells.extend([map.holes, map.phantoms, map.strays].map(|count| count.to_string()));
        cells.push(format!("{:.1e}", map.depth_error_p99));
        table.row(cells);
    }
    table
}

fn place(of: &Measured) -> [String; 3] {
    [of.scene.clone(), grouped(of.triangles), of.resolution.to_string()]
}

fn ppm(value: f64) -> String {
    format!("{value:.0}")
}

fn dash() -> String {
    "-".to_owned()
}
