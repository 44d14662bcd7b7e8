//! The figures as a table and as JSON.

use crate::figures::Measured;
use anyhow::anyhow;
use dual_paraboloid::compare::text::grouped;
use dual_paraboloid::compare::timing::{Summary, milliseconds};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Duration;

/// What all methods have in common.
pub struct Common {
    pub scene: String,
    pub triangles: usize,
    pub adapter: String,
    pub runs: u32,
}

/// Writes an object for one method, a list for several.
pub fn write_json(path: &Path, common: &Common, measured: &[Measured]) -> anyhow::Result<()> {
    let mut objects: Vec<Value> = measured.iter().map(|one| object(common, one)).collect();
    let value = if objects.len() == 1 { objects.remove(0) } else { Value::Array(objects) };
    std::fs::write(path, format!("{value:#}\n")).map_err(|error| anyhow!("can't write {}: {error}", path.display()))
}

fn object(common: &Common, one: &Measured) -> Value {
    let mut object = json!({
        "scene": common.scene,
        "method": one.entry.name(),
        "resolution": one.resolution,
        "texels": one.baseline.texels(),
        "bytes": one.baseline.memory(),
        "triangles": common.triangles,
        "map": one.judged.as_ref().and_then(|judged| judged.map),
        "shadow": shadow(one),
        "time": one.time.map(|time| times(common, &time)),
    });
    if let Some(bias) = one.judged.as_ref().and_then(|judged| judged.bias) {
        object["bias"] = json!(bias);
    }
    object
}

fn shadow(one: &Measured) -> Value {
    let Some(judged) = &one.judged else { return Value::Null };
    let mut shadow = json!(judged.shadow);
    shadow["ideal_wrong_ppm"] = json!(one.ideal.map(|error| error.wrong_ppm));
    shadow["ideal_votes_wrong_ppm"] = json!(one.votes.map(|votes| votes.wrong_ppm));
    shadow["disagree_ppm"] = json!(one.votes.map(|votes| votes.disagree_ppm));
    let [pixels, points] = [one.pixels.map(|errors| errors.pixels), one.pixels.map(|errors| errors.points)];
    shadow["pixels_wrong_ppm"] = json!(pixels.map(|pixels| pixels.wrong_ppm));
    shadow["value_error"] = json!(pixels.map(|pixels| pixels.value_error));
    shadow["value_error_point"] = json!(pixels.map(|pixels| pixels.value_error_point));
    shadow["points"] = json!({
        "pixels_wrong_ppm": points.map(|points| points.wrong_ppm),
        "value_error": points.map(|points| points.value_error),
        "value_error_point": points.map(|points| points.value_error_point),
    });
    shadow["crease_mean"] = json!(one.crease.map(|crease| crease.mean));
    shadow["crease_q001"] = json!(one.crease.map(|crease| crease.q001));
    shadow["crease_below_ppm"] = json!(one.crease.map(|crease| crease.below_ppm));
    shadow["acne_ppm"] = json!(judged.filter.map(|error| error.acne_ppm));
    shadow["underlight_ppm"] = json!(judged.filter.map(|error| error.underlight_ppm));
    if let Some(soft) = one.soft {
        shadow["soft"] = json!(soft);
    }
    shadow
}

fn times(common: &Common, time: &Summary) -> Value {
    let mut times = json!(time);
    times["adapter"] = json!(common.adapter);
    times["runs"] = json!(common.runs);
    times
}

/// A line for each figure, a column for each method; a dash where a method has no such figure.
pub fn print_table(measured: &[Measured]) {
    let line = |title: &str, figure: &dyn Fn(&Measured) -> Option<String>| {
        let cells: Vec<Option<String>> = measured.iter().map(figure).collect();
        if cells.iter().any(Option::is_some) {
            let cells = cells.into_iter().map(|cell| format!(" {:>14}", cell.unwrap_or_else(|| "-".to_owned())));
            println!("{title:28}{}", cells.collect::<String>());
        }
    };
    line("", &|one| Some(one.entry.name().to_owned()));
    line("resolution", &|one| Some(one.resolution.to_string()));
    line("texels", &|one| Some(grouped(one.baseline.texels() as usize)));
    line("bytes", &|one| Some(grouped(one.baseline.memory() as usize)));
    map_lines(&line);
    shadow_lines(&line);
    line("bias", &|one| Some(one.judged.as_ref()?.bias?.to_string()));
    line("time, ms: median", &|one| Some(time(one.time?.median)));
    line("  least", &|one| Some(time(one.time?.min)));
    line("  most", &|one| Some(time(one.time?.max)));
}

