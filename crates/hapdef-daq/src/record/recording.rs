//! Reading a recording, whole or damaged.

use std::collections::VecDeque;
use std::fs::File;
use std::path::{Path, PathBuf};

use super::scan::{ChunkScanner, DamageInfo, next_record};
use super::topics::{Topic, read_device, read_frame};
use crate::{DaqError, Message};

const MESSAGE: u8 = 0x05;
/// Channel, sequence, two times.
const MESSAGE_FIELDS_LEN: usize = 2 + 4 + 8 + 8;

/// One record of a recording.
#[derive(Clone, Debug)]
pub struct Record {
    /// Time of it on the host's wall clock, ns since 1970 UTC: for frames the sample instant.
    pub log_time_ns: u64,
    /// What it says.
    pub content: Content,
    /// Channel number in the file.
    pub(crate) topic: Topic,
    /// The JSON as it is in the file.
    pub(crate) json: Vec<u8>,
}

/// What a record says.
#[derive(Clone, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "nearly all records are frames, and a box for each would be a heap block per frame"
)]
pub enum Content {
    /// A frame, or something else that a source said.
    Message(Message),
    /// The calibration record, JSON.
    Calibration(Vec<u8>),
    /// JSON that says something this version doesn't know.
    Other,
}

/// The records of a file, in order. Chunks whose CRC is wrong are left out and counted.
pub struct Recording {
    path: PathBuf,
    scanner: ChunkScanner<File>,
    chunk: Vec<u8>,
    records: VecDeque<Record>,
}

impl Recording {
    /// Opens a recording: finished, partial or damaged.
    ///
    /// # Errors
    /// A file that can't be opened.
    pub fn open(path: &Path) -> Result<Self, DaqError> {
        let file = File::open(path).map_err(|source| DaqError::File {
            action: "opening",
            path: path.to_owned(),
            source,
        })?;
        Ok(Self {
            path: path.to_owned(),
            scanner: ChunkScanner::new(file),
            chunk: Vec::new(),
            records: VecDeque::new(),
        })
    }

    /// The next record; none at the end.
    ///
    /// # Errors
    /// The file can't be read on.
    pub fn next_record(&mut self) -> Result<Option<Record>, DaqError> {
        while self.records.is_empty() {
            let more = self.scanner.next_chunk(&mut self.chunk);
            let more = more.map_err(|source| DaqError::File {
                action: "reading",
                path: self.path.clone(),
                source,
            })?;
            if !more {
                return Ok(None);
            }
            take_records(&self.chunk, &mut self.records);
        }
        Ok(self.records.pop_front())
    }

    /// The messages of the sources, for a replay; it ends where the file can't be read on.
    pub fn messages(mut self) -> impl Iterator<Item = Message> + Send {
        std::iter::from_fn(move || {
            loop {
                if let Content::Message(message) = self.next_record().ok()??.content {
                    return Some(message);
                }
            }
        })
    }

    /// How whole the file is, as far as it was read.
    #[must_use]
    pub fn damage(&self) -> DamageInfo {
        self.scanner.info()
    }
}

fn take_records(mut chunk: &[u8], into: &mut VecDeque<Record>) {
    while let Some((op, content, rest)) = next_record(chunk) {
        if op == MESSAGE {
            into.extend(record(content));
        }
        chunk = rest;
    }
}

fn record(content: &[u8]) -> Option<Record> {
    let (fields, json) = content.split_at_checked(MESSAGE_FIELDS_LEN)?;
    let topic = Topic::of(u16::from_le_bytes([fields[0], fields[1]]))?;
    let log_time_ns = u64::from_le_bytes(fields[6..14].try_into().ok()?);
    let message = match topic {
        Topic::Gauges => read_frame(json).map(Message::Frame),
        Topic::Device => read_device(json),
        Topic::Calibration => None,
    };
    let content = match (topic, message) {
        (Topic::Calibration, _) => Content::Calibration(json.to_vec()),
        (_, Some(message)) => Content::Message(message),
        (_, None) => Content::Other,
    };
    Some(Record {
        log_time_ns,
        content,
        topic,
        json: json.to_vec(),
    })
}
