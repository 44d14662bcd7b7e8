//! `docs/scenes.md` says what the scenes are.

use crate::stated::{SCENES, Stated};
use crate::{trial, trial_of_file};
use dual_paraboloid::compare::measure::find_scene;
use dual_paraboloid::compare::scene::known_lights;
use libtest_mimic::Trial;
use sha2::{Digest, Sha256};
use std::path::Path;

const PAGE: &str = include_str!("../../docs/scenes.md");

/// What has to be said of each scene.
const ROWS: [&str; 9] =
    ["Source", "Licence", "Attribution", "Conversion", "Triangles", "Bytes", "SHA-256", "Why it is hard", "Lights"];

pub fn trials() -> Vec<Trial> {
    vec![
        trial("page_has_every_scene", page_has_every_scene),
        trial("page_has_the_scenes_made_in_code", page_has_the_scenes_made_in_code),
    ]
}

pub fn trials_of(scene: &'static Stated) -> Vec<Trial> {
    vec![trial_of_file(scene, "file", the_file_is_the_one_of_the_page)]
}

/// The headings of the scenes, each with its cells by the name of their row.
fn sections() -> impl Iterator<Item = (&'static str, Vec<(&'static str, &'static str)>)> {
    PAGE.split("\n### ").skip(1).map(|section| {
        let (heading, rest) = section.split_once('\n').unwrap_or((section, ""));
        (heading.trim(), rest.lines().filter_map(row).collect())
    })
}

/// The first two cells of a table's row.
fn row(line: &str) -> Option<(&str, &str)> {
    let mut cells = line.strip_prefix('|')?.split('|').map(str::trim);
    Some((cells.next()?, cells.next()?))
}

/// What a scene's section says in a row.
fn cell(file: &str, name: &str) -> &'static str {
    let (_, rows) = sections().find(|(heading, _)| *heading == file).unwrap_or_else(|| panic!("no section {file}"));
    rows.iter().find(|(row, _)| *row == name).unwrap_or_else(|| panic!("{file} has no row {name}")).1
}

fn number(text: &str) -> u64 {
    text.replace(',', "").parse().unwrap_or_else(|error| panic!("{text:?}: {error}"))
}

/// Positions such as "(1, 2, 3), (4, 5, 6)".
fn positions(text: &str) -> Vec<[f32; 3]> {
    let position = |part: &str| -> [f32; 3] {
        let (inner, _) = part.split_once(')').expect("a closing bracket");
        let numbers: Vec<f32> = inner.split(',').map(|x| x.trim().parse().expect("a number")).collect();
        numbers.try_into().expect("three coordinates")
    };
    text.split('(').skip(1).map(position).collect()
}

fn page_has_every_scene() {
    let headings: Vec<&str> = sections().map(|(heading, _)| heading).collect();
    assert_eq!(headings, SCENES.iter().map(|scene| scene.file).collect::<Vec<_>>());
    for scene in SCENES {
        for row in ROWS {
            assert!(!cell(scene.file, row).is_empty(), "{}: {row}", scene.file);
        }
        assert_eq!(number(cell(scene.file, "Triangles")), scene.triangles as u64, "{}", scene.file);
        assert_eq!(positions(cell(scene.file, "Lights")), known_lights(scene.file), "{}", scene.file);
    }
}

fn page_has_the_scenes_made_in_code() {
    let (made, _) = PAGE.split_once("\n## Conversion").expect("the section after them");
    let rows: Vec<_> = made.lines().filter_map(row).skip(2).collect();
    assert!(rows.len() >= 5, "{rows:?}");
    for (name, triangles) in rows {
        let scene = find_scene(name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scene.triangle_count() as u64, number(triangles), "{name}");
    }
}

fn the_file_is_the_one_of_the_page(stated: &Stated, path: &Path) {
    let bytes = std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert_eq!(bytes.len() as u64, number(cell(stated.file, "Bytes")));
    let sum: String = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(sum, cell(stated.file, "SHA-256").trim_matches('`'));
}
