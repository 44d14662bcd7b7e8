//! The example `measure` as it is run: figures under the names that its README gives, errors that are one line.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Where a test writes; under the build's own folder.
fn path(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("measure_example");
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

fn run(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO"));
    let profile: &[&str] = if cfg!(debug_assertions) { &[] } else { &["--release"] };
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(["run", "--quiet", "--features", "compare"]).args(profile);
    command.args(["--example", "measure", "--"]).args(arguments);
    command.output().expect("cargo doesn't start")
}

fn utf8(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs a quick measurement of a small scene, and returns what it wrote and printed.
fn measure(name: &str, arguments: &[&str]) -> (Value, String) {
    measure_at(2000, name, arguments)
}

/// With so many receivers.
fn measure_at(samples: u32, name: &str, arguments: &[&str]) -> (Value, String) {
    let file = path(name);
    let _ = std::fs::remove_file(&file);
    let samples = samples.to_string();
    let quick =
        ["few-large", "--samples", &samples, "--size", "96x54", "--runs", "2", "--json", file.to_str().unwrap()];
    let output = run(&[&quick, arguments].concat());
    assert!(output.status.success(), "{}", utf8(&output.stderr));
    let json = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    (json, utf8(&output.stdout))
}

fn assert_keys(object: &Value, keys: &str) {
    let mut expected: Vec<&str> = keys.split_whitespace().collect();
    expected.sort_unstable();
    let mut found: Vec<&String> = object.as_object().expect("an object").keys().collect();
    found.sort_unstable();
    assert_eq!(found, expected);
}

const ALL: &str = "scene method resolution texels bytes triangles map shadow time";
const SHADOW: &str = "samples lit_fraction wrong_ppm wrong_energy_ppm leak_ppm false_shadow_ppm far_wrong_ppm \
                      back_fraction wrong_front_ppm pixels_wrong_ppm value_error value_error_point points \
                      crease_mean crease_q001 crease_below_ppm \
                      ideal_wrong_ppm ideal_votes_wrong_ppm disagree_ppm acne_ppm underlight_ppm";
/// What of them the paraboloid has alone.
const OWN: [&str; 5] = ["ideal_wrong_ppm", "ideal_votes_wrong_ppm", "disagree_ppm", "acne_ppm", "underlight_ppm"];

#[test]
fn one_method_is_an_object_with_all_keys() {
    let pictures = path("pictures");
    let (json, printed) =
        measure("one.json", &["--resolution", "64", "--seed", "7", "--pictures", pictures.to_str().unwrap()]);
    assert_keys(&json, ALL);
    assert_keys(
        &json["map"],
        "texels wrong_surface_ppm holes phantoms strays depth_error_median depth_error_p99 depth_error_max",
    );
    assert_keys(&json["shadow"], SHADOW);
    assert_keys(&json["shadow"]["points"], "pixels_wrong_ppm value_error value_error_point");
    assert_keys(&json["time"], "adapter ms_median ms_min ms_max runs");
    assert_eq!((&json["scene"], &json["method"]), (&Value::from("few-large"), &Value::from("paraboloid")));
    let numbers = [&json["resolution"], &json["texels"], &json["triangles"], &json["shadow"]["samples"]];
    assert_eq!(numbers.map(Value::as_u64), [64, 2 * 64 * 64, 372, 2000].map(Some));
    assert!(json["shadow"]["ideal_wrong_ppm"].as_f64().is_some() && json["time"]["ms_median"].as_f64() > Some(0.0));
    for word in [
        "adapter",
        "the scene's own",
        "camera",
        "wrong, ppm",
        "wrong pixels",
        "value error",
        "votes-v1",
        "holes",
        "time, ms",
    ] {
        assert!(printed.contains(word), "{word} is missing in:\n{printed}");
    }
    for (name, size) in [("map.png", (128, 128)), ("screen-paraboloid.png", (960, 270))] {
        assert_eq!(image::open(pictures.join(name)).unwrap().to_rgb8().dimensions(), size, "{name}");
    }
}

#[test]
fn several_methods_are_a_list_with_nulls_for_what_they_lack() {
    let methods = ["paraboloid", "vertex-warp", "cube", "cube-plane", "depth-view"];
    let (json, _) = measure("list.json", &["--texels", "8192", "--method", &methods.join(",")]);
    let list = json.as_array().expect("a list");
    assert_eq!(list.iter().map(|one| one["method"].as_str().unwrap()).collect::<Vec<_>>(), methods);
    let resolutions = list.iter().map(|one| one["resolution"].as_u64().unwrap());
    assert_eq!(resolutions.collect::<Vec<_>>(), [64, 64, 37, 37, 64]);
    for (number, one) in list.iter().enumerate() {
        let keys = if (1..4).contains(&number) { format!("{ALL} bias") } else { ALL.to_owned() };
        assert_keys(one, &keys);
        assert_eq!(one["map"].is_null(), number != 0);
        assert_eq!(one["time"].is_null(), number == 3);
        assert_eq!(one["shadow"].is_null(), number == 4);
        if number < 4 {
            assert_keys(&one["shadow"], SHADOW);
            for figure in OWN {
                assert_eq!(one["shadow"][figure].is_null(), number != 0, "{figure}");
            }
            for figure in ["wrong_ppm", "wrong_energy_ppm", "pixels_wrong_ppm", "value_error", "value_error_point"] {
                // So few receivers may find nothing wrong with edges that are exact.
                let least = if number == 0 && !figure.starts_with("value") { -1.0 } else { 0.0 };
                assert!(one["shadow"][figure].as_f64() > Some(least), "{figure} of {}", methods[number]);
            }
        }
    }
    for (number, part) in [(1, "depth"), (2, "normal"), (3, "ray")] {
        assert!(list[number]["bias"][part].as_f64() >= Some(0.0), "{part}");
    }
}

/// The rule changes what the library answers and what stands beside it, and not the yardstick.
#[test]
fn each_rule_has_its_ideal() {
    let [votes, exact] = ["votes", "exact"].map(|rule| {
        let name = format!("{rule}.json");
        measure_at(50_000, &name, &["--resolution", "128", "--rule", rule]).0["shadow"].clone()
    });
    let figure = |shadow: &Value, name: &str| shadow[name].as_f64().unwrap_or_else(|| panic!("{name}: {shadow}"));
    let of =
        |shadow: &Value| ["wrong_ppm", "ideal_wrong_ppm", "ideal_votes_wrong_ppm"].map(|name| figure(shadow, name));
    let [by_votes, votes_ideal, yardstick] = of(&votes);
    let [by_walks, exact_ideal, same] = of(&exact);
    assert_eq!(yardstick, same);
    assert!((votes_ideal / yardstick - 1.0).abs() < 0.1 && (by_votes / yardstick - 1.0).abs() < 0.1, "{votes}");
    assert!(exact_ideal < 0.2 * yardstick && by_walks < 0.2 * yardstick, "{exact}");
    assert!(figure(&exact, "disagree_ppm") > 10.0 * figure(&votes, "disagree_ppm"), "{exact} {votes}");
    assert!(figure(&exact, "crease_below_ppm") < 0.1 * figure(&votes, "crease_below_ppm"), "{exact} {votes}");
    // Asked over the pixels, edges are smooth; votes don't know what a pixel is.
    let value_error = |shadow: &Value| figure(shadow, "value_error") / figure(&shadow["points"], "value_error");
    assert!(value_error(&exact) < 0.9 && value_error(&votes) == 1.0, "{exact} {votes}");
    let output = run(&["few-large", "--rule", "votes", "--filter", "pcf3"]);
    assert!(!output.status.success() && utf8(&output.stderr).contains("--filter sharp"), "{}", utf8(&output.stderr));
}

#[test]
fn a_soft_light_is_held_against_a_sphere() {
    let soft = ["--resolution", "64", "--filter", "soft", "--light-radius", "0.1"];
    let (json, printed) = measure("soft.json", &soft);
    assert_keys(&json["shadow"], &format!("{SHADOW} soft"));
    assert_keys(&json["shadow"]["soft"], "penumbra_fraction rms penumbra_rms p99 worst");
    let rms = json["shadow"]["soft"]["rms"].as_f64().unwrap();
    assert!(rms > 0.0 && rms < 0.2, "{rms}");
    assert!(printed.contains("light_radius: 0.1"), "{printed}");
}

#[test]
fn what_cannot_be_measured_is_one_line() {
    for (arguments, with) in [
        (&["no such file.glb"][..], "no such file.glb"),
        (&["few-large", "--range", "-3"], "-3"),
        (&["few-large", "--resolution", "0"], "resolution"),
        (&["few-large", "--filter", "soft", "--light-radius", "-1"], "light radius is -1"),
        (&["few-large", "--light", "1000,0,0", "--range", "1"], "reaches no surface"),
    ] {
        let output = run(&[arguments, &["--samples", "100", "--size", "8x8", "--runs", "1"]].concat());
        let said = utf8(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {said}");
        let lines: Vec<&str> = said.lines().filter(|line| line.starts_with("measure: ")).collect();
        assert!(lines.len() == 1 && lines[0].contains(with) && !said.contains("panicked"), "{arguments:?}: {said}");
    }
    for wrong in [
        &["--light", "1,2"][..],
        &["--method", "shadow-volume"],
        &["--samples", "0"],
        &["--texels", "0"],
        &["--size", "1920"],
    ] {
        assert_eq!(run(&[&["few-large"], wrong].concat()).status.code(), Some(2), "{wrong:?}");
    }
}
