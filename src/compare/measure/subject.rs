//! What is measured: a scene by name or file, and a light in it.

use std::fmt;
use std::path::{Path, PathBuf};

use glam::Vec3;

use super::light_for;
use crate::PointLight;
use crate::compare::procedural;
use crate::compare::scene::{Camera, Scene, SceneError, known_lights, scene_files, scenes_dir, stated_camera};

/// The names that [`find_scene`] knows; `N` is a number, with `k` or `m` for thousands or millions.
pub const PROCEDURAL: &str = "hall, few-large, many-small, many-small-N, dense-N (say dense-1m), long-hall";

/// The scenes made in code that methods are compared on, those of a million triangles and more last.
pub const SCENES_IN_CODE: [&str; 7] =
    ["few-large", "many-small", "long-hall", "hall", "dense-1m", "dense-4m", "dense-17m"];

/// Objects of `many-small` where no number is given.
const MANY_SMALL: usize = 2000;

/// Makes the procedural scene of that name ([`PROCEDURAL`]), or loads the file.
///
/// # Errors
/// Whatever [`Scene::load`] returns.
pub fn find_scene(name: &str) -> Result<Scene, SceneError> {
    match Procedural::parse(name) {
        Some(procedural) => Ok(Scene { name: name.to_owned(), ..procedural.make() }),
        None => Scene::load(Path::new(name)),
    }
}

/// Whether [`find_scene`] makes the scene of that name in code.
#[must_use]
pub fn is_made_in_code(name: &str) -> bool {
    Procedural::parse(name).is_some()
}

/// The scenes that are wanted, each by a name that [`find_scene`] takes: a procedural scene, a file, or part of the
/// name of files in the folder of test scenes ([`scenes_dir`]).
///
/// # Errors
/// [`SceneError::Read`] if that folder can't be read, or for a name that is none of these.
pub fn select_scenes(wanted: &[String]) -> Result<Vec<String>, SceneError> {
    let files = scenes_dir().map_or(Ok(Vec::new()), |folder| scene_files(&folder))?;
    let mut names = Vec::new();
    for part in wanted {
        if Procedural::parse(part).is_some() || Path::new(part).is_file() {
            names.push(part.clone());
            continue;
        }
        let fits = |path: &&PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().contains(part));
        let found: Vec<String> = files.iter().filter(fits).map(|path| path.to_string_lossy().into_owned()).collect();
        if found.is_empty() {
            let source = std::io::Error::new(std::io::ErrorKind::NotFound, "no such scene, made in code or in a file");
            return Err(SceneError::Read { path: part.into(), source });
        }
        names.extend(found);
    }
    Ok(names)
}

/// A scene made in code, not made yet.
enum Procedural {
    Hall,
    FewLarge,
    ManySmall(usize),
    Dense(usize),
    LongHall,
}

impl Procedural {
    fn parse(name: &str) -> Option<Self> {
        match name {
            "hall" => Some(Self::Hall),
            "few-large" => Some(Self::FewLarge),
            "many-small" => Some(Self::ManySmall(MANY_SMALL)),
            "long-hall" => Some(Self::LongHall),
            _ => match name.strip_prefix("dense-") {
                Some(number) => count(number).map(Self::Dense),
                None => count(name.strip_prefix("many-small-")?).map(Self::ManySmall),
            },
        }
    }

    fn make(self) -> Scene {
        match self {
            Self::Hall => procedural::hall(),
            Self::FewLarge => procedural::few_large(),
            Self::ManySmall(objects) => procedural::many_small(objects),
            Self::Dense(triangles) => procedural::dense(triangles),
            Self::LongHall => procedural::long_hall(),
        }
    }
}

/// A number above 0 such as 300, 250k or 4m, up to a hundred millions.
fn count(text: &str) -> Option<usize> {
    let (digits, unit) = match text.strip_suffix(['k', 'm']) {
        Some(digits) if text.ends_with('k') => (digits, 1000),
        Some(digits) => (digits, 1_000_000),
        None => (text, 1),
    };
    let number = digits.parse::<usize>().ok()?.checked_mul(unit)?;
    (1..=100_000_000).contains(&number).then_some(number)
}

/// Who said where the light is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightChoice {
    /// The caller.
    Given,
    /// The scene's own first point light.
    Scene,
    /// The list of lights for known files, [`known_lights`].
    Known,
    /// [`Scene::suggest_light`].
    Suggested,
}