type Line<'a> = &'a dyn Fn(&str, &dyn Fn(&Measured) -> Option<String>);

fn map_lines(line: Line) {
    let map = |one: &Measured| one.judged.as_ref()?.map;
    line("map: texels judged", &|one| Some(grouped(map(one)?.texels)));
    line("  wrong surface, ppm", &|one| Some(ppm(map(one)?.wrong_surface_ppm)));
    line("  off any silhouette", &|one| Some(grouped(map(one)?.strays)));
    line("  holes", &|one| Some(grouped(map(one)?.holes)));
    line("  phantoms", &|one| Some(grouped(map(one)?.phantoms)));
    line("  depth error: median", &|one| Some(format!("{:.2e}", map(one)?.depth_error_median)));
    line("    99 %", &|one| Some(format!("{:.2e}", map(one)?.depth_error_p99)));
    line("    most", &|one| Some(format!("{:.2e}", map(one)?.depth_error_max)));
}

fn shadow_lines(line: Line) {
    let shadow = |one: &Measured| Some(one.judged.as_ref()?.shadow);
    let ideal = |one: &Measured| one.ideal;
    line("shadow: samples", &|one| Some(grouped(shadow(one)?.samples)));
    line("  truly lit, %", &|one| Some(format!("{:.1}", 100.0 * shadow(one)?.lit_fraction)));
    line("  on backs, %", &|one| Some(format!("{:.1}", 100.0 * shadow(one)?.back_fraction)));
    line("  wrong, ppm", &|one| Some(ppm(shadow(one)?.wrong_ppm)));
    line("    leaks", &|one| Some(ppm(shadow(one)?.leak_ppm)));
    line("    false shadows", &|one| Some(ppm(shadow(one)?.false_shadow_ppm)));
    line("    far from a boundary", &|one| Some(ppm(shadow(one)?.far_wrong_ppm)));
    line("    on fronts", &|one| Some(ppm(shadow(one)?.wrong_front_ppm)));
    line("  wrong by energy, ppm", &|one| Some(ppm(shadow(one)?.wrong_energy_ppm)));
    line("  wrong pixels, ppm", &|one| Some(ppm(one.pixels?.pixels.wrong_ppm)));
    line("    asked as points", &|one| Some(ppm(one.pixels?.points.wrong_ppm)));
    line("  value error", &|one| Some(format!("{:.6}", one.pixels?.pixels.value_error)));
    line("    to the middle's truth", &|one| Some(format!("{:.6}", one.pixels?.pixels.value_error_point)));
    line("    asked as points", &|one| Some(format!("{:.6}", one.pixels?.points.value_error)));
    line("      to the middle's truth", &|one| Some(format!("{:.6}", one.pixels?.points.value_error_point)));
    line("  in lit creases: samples", &|one| Some(grouped(one.crease?.samples)));
    line("    mean", &|one| Some(format!("{:.3}", one.crease?.mean)));
    line("    0.1 %", &|one| Some(format!("{:.3}", one.crease?.q001)));
    line("    below 0.9, ppm", &|one| Some(ppm(one.crease?.below_ppm)));
    let filter = |one: &Measured| one.judged.as_ref()?.filter;
    line("    acne", &|one| Some(ppm(filter(one)?.acne_ppm)));
    line("    light in the dark", &|one| Some(ppm(filter(one)?.underlight_ppm)));
    line("  in a penumbra, %", &|one| Some(format!("{:.1}", 100.0 * one.soft?.penumbra_fraction)));
    line("    error there: rms", &|one| Some(format!("{:.4}", one.soft?.penumbra_rms)));
    line("  all errors: rms", &|one| Some(format!("{:.4}", one.soft?.rms)));
    line("    99 %", &|one| Some(format!("{:.4}", one.soft?.p99)));
    line("    most", &|one| Some(format!("{:.4}", one.soft?.worst)));
    line("  ray-cast map: wrong, ppm", &|one| Some(ppm(ideal(one)?.wrong_ppm)));
    line("    far from a boundary", &|one| Some(ppm(ideal(one)?.far_wrong_ppm)));
    line("  votes-v1: wrong, ppm", &|one| Some(ppm(one.votes?.wrong_ppm)));
    line("    wrong / votes-v1", &|one| Some(format!("{:.3}", shadow(one)?.wrong_ppm / one.votes?.wrong_ppm)));
    line("    decides differently, ppm", &|one| Some(ppm(one.votes?.disagree_ppm)));
}

fn ppm(value: f64) -> String {
    format!("{value:.0}")
}

fn time(time: Duration) -> String {
    format!("{:.3}", milliseconds(time))
}
