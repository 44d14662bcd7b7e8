//! The benchmarks as they are run, cut short: that they work and write what they say, not how fast anything is.

use dual_paraboloid::compare::baselines::Method;
use dual_paraboloid::compare::cost::Contestant;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Where a test writes; under the build's own folder, and empty.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("benches").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs a benchmark, and returns its success and what it printed and complained about.
fn bench(name: &str, arguments: &[&str]) -> (bool, String, String) {
    let profile = if cfg!(debug_assertions) { "dev" } else { "release" };
    let mut command = Command::new(env!("CARGO"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(["bench", "--quiet", "--profile", profile, "--bench", name]);
    let output = command.arg("--").args(arguments).output().expect("cargo doesn't start");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.success(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn cost_against_error_in_a_hurry() {
    let out = folder("cost_vs_error");
    let arguments = ["--quick", "--rules", "double-sided,culled", "--out", out.to_str().unwrap()];
    let (success, printed, said) = bench("cost_vs_error", &arguments);
    assert!(success && !said.contains("panicked"), "{said}");
    let report = read(&out.join("cost.md"));
    for title in [
        "# Cost against error",
        "## Scenes made in code, all casters double-sided, R = 64",
        "There are no real scenes",
        "## Stages (ms), R = 64, Scenes made in code, back faces culled",
    ] {
        assert!(printed.contains(title) && report.contains(title), "{title} is missing in:\n{printed}");
    }
    // The main table comes first, with every lookup of every method.
    let main = printed.split("## ").nth(1).expect("a section");
    for rival in Method::ALL.into_iter().filter(|method| *method != Method::Paraboloid) {
        let measured = figures_of(&out, "few-large-double-sided")["costs"].as_array().unwrap().clone();
        let measured = measured.iter().any(|cost| cost["method"] == rival.name());
        for lookup in rival.lookups().iter().filter(|_| measured) {
            let name = Contestant { method: rival, lookup: *lookup }.name();
            assert!(main.contains(&format!("| {name} ")), "{name} is missing in:\n{main}");
        }
    }
    for picture in ["error-time", "time-resolution", "time-triangles", "stages"] {
        for rule in ["double-sided", "culled"] {
            let name = format!("{picture}-{rule}.svg");
            let svg = std::fs::read_to_string(out.join(&name)).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert!(svg.starts_with("<svg") && svg.contains("this library") | svg.contains("cull"), "{name}");
            assert!(report.contains(&format!("({name})")), "{name}");
        }
    }
    for scene in ["few-large", "many-small-20"] {
        for rule in ["double-sided", "culled"] {
            let figures = figures_of(&out, &format!("{scene}-{rule}"));
            check_costs(&figures);
            let own = figures["own"].as_array().expect("this library's errors");
            assert_eq!(own.len(), if rule == "culled" { 0 } else { 2 }, "at each resolution: {own:?}");
            own.iter().for_each(check_own);
            let in_creases = own.iter().any(|of| of["lookups"][0]["creases"]["q001"].is_f64());
            assert!(in_creases || scene != "few-large" || rule == "culled", "the room has edges");
        }
    }
    check_errors(&read(&out.join("errors.md")));
    check_exact(&read(&out.join("exact.md")));
    let readme = read(&out.join("readme.md"));
    let row = readme.lines().find(|line| line.starts_with("| many-small-20 ")).expect("a row of the table by scene");
    let wrong = &figures_of(&out, "many-small-20-double-sided")["costs"];
    let own = wrong.as_array().unwrap().iter().find(|cost| cost["method"] == "paraboloid" && cost["pair"] == 64);
    let own = own.expect("this library")["lookups"][0]["wrong_ppm"].as_f64().unwrap();
    assert_eq!(row.split('|').nth(3).unwrap().trim(), format!("{own:.0}"), "{row}");
}

/// Figures of runs that were made apart, set beside each other.
#[test]
fn runs_are_merged_as_if_they_were_one() {
    let all = folder("merge");
    let [first, second, merged] = ["first", "second", "merged"].map(|name| all.join(name));
    let path = |path: &Path| path.to_str().unwrap().to_owned();
    let run = |arguments: &[&str]| {
        let (success, printed, said) = bench("cost_vs_error", arguments);
        assert!(success, "{said}");
        printed
    };
    let quick = ["--quick", "--methods", "paraboloid,cube"];
    let [of_first, of_second] = [("many-small-20", &first), ("few-large", &second)]
        .map(|(scene, folder)| run(&[&quick[..], &["--scenes", scene, "--out", &path(folder)]].concat()));
    let both = [path(&first), path(&second)].join(",");
    let printed = run(&["--merge", &both, "--out", &path(&merged)]);
    assert_eq!(read(&merged.join("cost.md")).lines().filter(|line| line.starts_with("| few-large ")).count(), 8);
    let rows = |text: &str, scene: &str| -> Vec<String> {
        // Columns are as wide as the widest of their cells.
        let rows = text.lines().filter(|line| line.starts_with(&format!("| {scene} ")));
        rows.map(|row| row.split_whitespace().collect::<Vec<_>>().join(" ")).collect()
    };
    for (text, scene) in [(&of_first, "many-small-20"), (&of_second, "few-large")] {
        assert!(!rows(text, scene).is_empty());
        assert_eq!(rows(&printed, scene), rows(text, scene), "{scene}");
    }
    // A scene again, under the same conditions and others.
    run(&[&quick[..], &["--scenes", "few-large", "--out", &path(&first)]].concat());
    let again = run(&["--merge", &[path(&second), path(&first)].join(",")]);
    assert_eq!(rows(&again, "few-large").len(), 8, "it counts once:\n{again}");
    run(&[&quick[..], &["--scenes", "few-large", "--seed", "2", "--out", &path(&second)]].concat());
    let (success, _, said) = bench("cost_vs_error", &["--merge", &both]);
    assert!(!success && said.contains("few-large was measured under other conditions"), "{said}");
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// What was written of a scene under one rule.
fn figures_of(folder: &Path, name: &str) -> Value {
    let figures: Value = serde_json::from_str(&read(&folder.join(format!("{name}.json")))).unwrap();
    figures["costs"].clone()
}

/// A comparison first, every method in it, and every definition of an error.
fn check_errors(text: &str) {
    let main = text.split("\n## ").nth(1).expect("a section");
    assert!(main.starts_with("This library's wrong answers over others', Scenes made in code"), "{main}");
    assert!(text.contains("There are no real scenes"), "{text}");
    for method in [Method::VertexWarp, Method::Cube] {
        for &lookup in method.lookups() {
            let name = Contestant { method, lookup }.name();
            assert!(main.lines().any(|row| row.starts_with(&format!("| {name} "))), "{name}: {main}");
        }
    }
    for column in ["disagree", "energy", "backs (%)", "creases: mean", "pixels", "value, point", "phantoms"] {
        assert!(text.contains(&format!("| {column} ")) || text.contains(&format!(" {column} |")), "{column}: {text}");
    }
}

/// Each lookup and the rule over the yardstick, fewer texels than the cube, and the rivals at equal error.
fn check_exact(text: &str) {
    let sections: Vec<&str> = text.split("\n## ").collect();
    let rows = |title: &str, row: &str| {
        let of =
            sections.iter().find(|section| section.starts_with(title)).unwrap_or_else(|| panic!("{title}: {text}"));
        let count = of.lines().filter(|line| line.starts_with(&format!("| {row} "))).count();
        assert!(count == 2 || row == "all" && count == 1, "{row} in {of}");
    };
    for lookup in ["paraboloid", "votes", "rule"] {
        rows("Over votes-v1, Scenes made in code", lookup);
    }
    rows("R = 32 over the cube with the same votes at the texels of R = 64", "all");
    for rival in ["cube: cube-hardware", "cube: cube-plane", "cube-compute: cube-walk"] {
        rows("Equal error, Scenes made in code", rival);
    }
}

/// All lookups of the library, with every figure.
fn check_own(own: &Value) {
    let lookups = own["lookups"].as_array().expect("a list of lookups");
    assert_eq!(lookups.len(), Method::Paraboloid.lookups().len());
    for of in lookups {
        for figure in ["wrong_ppm", "wrong_energy_ppm", "far_wrong_ppm", "back_fraction", "wrong_front_ppm"] {
            assert!(of["shadow"][figure].is_f64(), "{figure}: {of}");
        }
        for asked in ["pixels", "points"] {
            assert!(of["pixels"][asked]["value_error"].is_f64(), "{of}");
        }
    }
    assert!(own["map"]["strays"].is_u64(), "{own}");
    for ideal in ["ideal", "rule"] {
        assert!(own[ideal]["wrong_ppm"].is_f64(), "{own}");
    }
}

/// Every method at two resolutions, cubes in two sizes at the greater one, and every lookup with its errors and times.
fn check_costs(scene: &Value) {
    let costs = scene["costs"].as_array().expect("a list of costs");
    for method in [
        Method::Paraboloid,
        Method::VertexWarp,
        Method::DepthView,
        Method::Cube,
        Method::CubeUnculled,
        Method::CubeRouted,
        Method::CubeCompute,
    ] {
        let of: Vec<&Value> = costs.iter().filter(|cost| cost["method"] == method.name()).collect();
        assert_eq!(of.len(), if method.is_cube() { 3 } else { 2 }, "{method} in {}", scene["scene"]);
        for cost in of {
            assert!(cost["gpu"]["ms_median"].as_f64() > Some(0.0), "{cost}");
            assert!(cost["cpu"]["ms_median"].as_f64() > Some(0.0), "{cost}");
            assert!(cost["bytes"]["per_light"].as_u64() > Some(0), "{cost}");
            assert_eq!(cost["stages"].is_null(), method != Method::Paraboloid, "{cost}");
            let lookups = cost["lookups"].as_array().expect("a list of lookups");
            assert_eq!(lookups.len(), method.lookups().len(), "{cost}");
            lookups.iter().for_each(check_lookup);
        }
    }
}

/// The error over two orientations, and times over two screens.
fn check_lookup(lookup: &Value) {
    let turned: Vec<f64> =
        lookup["wrong_ppm_by_orientation"].as_array().unwrap().iter().filter_map(Value::as_f64).collect();
    assert_eq!(turned.len(), 2, "{lookup}");
    assert!((lookup["wrong_ppm"].as_f64().unwrap() - 0.5 * (turned[0] + turned[1])).abs() < 1e-6, "{lookup}");
    let screens = lookup["screens"].as_array().expect("a list of screens");
    assert_eq!(screens.len(), 2, "{lookup}");
    for stage in ["compute", "fragment"] {
        assert!(screens.iter().all(|screen| screen[stage]["ms_median"].as_f64() > Some(0.0)), "{lookup}");
    }
}

#[test]
fn what_cannot_be_measured_is_one_line() {
    let (success, _, said) = bench("cost_vs_error", &["--scenes", "no such scene"]);
    let lines: Vec<&str> = said.lines().filter(|line| line.starts_with("cost_vs_error: ")).collect();
    assert!(!success && lines.len() == 1 && lines[0].contains("no such scene"), "{said}");
    // A map wider than any device has: left out, and said so.
    let arguments = ["--quick", "--resolution", "64,1000000", "--rules", "culled", "--scenes", "few-large"];
    let (success, printed, said) = bench("cost_vs_error", &arguments);
    assert!(success && printed.contains("the resolution of paraboloid is 1000000"), "{said}\n{printed}");
}

#[test]
fn lookups_in_a_hurry() {
    let out = folder("lookup").join("table.md");
    let (success, printed, said) = bench("lookup", &["--quick", "--out", out.to_str().unwrap()]);
    assert!(success && !said.contains("panicked"), "{said}");
    let table = std::fs::read_to_string(out).unwrap();
    for text in [
        "few-large",
        "| paraboloid",
        "dp_shadow_soft, 32 taps",
        "cube, 3x3 by hardware",
        "compute pass",
        "fragment pass",
    ] {
        assert!(printed.contains(text) && table.contains(text), "{text} is missing in:\n{printed}");
    }
}

#[test]
fn triangles_asked_of_several_lights_in_a_hurry() {
    let out = folder("lights");
    let [table, json] = ["table.md", "figures.json"].map(|name| out.join(name).to_str().unwrap().to_owned());
    let arguments = ["--quick", "--lights", "1,3", "--out", &table, "--json", &json];
    let (success, printed, said) = bench("lookup", &arguments);
    assert!(success && !said.contains("panicked"), "{said}");
    let table = std::fs::read_to_string(table).unwrap();
    for text in
        ["exact, over the pixel", "exact, points", "votes", "the same walk", "|  64 |", "|  16 |", "3 lights", "mixed"]
    {
        assert!(printed.contains(text) && table.contains(text), "{text} is missing in:\n{printed}");
    }
    let figures: Value = serde_json::from_slice(&std::fs::read(json).unwrap()).unwrap();
    let scenes = figures["scenes"].as_array().expect("a list of scenes");
    assert_eq!(scenes.iter().map(|of| of["lights"].as_u64().unwrap()).collect::<Vec<_>>(), [1, 3]);
    for of in scenes {
        // Four lookups at two resolutions, the cube and nothing, in two kinds of pass.
        assert_eq!(of["times"].as_array().map(Vec::len), Some(20), "{of}");
        // Coarser texels disagree more often.
        let mixed: Vec<f64> = (0..2).filter_map(|at| of["mixed"][at][1].as_f64()).collect();
        assert!(mixed.len() == 2 && 0.0 < mixed[0] && mixed[0] < mixed[1] && mixed[1] < 1.0, "{of}");
    }
}

#[test]
fn recording_once() {
    let (success, printed, said) = bench("recording", &["--test"]);
    assert!(success && printed.contains("100000"), "{said}\n{printed}");
}
