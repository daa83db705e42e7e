//! A deck's text: plain or gzip, never longer than allowed.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::{DeckFault, DeckParams};
use crate::MeshError;

/// Which reader a deck needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DeckKind {
    /// Abaqus or CalculiX keywords.
    Inp,
    /// ANSYS commands.
    Ansys,
}

/// The kind a file name states.
pub(super) fn kind(path: &Path) -> Result<DeckKind, DeckFault> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let plain = name.strip_suffix(".gz").unwrap_or(&name);
    match plain.rsplit_once('.').map(|(_, ending)| ending) {
        Some("inp") => Ok(DeckKind::Inp),
        Some("dat" | "cdb") => Ok(DeckKind::Ansys),
        _ => Err(DeckFault::FileName { found: name }),
    }
}

/// The decompressed text. Bytes that are not UTF-8 occur in comments and titles of decks written
/// on Windows; they become replacement characters.
pub(super) fn read(path: &Path, params: &DeckParams) -> Result<String, MeshError> {
    let failed = |cause| MeshError::Io { action: "read", path: path.to_owned(), cause };
    let file = File::open(path).map_err(failed)?;
    let bytes = if is_gzip(path) {
        read_capped(MultiGzDecoder::new(io::BufReader::new(file)), params)
    } else {
        read_capped(file, params)
    };
    let too_long = || DeckFault::TooLong { max_bytes: params.max_bytes };
    let bytes = bytes
        .map_err(failed)?
        .ok_or_else(|| MeshError::Deck { path: path.to_owned(), fault: too_long() })?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn is_gzip(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gz"))
}

/// `None` if there is more than allowed.
fn read_capped(source: impl Read, params: &DeckParams) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    source.take(params.max_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= params.max_bytes).then_some(bytes))
}
