//! Files that another file names: in its own folder, never elsewhere.

use std::io;
use std::path::{Component, Path, PathBuf};

/// The folder that the file at `path` lies in; `.` for a bare name.
#[must_use]
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Is it relative, and does it never step up?
pub(crate) fn stays_inside(relative: &Path) -> bool {
    relative.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir))
}

/// The regular file at `relative` in `folder`, links followed, or why it is refused.
pub(crate) fn path_beside(
    folder: &Path,
    relative: &Path,
) -> io::Result<Result<PathBuf, &'static str>> {
    if !stays_inside(relative) {
        return Ok(Err("is absolute or contains `..`"));
    }
    let folder = folder.canonicalize()?;
    let path = folder.join(relative).canonicalize()?;
    if !path.starts_with(&folder) {
        return Ok(Err("leads out of the file's own folder"));
    }
    // A named pipe would block for ever.
    if !path.metadata()?.is_file() {
        return Ok(Err("is not a regular file"));
    }
    Ok(Ok(path))
}
