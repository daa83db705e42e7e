//! Files that a deck includes: beside it, never from elsewhere, not deeper than allowed.

use std::path::{Path, PathBuf};

use super::inp_keyword::cards;
use super::source;
use crate::MeshError;
use crate::beside::{folder_of, path_beside};

/// How deep files may include one another: a file that includes itself ends here.
const MAX_DEPTH: usize = 8;

/// The files that a deck may include, and the bytes left for them.
pub(super) struct Includes {
    folder: PathBuf,
    bytes_left: u64,
    depth: usize,
    opened: Vec<PathBuf>,
}

impl Includes {
    /// Files in the folder of the deck at `path`, of at most `bytes_left` bytes together.
    pub(super) fn beside(path: &Path, bytes_left: u64) -> Self {
        let folder = folder_of(path).to_owned();
        Self { folder, bytes_left, depth: 0, opened: Vec::new() }
    }

    /// What `read` makes of the text of a file, or of why it can't be read.
    pub(super) fn open<T>(
        &mut self,
        file: &str,
        read: impl FnOnce(&mut Self, Result<&str, &'static str>) -> T,
    ) -> T {
        let bytes = match self.bytes(file) {
            Ok(bytes) => bytes,
            Err(why) => return read(self, Err(why)),
        };
        self.depth += 1;
        let done = read(self, Ok(&source::text(&bytes)));
        self.depth -= 1;
        done
    }

    fn bytes(&mut self, file: &str) -> Result<Vec<u8>, &'static str> {
        if self.depth == MAX_DEPTH {
            return Err("files include one another more than eight deep");
        }
        let path = path_beside(&self.folder, Path::new(file));
        let path = path.map_err(|_| "the file is not there; put it beside the deck")??;
        let bytes = source::read(&path, self.bytes_left)
            .map_err(|_| "the file can't be read, or is longer than what is left of the limit")?;
        self.bytes_left -= bytes.len() as u64;
        self.opened.push(path);
        Ok(bytes)
    }
}

/// The files that the deck at `path` includes, by `*INCLUDE`, in order: none for a deck that is
/// complete in itself. What can't be opened is left out; reading the deck says why.
///
/// # Errors
/// [`MeshError::Io`] if the deck can't be read.
pub fn deck_includes(path: &Path, max_bytes: u64) -> Result<Vec<PathBuf>, MeshError> {
    if !matches!(source::kind(path), Ok(source::DeckKind::Inp)) {
        return Ok(Vec::new());
    }
    let bytes = source::read(path, max_bytes)?;
    let mut includes = Includes::beside(path, max_bytes - bytes.len() as u64);
    follow(&source::text(&bytes), &mut includes);
    Ok(includes.opened)
}

fn follow(text: &str, includes: &mut Includes) {
    if !text.lines().any(starts_include) {
        return;
    }
    for card in cards(text).unwrap_or_default().iter().filter(|card| card.name == "INCLUDE") {
        let file = card.parameter("INPUT").unwrap_or_default();
        includes.open(file, |includes, text| text.map(|text| follow(text, includes)).ok());
    }
}

fn starts_include(line: &str) -> bool {
    line.trim_start().get(..8).is_some_and(|word| word.eq_ignore_ascii_case("*include"))
}
