//! A deck's bytes and text: plain or gzip, never longer than allowed.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::DeckFault;
use crate::MeshError;

/// Which reader a deck needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DeckKind {
    /// Abaqus or CalculiX keywords.
    Inp,
    /// ANSYS commands.
    Ansys,
    /// gmsh's own format.
    Msh,
}

/// The kind a file name states.
pub(super) fn kind(path: &Path) -> Result<DeckKind, DeckFault> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let plain = name.strip_suffix(".gz").unwrap_or(&name);
    match plain.rsplit_once('.').map(|(_, ending)| ending) {
        Some("inp") => Ok(DeckKind::Inp),
        Some("dat" | "cdb") => Ok(DeckKind::Ansys),
        Some("msh") => Ok(DeckKind::Msh),
        _ => Err(DeckFault::FileName { found: name }),
    }
}

/// The decompressed bytes.
pub(super) fn read(path: &Path, max_bytes: u64) -> Result<Vec<u8>, MeshError> {
    let failed = |cause| MeshError::Io { action: "read", path: path.to_owned(), cause };
    let too_long =
        || MeshError::Deck { path: path.to_owned(), fault: DeckFault::TooLong { max_bytes } };
    let file = File::open(path).map_err(failed)?;
    let bytes = if is_gzip(path) {
        read_capped(MultiGzDecoder::new(io::BufReader::new(file)), max_bytes)
    } else {
        read_capped(file, max_bytes)
    };
    bytes.map_err(failed)?.ok_or_else(too_long)
}

/// The text without a byte-order mark. Bytes that are not UTF-8 occur in comments and titles of
/// decks written on Windows; they become replacement characters.
pub(super) fn text(bytes: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
}

fn is_gzip(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gz"))
}

/// `None` if there is more than allowed.
fn read_capped(source: impl Read, max_bytes: u64) -> io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    source.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= max_bytes).then_some(bytes))
}
