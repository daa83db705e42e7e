//! Reading a scene file, with the JSON path of whatever is wrong.

use std::path::Path;

use super::Scene;
use super::check::check;
use crate::error::SceneError;

/// Reads and checks a scene.
///
/// # Errors
/// [`SceneError`], naming the file and the JSON path, when the file can't be read, is no JSON of
/// this form, has an unknown field, or holds a value outside its range.
pub fn read_scene(path: &Path) -> Result<Scene, SceneError> {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path).map_err(|source| SceneError::Unreadable {
        file: file.clone(),
        source,
    })?;
    let mut json = serde_json::Deserializer::from_str(&text);
    let scene: Scene = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let json_path = error.path().to_string();
        SceneError::Form {
            file: file.clone(),
            path: json_path,
            source: error.into_inner(),
        }
    })?;
    json.end().map_err(|source| SceneError::Form {
        file: file.clone(),
        path: "end of file".into(),
        source,
    })?;
    check(&scene).map_err(|fault| SceneError::Value {
        file,
        path: fault.path,
        expected: fault.expected,
        found: fault.found,
    })?;
    Ok(scene)
}
