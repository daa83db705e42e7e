//! Reading a scene file, with the JSON path of whatever is wrong.

use std::path::{Path, PathBuf};

use serde_json::error::Category;
use serde_json::{Map, Value};

use super::Scene;
use super::check::check;
use crate::error::SceneError;

/// The file that a path to a scene names: of a folder the `scene.json` in it.
#[must_use]
pub fn scene_file(path: &Path) -> PathBuf {
    if path.is_dir() { path.join("scene.json") } else { path.to_owned() }
}

/// Reads and checks a scene, or the `scene.json` of a folder.
///
/// # Errors
/// [`SceneError`], naming the file and the place in it, when the file can't be read, is of another
/// kind, is no JSON of this form, has an unknown field, or holds a value outside its range.
pub fn read_scene(path: &Path) -> Result<Scene, SceneError> {
    let path = &scene_file(path);
    let file = path.display().to_string();
    let text = read_text(path, &file)?;
    let mut json = serde_json::Deserializer::from_str(&text);
    let mut scene: Scene = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let json_path = error.path().to_string();
        let source = error.into_inner();
        let file = file.clone();
        match source.classify() {
            Category::Data => SceneError::Form { file, path: json_path, source },
            _ => SceneError::NoJson { file, source },
        }
    })?;
    json.end().map_err(|source| SceneError::NoJson { file: file.clone(), source })?;
    // an empty name that is stated is refused below
    if scene.name.is_empty() && names_nothing(&text) {
        scene.name = default_name(path);
    }
    check(&scene).map_err(|fault| SceneError::Value {
        file,
        path: fault.path,
        expected: fault.expected,
        found: fault.found,
    })?;
    Ok(scene)
}

fn names_nothing(text: &str) -> bool {
    let fields: Result<Map<String, Value>, _> = serde_json::from_str(text);
    fields.is_ok_and(|fields| !fields.contains_key("name"))
}

/// The stem of the file, or the name of the folder of a `scene.json`, in letters that a name may have.
pub(crate) fn default_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_owned();
    let folder = || path.canonicalize().ok()?.parent()?.file_name().map(ToOwned::to_owned);
    let name = if stem == "scene" { folder().unwrap_or(stem) } else { stem };
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
    name.to_string_lossy().chars().map(plain).collect()
}

/// The text of a file that may be a scene.
fn read_text(path: &Path, file: &str) -> Result<String, SceneError> {
    let bytes = std::fs::read(path)
        .map_err(|source| SceneError::Unreadable { file: file.to_owned(), source })?;
    let not_a_scene =
        |(found, advice)| SceneError::NotAScene { file: file.to_owned(), found, advice };
    let ending = path.extension().and_then(|ending| ending.to_str());
    if let Some(known) = ending.and_then(other_kind) {
        return Err(not_a_scene(known));
    }
    String::from_utf8(bytes).map_err(|_| {
        not_a_scene(("other bytes", "name the scene's .json, whose fields docs/scene.md lists"))
    })
}

/// What a file with this ending is, and what takes it.
fn other_kind(ending: &str) -> Option<(&'static str, &'static str)> {
    match ending.to_ascii_lowercase().as_str() {
        "glb" | "gltf" => Some(("a surface", "`hapdef new` makes a limb of it, with a scene")),
        "hapdef" => Some((
            "a bundle",
            "`hapdef live` and `hapdef doctor` take it, the others the scene it was made of",
        )),
        _ => None,
    }
}
