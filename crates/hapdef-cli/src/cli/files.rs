//! Files that a command writes: none is overwritten unasked.

use std::fs::{File, OpenOptions};
use std::io::ErrorKind;
use std::path::Path;

use anyhow::{Context, Result, bail};
use hapdef_cli::shown;

/// A new file for what `option` names; a pipe or a device may be there already.
pub(super) fn new_file(path: &Path, option: &str) -> Result<File> {
    let mut options = OpenOptions::new();
    let is_no_file = std::fs::metadata(path).is_ok_and(|data| !data.is_file());
    match options.write(true).create_new(!is_no_file).open(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            bail!("{option}: {} is there already; choose another name or remove it", shown(path))
        }
        opened => opened.with_context(|| format!("{option}: writing {}", shown(path))),
    }
}
