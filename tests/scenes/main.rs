//! The test scenes of `docs/scenes.md`: their files, and what the library makes of them. One test for each scene and
//! question, `scenes::SCENE::QUESTION`.
//!
//! The scenes are third-party files outside this repository, in the folder that `DP_SCENES` names. Tests of what isn't
//! there are ignored, and say so.

#[path = "../gpu/claims.rs"]
mod claims;
#[path = "../gpu/common.rs"]
#[allow(dead_code, reason = "shared with the tests of scenes made in code")]
mod common;
mod library;
mod loading;
mod page;
mod stated;

use dual_paraboloid::compare::scene::{Scene, scenes_dir};
use libtest_mimic::{Arguments, Completion, Trial};
use stated::{SCENES, Stated};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let mut trials = page::trials();
    trials.extend(loading::trials());
    for scene in SCENES {
        trials.extend(page::trials_of(scene));
        trials.extend(loading::trials_of(scene));
        trials.extend(library::trials_of(scene));
    }
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// A test that needs no file.
fn trial(question: &str, test: fn()) -> Trial {
    Trial::test(format!("scenes::{question}"), move || {
        test();
        Ok(())
    })
}

/// A test of the folder of the test scenes.
fn trial_of_folder(question: &str, test: fn(&Path)) -> Trial {
    ignorable(format!("scenes::{question}"), folder, test)
}

/// A test of a scene's file.
fn trial_of_file(scene: &'static Stated, question: &str, test: fn(&Stated, &Path)) -> Trial {
    ignorable(format!("scenes::{}::{question}", scene.name()), || file(scene), move |path| test(scene, path))
}

/// A test of a scene.
fn trial_of(scene: &'static Stated, question: &str, test: fn(&Stated, &Scene)) -> Trial {
    ignorable(
        format!("scenes::{}::{question}", scene.name()),
        || file(scene),
        move |path| test(scene, &Scene::load(path).unwrap_or_else(|error| panic!("{error}"))),
    )
}

/// A test of what is at a place, ignored for the reason for which nothing is.
fn ignorable(
    name: String,
    place: impl FnOnce() -> Result<PathBuf, String> + Send + 'static,
    test: impl FnOnce(&Path) + Send + 'static,
) -> Trial {
    Trial::ignorable_test(name, || {
        Ok(match place() {
            Ok(path) => {
                test(&path);
                Completion::Completed
            }
            Err(reason) => Completion::ignored_with(reason),
        })
    })
}

fn folder() -> Result<PathBuf, String> {
    scenes_dir().ok_or_else(|| "no folder of test scenes: name one in DP_SCENES, see docs/scenes.md".to_owned())
}

fn file(scene: &Stated) -> Result<PathBuf, String> {
    let path = folder()?.join(scene.file);
    if path.is_file() { Ok(path) } else { Err(format!("there is no {}, see docs/scenes.md", path.display())) }
}
