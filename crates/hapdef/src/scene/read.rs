//! Reading a scene file, with the JSON path of whatever is wrong.

use std::path::Path;

use serde_json::error::Category;

use super::Scene;
use super::check::check;
use crate::error::SceneError;

/// Reads and checks a scene.
///
/// # Errors
/// [`SceneError`], naming the file and the place in it, when the file can't be read, is of another
/// kind, is no JSON of this form, has an unknown field, or holds a value outside its range.
pub fn read_scene(path: &Path) -> Result<Scene, SceneError> {
    let file = path.display().to_string();
    let text = read_text(path, &file)?;
    let mut json = serde_json::Deserializer::from_str(&text);
    let scene: Scene = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let json_path = error.path().to_string();
        let source = error.into_inner();
        let file = file.clone();
        match source.classify() {
            Category::Data => SceneError::Form { file, path: json_path, source },
            _ => SceneError::NoJson { file, source },
        }
    })?;
    json.end().map_err(|source| SceneError::NoJson { file: file.clone(), source })?;
    check(&scene).map_err(|fault| SceneError::Value {
        file,
        path: fault.path,
        expected: fault.expected,
        found: fault.found,
    })?;
    Ok(scene)
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
        "glb" | "gltf" => {
            Some(("a surface", "`hapdef shell` makes a limb of it, with a scene beside it"))
        }
        "hapdef" => Some((
            "a bundle",
            "`hapdef live` and `hapdef doctor` take it, the others the scene it was made of",
        )),
        _ => None,
    }
}
