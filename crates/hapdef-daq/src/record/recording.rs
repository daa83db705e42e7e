//! Reading a recording, whole or damaged.

use std::collections::VecDeque;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::further::{Definitions, TopicDef};
use super::numbers::NumbersTopic;
use super::scan::{
    CHANNEL, ChunkScanner, DamageInfo, MESSAGE, MESSAGE_FIELDS_LEN, SCHEMA, channel_and_time,
    next_record,
};
use super::topics::{Topic, read_device, read_frame};
use crate::{DaqError, Message};

/// One record of a recording.
#[derive(Clone, Debug)]
pub struct Record {
    /// Time of it on the host's wall clock, ns since 1970 UTC: for frames the sample instant.
    pub log_time_ns: u64,
    /// What it says.
    pub content: Content,
    /// The message as it is in the file: JSON, unless the topic is a further one that says
    /// otherwise.
    pub bytes: Vec<u8>,
    /// Channel number in the file.
    pub(crate) channel: u16,
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
    /// A message of a further topic.
    Further(Arc<TopicDef>),
    /// Something this version doesn't know, or of a channel whose definition is lost.
    Other,
}

/// The records of a file, in order. Chunks whose CRC is wrong are left out and counted.
pub struct Recording {
    path: PathBuf,
    scanner: ChunkScanner<File>,
    chunk: Vec<u8>,
    records: VecDeque<Record>,
    definitions: Definitions,
    n_undefined: u64,
    /// Of what is before this time only the device's own messages are read.
    from_ns: u64,
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
            definitions: Definitions::default(),
            n_undefined: 0,
            from_ns: 0,
        })
    }

    /// The same with its first whole chunk read, so that a file of another kind is refused at once.
    ///
    /// # Errors
    /// [`DaqError::NoTopic`] for an MCAP file of another program, [`DaqError::NothingToRecover`] for
    /// a file without such a chunk; a file that can't be read.
    pub fn with_first_chunk(mut self) -> Result<Self, DaqError> {
        let has_chunk = self.next_chunk()?;
        self.take_records();
        let gauges = Topic::Gauges;
        let defined = self.definitions.topic(gauges.id());
        if has_chunk && defined.is_none_or(|topic| topic.name == gauges.name()) {
            return Ok(self);
        }
        if let Err(other @ DaqError::NoTopic { .. }) = NumbersTopic::open(&self.path, gauges.name())
        {
            return Err(other);
        }
        let file = std::fs::metadata(&self.path);
        let n_bytes = file.map_or(0, |file| file.len());
        Err(DaqError::NothingToRecover { path: self.path, n_bytes })
    }

    /// The same without the frames before a time, which are passed over fast; what the device said of
    /// itself before is read.
    pub(crate) fn with_frames_from(self, from_ns: u64) -> Self {
        Self { from_ns, ..self }
    }

    /// Times of the first and the last frame on the wall clock, ns, from all of the file; none
    /// where it has no frame.
    ///
    /// # Errors
    /// The file can't be read.
    pub fn span_ns(mut self) -> Result<Option<(u64, u64)>, DaqError> {
        let mut span = None;
        while self.next_chunk()? {
            let mut chunk = &self.chunk[..];
            while let Some((op, content, rest)) = next_record(chunk) {
                if op == MESSAGE
                    && let Some((channel, time_ns)) = channel_and_time(content)
                    && channel == Topic::Gauges.id()
                {
                    let (first_ns, _) = *span.get_or_insert((time_ns, time_ns));
                    span = Some((first_ns, time_ns));
                }
                chunk = rest;
            }
        }
        Ok(span)
    }

    /// The next record; none at the end.
    ///
    /// # Errors
    /// The file can't be read on.
    pub fn next_record(&mut self) -> Result<Option<Record>, DaqError> {
        while self.records.is_empty() {
            if !self.next_chunk()? {
                return Ok(None);
            }
            self.take_records();
        }
        Ok(self.records.pop_front())
    }

    /// How whole the file is, as far as it was read.
    #[must_use]
    pub fn damage(&self) -> DamageInfo {
        self.scanner.info()
    }

    /// True if the records so far are those of a bag of ROS 2.
    pub(crate) fn is_ros2(&self) -> bool {
        self.definitions.is_ros2()
    }

    /// Messages so far whose channel's definition is lost, so that nobody can read them.
    pub(crate) fn n_undefined(&self) -> u64 {
        self.n_undefined
    }

    fn next_chunk(&mut self) -> Result<bool, DaqError> {
        let more = self.scanner.next_chunk(&mut self.chunk);
        more.map_err(|source| DaqError::File { action: "reading", path: self.path.clone(), source })
    }

    fn take_records(&mut self) {
        let mut chunk = &self.chunk[..];
        while let Some((op, content, rest)) = next_record(chunk) {
            match op {
                MESSAGE if is_passed_over(content, self.from_ns) => {}
                MESSAGE => match record(content, &mut self.definitions) {
                    Some(record) => self.records.push_back(record),
                    None => self.n_undefined += 1,
                },
                SCHEMA => self.definitions.take_schema(content),
                CHANNEL => self.definitions.take_channel(content),
                _ => {}
            }
            chunk = rest;
        }
    }
}

/// Whether a message is from before `from_ns` and none of the device's own.
fn is_passed_over(content: &[u8], from_ns: u64) -> bool {
    from_ns > 0
        && channel_and_time(content)
            .is_some_and(|(channel, time_ns)| time_ns < from_ns && channel != Topic::Device.id())
}

/// A message's record; none if its channel is not known.
fn record(content: &[u8], definitions: &mut Definitions) -> Option<Record> {
    let (channel, log_time_ns) = channel_and_time(content)?;
    let json = &content[MESSAGE_FIELDS_LEN..];
    let content = match Topic::of(channel) {
        Some(topic) => own_content(topic, json, definitions),
        None => Content::Further(Arc::clone(definitions.topic(channel)?)),
    };
    Some(Record { log_time_ns, content, bytes: json.to_vec(), channel })
}

fn own_content(topic: Topic, json: &[u8], definitions: &mut Definitions) -> Content {
    let message = match topic {
        Topic::Calibration => return Content::Calibration(json.to_vec()),
        Topic::Gauges => read_frame(json).map(Message::Frame),
        Topic::Device => read_device(json),
    };
    if message.is_none()
        && topic == Topic::Device
        && let Ok(session) = serde_json::from_slice(json)
    {
        definitions.take_json(&session);
    }
    message.map_or(Content::Other, Content::Message)
}

impl Record {
    /// Name of its topic.
    #[must_use]
    pub fn topic(&self) -> &str {
        match &self.content {
            Content::Further(topic) => &topic.name,
            _ => Topic::of(self.channel).map_or("", Topic::name),
        }
    }
}
