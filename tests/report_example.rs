//! The example `report` as it is run: the main table first, every method in it, errors that are one line.

use dual_paraboloid::compare::baselines::Method;
use dual_paraboloid::compare::cost::Contestant;
use std::process::{Command, Output};

fn report(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO"));
    let profile: &[&str] = if cfg!(debug_assertions) { &[] } else { &["--release"] };
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(["run", "--quiet", "--features", "compare"]).args(profile);
    command.args(["--example", "report", "--"]).args(arguments);
    command.output().expect("cargo doesn't start")
}

#[test]
fn scenes_made_in_code_give_the_main_table_where_there_are_no_files() {
    let quick = ["--samples", "2000", "--orientations", "2", "--resolution", "64", "--size", "32x18"];
    let output = report(&[&quick[..], &["--scenes", "few-large,dense-10k,dense-20k"]].concat());
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let main = text.split("\n## ").nth(1).expect("a section");
    assert!(main.starts_with("This library's wrong answers over others', scenes made in code"), "{main}");
    assert!(text.contains("There are no real scenes"), "{text}");
    for method in [Method::VertexWarp, Method::Cube] {
        for &lookup in method.lookups() {
            let name = Contestant { method, lookup }.name();
            let row = main.lines().find(|row| row.starts_with(&format!("| {name} "))).expect("a row");
            // The dense scenes are one.
            assert!(row.ends_with("of 2 |"), "{row}");
        }
    }
    for column in ["disagree", "energy", "creases: mean", "pixels", "value, point", "phantoms"] {
        assert!(text.contains(&format!("| {column} ")) || text.contains(&format!(" {column} |")), "{column}: {text}");
    }
}

#[test]
fn what_cannot_be_measured_is_one_line() {
    for wrong in [["--scenes", "no such scene"], ["--size", "big"]] {
        let output = report(&wrong);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && said.contains(wrong[1]) && !said.contains("panicked"), "{said}");
    }
}