impl fmt::Display for LightChoice {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(match self {
            Self::Given => "given",
            Self::Scene => "the scene's own",
            Self::Known => "known for this file",
            Self::Suggested => "suggested by the scene's shape",
        })
    }
}

/// The light to measure with. Without a `position`, the first point light that the scene itself has, else the first of
/// [`known_lights`], else [`Scene::suggest_light`]. Without a `range`, that of the scene's own light, else past the
/// whole scene. The near distance is always that of [`light_for`].
#[must_use]
pub fn choose_light(scene: &Scene, position: Option<Vec3>, range: Option<f32>) -> (PointLight, LightChoice) {
    let own = scene.lights.first().filter(|_| position.is_none());
    let known = known_lights(&scene.name).first().map(|&at| Vec3::from_array(at));
    let (position, choice) = match (position, own, known) {
        (Some(position), ..) => (position, LightChoice::Given),
        (_, Some(light), _) => (light.position, LightChoice::Scene),
        (_, _, Some(position)) => (position, LightChoice::Known),
        _ => (scene.suggest_light(), LightChoice::Suggested),
    };
    let whole = light_for(scene, position);
    let range = range.or(own.and_then(|light| light.range)).unwrap_or(whole.range);
    (PointLight { range, ..whole }, choice)
}

/// The camera to measure with: the scene's [`stated_camera`], unless there is none or the light was `Given`, perhaps in
/// another room; then [`Scene::suggest_camera`].
#[must_use]
pub fn choose_camera(scene: &Scene, light: &PointLight, choice: LightChoice) -> Camera {
    let stated = stated_camera(&scene.name).filter(|_| choice != LightChoice::Given);
    stated.unwrap_or_else(|| scene.suggest_camera(light.position))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_by_name() {
        for (name, triangles) in [("few-large", 372), ("dense-10k", procedural::dense(10_000).triangle_count())] {
            let scene = find_scene(name).expect("a procedural scene");
            assert_eq!((scene.name.as_str(), scene.triangle_count()), (name, triangles));
        }
        assert!(["dense-", "dense-0", "many-small-"].iter().all(|name| Procedural::parse(name).is_none()));
        assert!(find_scene("no such scene").is_err());
    }

    #[test]
    fn selected_scenes_are_made_in_code_or_found() {
        let wanted = ["dense-1m", "hall"].map(str::to_owned);
        assert_eq!(select_scenes(&wanted).unwrap(), wanted);
        let error = select_scenes(&["no such scene".to_owned()]).unwrap_err().to_string();
        assert!(error.contains("no such scene"), "{error}");
    }

    #[test]
    fn counts() {
        assert_eq!(["7", "250k", "4m"].map(count), [Some(7), Some(250_000), Some(4_000_000)]);
        assert_eq!(["", "k", "0", "-1", "1g", "999999999999999999999", "101m"].map(count), [None; 7]);
    }

    #[test]
    fn the_light_is_the_one_given_or_the_scenes_own() {
        let mut scene = procedural::few_large();
        let (own, choice) = choose_light(&scene, None, None);
        assert_eq!((own.position, own.range, choice), (scene.lights[0].position, 40.0, LightChoice::Scene));
        let (given, choice) = choose_light(&scene, Some(Vec3::ONE), Some(3.0));
        assert_eq!((given.position, given.range, choice), (Vec3::ONE, 3.0, LightChoice::Given));
        assert_eq!(given.near, light_for(&scene, Vec3::ONE).near);
        scene.lights.clear();
        assert_eq!(choose_light(&scene, None, None).1, LightChoice::Suggested);
        scene.name = "barn_lamp".to_owned();
        assert_eq!(choose_light(&scene, None, None).1, LightChoice::Known);
    }

    #[test]
    fn the_camera_is_the_stated_one_but_for_a_given_light() {
        let scene = find_scene("few-large").expect("a procedural scene");
        let (light, choice) = choose_light(&scene, None, None);
        assert_eq!(Some(choose_camera(&scene, &light, choice)), stated_camera("few-large"));
        let suggested = scene.suggest_camera(light.position);
        assert_eq!(choose_camera(&scene, &light, LightChoice::Given), suggested);
        let unknown = Scene { name: "unknown".to_owned(), ..scene };
        assert_eq!(choose_camera(&unknown, &light, choice), suggested);
    }
}
