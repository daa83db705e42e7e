//! Finds the chunks of an MCAP file whose CRC is right, wherever they are.
//!
//! The file's structure is not trusted: a damaged length would lead past good chunks. Every place
//! that looks like a chunk without compression is tried, and taken if its CRC-32 is right; a chunk
//! without CRC is not taken. Layout: <https://mcap.dev/spec>.

use std::io::{self, Read};

pub(super) const SCHEMA: u8 = 0x03;
pub(super) const CHANNEL: u8 = 0x04;
pub(super) const MESSAGE: u8 = 0x05;
pub(super) const CHUNK: u8 = 0x06;
/// Opcode and length of a record.
pub(super) const PREFIX_LEN: usize = 9;
/// Fields of a message before what it says: channel, sequence, two times.
pub(super) const MESSAGE_FIELDS_LEN: usize = 2 + 4 + 8 + 8;
/// Fields of a chunk before its records: two times, size, CRC, no compression, size again.
const FIELDS_LEN: usize = 8 + 8 + 8 + 4 + 4 + 8;
/// Longest chunk that is read.
const MAX_RECORDS_LEN: usize = 16 << 20;
const READ_LEN: usize = 1 << 18;
pub(super) const MAGIC: &[u8; 8] = b"\x89MCAP0\r\n";

/// How whole a file is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DamageInfo {
    /// Chunks with the right CRC.
    pub n_chunks: u64,
    /// Stretches between them that are not what belongs there.
    pub n_damaged: u64,
    /// Bytes of those.
    pub n_damaged_bytes: u64,
    /// True if the file has its ending.
    pub is_finished: bool,
    /// Bytes read.
    pub n_bytes: u64,
}

/// Reads chunks from a file in bounded memory.
pub(crate) struct ChunkScanner<R> {
    input: R,
    buffer: Vec<u8>,
    at: usize,
    is_at_end: bool,
    /// Bytes since the last chunk; only their beginning is kept where there are many.
    between: Vec<u8>,
    n_between: u64,
    info: DamageInfo,
}

impl<R: Read> ChunkScanner<R> {
    pub(crate) fn new(input: R) -> Self {
        Self {
            input,
            buffer: Vec::new(),
            at: 0,
            is_at_end: false,
            between: Vec::new(),
            n_between: 0,
            info: DamageInfo::default(),
        }
    }

    /// How whole the file is, as far as it was read.
    pub(crate) fn info(&self) -> DamageInfo {
        self.info
    }

    /// The records of the next good chunk; false at the end of the file.
    pub(crate) fn next_chunk(&mut self, records: &mut Vec<u8>) -> io::Result<bool> {
        loop {
            if !self.fill(PREFIX_LEN + FIELDS_LEN)? {
                self.skip(self.buffer.len() - self.at);
                self.end_stretch(true);
                return Ok(false);
            }
            if let Some(len) = self.chunk_here()?
                && self.fill(PREFIX_LEN + FIELDS_LEN + len)?
                && self.take_chunk(len, records)
            {
                return Ok(true);
            }
            let rest = &self.buffer[self.at + 1..];
            let next = rest.iter().position(|b| *b == CHUNK);
            self.skip(1 + next.unwrap_or(rest.len()));
        }
    }

    /// Length of the records if a chunk begins here.
    fn chunk_here(&self) -> io::Result<Option<usize>> {
        let here = &self.buffer[self.at..];
        let u64_at = |at: usize| u64::from_le_bytes(here[at..][..8].try_into().unwrap_or_default());
        if here[0] != CHUNK {
            return Ok(None);
        }
        let fields = PREFIX_LEN + 16;
        let size = u64_at(fields);
        let has_no_compression = here[fields + 12..][..4] == [0; 4];
        let fits = u64_at(1) == (FIELDS_LEN as u64).wrapping_add(size)
            && u64_at(fields + 16) == size
            && has_no_compression;
        let len = usize::try_from(size).unwrap_or(usize::MAX);
        Ok(Some(len).filter(|len| fits && *len <= MAX_RECORDS_LEN))
    }

