//! Files that a command writes, none of which is overwritten unasked, and files that it tells apart.

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read};
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

/// A bundle begins with the length of a header and `{`; a scene is text.
pub(super) fn is_bundle(path: &Path) -> Result<bool> {
    let shown = || shown(path);
    let mut begin = [0; 9];
    let mut file = File::open(path).with_context(|| format!("{}: check the path", shown()))?;
    let n = file.read(&mut begin).with_context(shown)?;
    let has_its_name = path.extension().is_some_and(|e| e == "hapdef");
    Ok(has_its_name || (n == begin.len() && begin[8] == b'{' && begin[7] == 0))
}
