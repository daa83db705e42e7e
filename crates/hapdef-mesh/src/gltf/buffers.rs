//! The bytes behind a glTF file: BIN chunk, data URIs and files beside it, within a byte budget.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::json::Root;

use super::GltfFault;
use crate::beside::{path_beside, stays_inside};

/// Exporters disagree on the closing `=`, which carries nothing.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Characters of a refused address that an error repeats.
const SHOWN_URI_CHARS: usize = 60;

/// Where buffers may come from and how many bytes they may have together.
pub(super) struct BufferSource<'a> {
    /// The folder of the .gltf file, which no buffer may leave.
    pub folder: &'a Path,
    /// The BIN chunk of a .glb file.
    pub bin: Option<&'a [u8]>,
    /// Bytes that may still be read or decoded.
    pub budget_bytes: u64,
    /// The caller's limit, for the error.
    pub limit_bytes: u64,
}

/// The bytes of every buffer of `root`, each exactly `byteLength` long.
pub(super) fn load<'a>(
    root: &Root,
    mut source: BufferSource<'a>,
) -> Result<Vec<Cow<'a, [u8]>>, GltfFault> {
    (0..root.buffers.len()).map(|i| source.buffer(root, i)).collect()
}

impl<'a> BufferSource<'a> {
    fn buffer(&mut self, root: &Root, buffer: usize) -> Result<Cow<'a, [u8]>, GltfFault> {
        let declared = root.buffers[buffer].byte_length.0;
        let mut bytes = match (&root.buffers[buffer].uri, self.bin) {
            (Some(uri), _) => Cow::Owned(self.uri_bytes(buffer, uri, declared)?),
            (None, Some(bin)) if buffer == 0 => Cow::Borrowed(bin),
            (None, _) => return Err(GltfFault::BufferMissing { buffer }),
        };
        let found = bytes.len();
        if (found as u64) < declared {
            return Err(GltfFault::BufferShort { buffer, declared, found });
        }
        match &mut bytes {
            Cow::Borrowed(slice) => *slice = &slice[..declared as usize],
            Cow::Owned(vec) => vec.truncate(declared as usize),
        }
        Ok(bytes)
    }

    fn uri_bytes(&mut self, buffer: usize, uri: &str, declared: u64) -> Result<Vec<u8>, GltfFault> {
        match uri.strip_prefix("data:") {
            Some(data) => self.data_uri_bytes(buffer, uri, data),
            None => self.file_bytes(buffer, uri, declared),
        }
    }

    fn data_uri_bytes(
        &mut self,
        buffer: usize,
        uri: &str,
        data: &str,
    ) -> Result<Vec<u8>, GltfFault> {
        let refused = |why| GltfFault::BufferUri { buffer, uri: shortened(uri), why };
        let (media_type, text) =
            data.split_once(',').ok_or_else(|| refused("is a data URI without a comma"))?;
        if !media_type.ends_with(";base64") {
            return Err(refused("is a data URI that is not base64"));
        }
        self.spend(text.len() as u64 / 4 * 3)?;
        BASE64.decode(text).map_err(|_| refused("is a data URI with damaged base64"))
    }

    fn file_bytes(
        &mut self,
        buffer: usize,
        uri: &str,
        declared: u64,
    ) -> Result<Vec<u8>, GltfFault> {
        self.spend(declared)?;
        let refused = |why| GltfFault::BufferUri { buffer, uri: shortened(uri), why };
        let failed = |cause| GltfFault::BufferIo { buffer, uri: shortened(uri), cause };
        let relative = relative_path(uri).map_err(refused)?;
        let path = path_beside(self.folder, &relative).map_err(failed)?.map_err(refused)?;
        read_at_most(&path, declared).map_err(failed)
    }

    fn spend(&mut self, bytes: u64) -> Result<(), GltfFault> {
        let spent = self.limit_bytes - self.budget_bytes;
        self.budget_bytes = self.budget_bytes.checked_sub(bytes).ok_or(GltfFault::Limit {
            what: "bytes of file and buffers",
            param: "max_bytes",
            found: spent.saturating_add(bytes),
            limit: self.limit_bytes,
        })?;
        Ok(())
    }
}

fn read_at_most(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(limit).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The plain relative path an address stands for, percent-encoding undone.
fn relative_path(uri: &str) -> Result<PathBuf, &'static str> {
    let decoded = percent_decoded(uri).ok_or("has damaged percent-encoding")?;
    if decoded.is_empty() || decoded.contains('\0') {
        return Err("is empty or contains a NUL");
    }
    if decoded.contains(':') {
        return Err("has a scheme or a drive letter");
    }
    if decoded.contains('\\') {
        return Err("contains a backslash");
    }
    let path = PathBuf::from(decoded);
    if stays_inside(&path) { Ok(path) } else { Err("is absolute or contains `..`") }
}

fn percent_decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        if first == b'%' {
            let digits = tail.get(..2).filter(|d| d.iter().all(u8::is_ascii_hexdigit))?;
            bytes.push(u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?);
            rest = &tail[2..];
        } else {
            bytes.push(first);
            rest = tail;
        }
    }
    String::from_utf8(bytes).ok()
}

fn shortened(uri: &str) -> String {
    let mut shown: String = uri.chars().take(SHOWN_URI_CHARS).collect();
    if shown.len() < uri.len() {
        shown.push('…');
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(uri: &str, expected: Result<&str, &str>) {
        let found = relative_path(uri);
        let found = found.as_deref().map(|p| p.to_str().unwrap()).map_err(|why| *why);
        assert_eq!(found, expected, "{uri}");
    }

    #[test]
    fn plain_names_pass() {
        check("a.bin", Ok("a.bin"));
        check("sub/my%20mesh.bin", Ok("sub/my mesh.bin"));
        check("./a.bin", Ok("./a.bin"));
    }

    #[test]
    fn addresses_that_leave_the_folder_are_refused() {
        check("../a.bin", Err("is absolute or contains `..`"));
        check("sub/%2e%2e/%2E%2E/a.bin", Err("is absolute or contains `..`"));
        check("/etc/passwd", Err("is absolute or contains `..`"));
        check("%2Fetc/passwd", Err("is absolute or contains `..`"));
        check("file:///etc/passwd", Err("has a scheme or a drive letter"));
        check("https://example.org/a.bin", Err("has a scheme or a drive letter"));
        check("C%3A/a.bin", Err("has a scheme or a drive letter"));
        check("..\\a.bin", Err("contains a backslash"));
        check("a%00.bin", Err("is empty or contains a NUL"));
        check("", Err("is empty or contains a NUL"));
        check("a%2.bin", Err("has damaged percent-encoding"));
        check("a%ff.bin", Err("has damaged percent-encoding"));
        check("a%+1.bin", Err("has damaged percent-encoding"));
    }
}
