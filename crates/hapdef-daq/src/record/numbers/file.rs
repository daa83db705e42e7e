//! An MCAP file of any program, from its beginning: its records, out of their chunks.
//!
//! Layout: <https://mcap.dev/spec>. No length is believed: of what a record announces only that is
//! read which is there.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use crate::DaqError;
use crate::record::scan::{CHUNK, MAGIC, PREFIX_LEN};

/// The end of the data: what follows repeats what was there.
const DATA_END: u8 = 0x0f;
/// Two times of a chunk, before its other fields.
const TIMES_LEN: usize = 16;
/// Longest chunk that is unpacked.
const MAX_CHUNK_LEN: u64 = 1 << 28;

/// Whether a file begins as MCAP files do.
///
/// # Errors
/// A file that can't be read.
pub fn is_mcap(path: &Path) -> Result<bool, DaqError> {
    let begin = || {
        let mut begin = Vec::new();
        File::open(path)?.take(MAGIC.len() as u64).read_to_end(&mut begin)?;
        Ok(begin == MAGIC)
    };
    begin().map_err(|source| DaqError::File { action: "reading", path: path.to_owned(), source })
}

/// The records of a file, some at a time.
pub(super) struct McapFile {
    path: PathBuf,
    input: BufReader<File>,
    is_over: bool,
}

impl McapFile {
    pub(super) fn open(path: &Path) -> Result<Self, DaqError> {
        let failed = |source| DaqError::File { action: "opening", path: path.to_owned(), source };
        let mut input = BufReader::with_capacity(1 << 18, File::open(path).map_err(failed)?);
        let mut begin = Vec::new();
        let read = input.by_ref().take(MAGIC.len() as u64).read_to_end(&mut begin);
        read.map_err(failed)?;
        if begin != MAGIC {
            return Err(failed(io::Error::new(io::ErrorKind::InvalidData, "no MCAP file")));
        }
        Ok(Self { path: path.to_owned(), input, is_over: false })
    }

    /// The records of the next chunk, or the next that is in none; none at the end, or where the file
    /// was cut off.
    pub(super) fn next_records(&mut self) -> Result<Option<Vec<u8>>, DaqError> {
        self.read_on().map_err(|source| DaqError::File {
            action: "reading",
            path: self.path.clone(),
            source,
        })
    }

    fn read_on(&mut self) -> io::Result<Option<Vec<u8>>> {
        if self.is_over {
            return Ok(None);
        }
        let mut record = Vec::new();
        self.input.by_ref().take(PREFIX_LEN as u64).read_to_end(&mut record)?;
        let op = record.first().copied();
        let len = record.get(1..PREFIX_LEN).and_then(|len| len.try_into().ok());
        let len = len.map_or(0, u64::from_le_bytes);
        let n_read = self.input.by_ref().take(len).read_to_end(&mut record)?;
        self.is_over = record.len() < PREFIX_LEN || op == Some(DATA_END) || (n_read as u64) < len;
        if self.is_over {
            return Ok(None);
        }
        match op {
            Some(CHUNK) => unpacked(&record[PREFIX_LEN..]).map(Some),
            _ => Ok(Some(record)),
        }
    }
}

/// The records of a chunk.
fn unpacked(chunk: &[u8]) -> io::Result<Vec<u8>> {
    let bad = |what: &str| io::Error::new(io::ErrorKind::InvalidData, format!("a chunk {what}"));
    let fields = || {
        let (_, rest) = chunk.split_at_checked(TIMES_LEN)?;
        let (len, rest) = rest.split_first_chunk()?;
        let (crc, rest) = rest.split_first_chunk()?;
        let (name_len, rest) = rest.split_first_chunk()?;
        let (name, rest) = rest.split_at_checked(u32::from_le_bytes(*name_len) as usize)?;
        let (_, packed) = rest.split_first_chunk::<8>()?;
        Some((u64::from_le_bytes(*len), u32::from_le_bytes(*crc), name, packed))
    };
    let (len, crc, compression, packed) = fields().ok_or_else(|| bad("is too short"))?;
    if len > MAX_CHUNK_LEN {
        return Err(bad("is of more than 256 MiB"));
    }
    let mut records = Vec::new();
    let mut take = |input: &mut dyn Read| input.take(len).read_to_end(&mut records);
    match compression {
        b"" => take(&mut &packed[..])?,
        b"zstd" => {
            let decoder = ruzstd::decoding::StreamingDecoder::new(packed);
            take(&mut decoder.map_err(|error| bad(&format!("is no zstd: {error}")))?)?
        }
        b"lz4" => take(&mut lz4_flex::frame::FrameDecoder::new(packed))?,
        other => {
            let other = String::from_utf8_lossy(other);
            return Err(bad(&format!("is compressed as {other:?}: expected zstd, lz4 or nothing")));
        }
    };
    if records.len() as u64 != len || (crc != 0 && crc32fast::hash(&records) != crc) {
        return Err(bad("is damaged: its CRC is wrong"));
    }
    Ok(records)
}