    fn take_chunk(&mut self, len: usize, records: &mut Vec<u8>) -> bool {
        let start = self.at + PREFIX_LEN + FIELDS_LEN;
        let body = &self.buffer[start..start + len];
        let stored = &self.buffer[self.at + PREFIX_LEN + 24..][..4];
        // Without CRCs, readers returned wrong values for 24 of 60 files with a flipped bit; with them
        // for none.
        let crc = crc32fast::hash(body);
        if crc == 0 || stored != crc.to_le_bytes() {
            return false;
        }
        records.clear();
        records.extend(body);
        self.end_stretch(false);
        self.at = start + len;
        self.info.n_chunks += 1;
        self.info.n_bytes += (PREFIX_LEN + FIELDS_LEN + len) as u64;
        true
    }

    /// True if `n` bytes are there from the present place on.
    fn fill(&mut self, n: usize) -> io::Result<bool> {
        while self.buffer.len() - self.at < n && !self.is_at_end {
            if self.at > READ_LEN {
                self.buffer.drain(..self.at);
                self.at = 0;
            }
            let old_len = self.buffer.len();
            self.buffer.resize(old_len + READ_LEN, 0);
            let got = match self.input.read(&mut self.buffer[old_len..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {
                    self.buffer.truncate(old_len);
                    continue;
                }
                other => other?,
            };
            self.buffer.truncate(old_len + got);
            self.is_at_end = got == 0;
        }
        Ok(self.buffer.len() - self.at >= n)
    }

    fn skip(&mut self, n: usize) {
        let room = MAX_RECORDS_LEN - self.between.len();
        let skipped = &self.buffer[self.at..self.at + n];
        self.between.extend(&skipped[..n.min(room)]);
        self.n_between += n as u64;
        self.at += n;
    }

    /// Judges what was between two chunks, or before the first, or behind the last.
    fn end_stretch(&mut self, is_last: bool) {
        let is_first = self.info.n_bytes == 0;
        let mut rest = &self.between[..];
        let mut is_good = self.n_between == rest.len() as u64;
        if is_first {
            is_good &= rest.starts_with(MAGIC);
            rest = rest.strip_prefix(MAGIC).unwrap_or(rest);
        }
        let ending = is_last.then(|| rest.strip_suffix(MAGIC)).flatten();
        is_good &= records_fill(ending.unwrap_or(rest));
        self.info.is_finished = is_last && is_good && ending.is_some();
        if !is_good {
            self.info.n_damaged += 1;
            self.info.n_damaged_bytes += self.n_between;
        }
        self.info.n_bytes += self.n_between;
        self.between.clear();
        self.n_between = 0;
    }
}

/// True if whole records other than chunks fill `bytes` exactly.
fn records_fill(mut bytes: &[u8]) -> bool {
    while let Some((op, _, rest)) = next_record(bytes) {
        if op == CHUNK || op == 0 || op > 0x0f {
            return false;
        }
        bytes = rest;
    }
    bytes.is_empty()
}

/// Splits the first record off: opcode, content, what follows.
pub(crate) fn next_record(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (prefix, rest) = bytes.split_at_checked(PREFIX_LEN)?;
    let len = u64::from_le_bytes(prefix[1..].try_into().ok()?);
    let (content, rest) = rest.split_at_checked(usize::try_from(len).ok()?)?;
    Some((prefix[0], content, rest))
}

/// Channel and time, ns, of a message.
pub(super) fn channel_and_time(content: &[u8]) -> Option<(u16, u64)> {
    let (fields, _) = content.split_at_checked(MESSAGE_FIELDS_LEN)?;
    let channel = u16::from_le_bytes([fields[0], fields[1]]);
    Some((channel, u64::from_le_bytes(fields[6..14].try_into().ok()?)))
}
