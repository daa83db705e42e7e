//! The MCAP file of a recording: definitions, messages, flushes, ending.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{WriteOptions, Writer};

use super::further::{TopicDef, channel_of, is_ros2};
use super::topics::TOPICS;
use crate::DaqError;

/// A chunk is closed when it is larger; with one message more it is still below 256 KiB.
const CHUNK_LEN: u64 = 192 << 10;

/// A file that is being written.
pub(crate) struct RecordFile {
    writer: Writer<NoSeek<BufWriter<File>>>,
    /// A second handle of the same file, for its length and for syncing.
    file: File,
    /// Length of the file after the last flush that went well.
    good_len: u64,
}

impl RecordFile {
    /// Begins a file with the readings' own topics and these.
    pub(crate) fn begin(file: File, further: &[TopicDef]) -> io::Result<Self> {
        let is_bag = is_ros2(further);
        let mut new = Self::with_own_topics(file, is_bag)?;
        for (i, topic) in further.iter().enumerate() {
            new.define(channel_of(i), topic)?;
        }
        new.flush()?;
        Ok(new)
    }

    /// Begins a file with the readings' own topics: those go without schemas in a bag of ROS 2.
    pub(crate) fn with_own_topics(file: File, is_bag: bool) -> io::Result<Self> {
        let buffered = BufWriter::with_capacity(1 << 19, file.try_clone()?);
        let options = WriteOptions::new()
            .compression(None)
            .chunk_size(Some(CHUNK_LEN))
            .disable_seeking(true)
            .profile(if is_bag { "ros2" } else { "" })
            .library(concat!("hapdef-daq ", env!("CARGO_PKG_VERSION")));
        let mut writer = options.create(NoSeek::new(buffered)).map_err(other)?;
        for topic in TOPICS {
            let (name, schema) = topic.schema();
            let schema_id = if is_bag { 0 } else { topic.id() };
            if schema_id > 0 {
                writer
                    .add_schema_with_id(schema_id, name, "jsonschema", schema.as_bytes())
                    .map_err(other)?;
            }
            let nothing = BTreeMap::new();
            writer
                .add_channel_with_id(topic.id(), schema_id, topic.name(), "json", &nothing)
                .map_err(other)?;
        }
        Ok(Self { writer, file, good_len: 0 })
    }

    /// Says what a further channel's messages are; saying it again changes nothing.
    pub(crate) fn define(&mut self, channel: u16, topic: &TopicDef) -> io::Result<()> {
        let schema_id = if topic.schema_encoding.is_empty() {
            0
        } else {
            self.writer
                .add_schema(&topic.schema_name, &topic.schema_encoding, topic.schema.as_bytes())
                .map_err(other)?
        };
        let nothing = BTreeMap::new();
        let added = self.writer.add_channel_with_id(
            channel,
            schema_id,
            &topic.name,
            &topic.message_encoding,
            &nothing,
        );
        added.map(|_| ()).map_err(other)
    }

    pub(crate) fn write(
        &mut self,
        channel: u16,
        sequence: u32,
        log_time: u64,
        message: &[u8],
    ) -> io::Result<()> {
        let header =
            MessageHeader { channel_id: channel, sequence, log_time, publish_time: log_time };
        self.writer.write_to_known_channel(&header, message).map_err(other)
    }

    /// Hands everything to the operating system: from here on a killed process loses none of it.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.writer.flush().map_err(other)?;
        self.good_len = self.file.metadata()?.len();
        Ok(())
    }

    pub(crate) fn len(&self) -> u64 {
        self.good_len
    }

    /// Writes the ending and waits until it is on the disk.
    pub(crate) fn finish(mut self) -> io::Result<u64> {
        self.writer.finish().map_err(other)?;
        let mut buffered = self.writer.into_inner().into_inner();
        buffered.flush()?;
        self.file.sync_all()?;
        Ok(self.file.metadata()?.len())
    }

    /// After an error: cuts off what was written in part, and ends the file if there is room.
    pub(crate) fn abandon(mut self) {
        // What was buffered must not be written any more.
        let (_, _) = self.writer.into_inner().into_inner().into_parts();
        let _ = self
            .file
            .set_len(self.good_len)
            .and_then(|()| self.file.seek(SeekFrom::Start(self.good_len)))
            .and_then(|_| self.file.write_all(&ENDING))
            .or_else(|_| self.file.set_len(self.good_len));
        let _ = self.file.sync_all();
    }
}

/// DataEnd without CRC, Footer without summary, magic: the shortest ending of an MCAP file.
const ENDING: [u8; 50] = {
    let mut bytes = [0; 50];
    bytes[0] = 0x0f;
    bytes[1] = 4;
    bytes[13] = 0x02;
    bytes[14] = 20;
    let magic = *b"\x89MCAP0\r\n";
    let mut i = 0;
    while i < 8 {
        bytes[42 + i] = magic[i];
        i += 1;
    }
    bytes
};

/// A file that is not there yet, to be written.
pub(crate) fn new_file(path: &Path, remedy: &'static str) -> Result<File, DaqError> {
    let new = OpenOptions::new().write(true).create_new(true).open(path);
    new.map_err(|source| match source.kind() {
        io::ErrorKind::AlreadyExists => DaqError::AlreadyThere { path: path.to_owned(), remedy },
        _ => DaqError::File { action: "writing", path: path.to_owned(), source },
    })
}

/// The name while a recording is not finished: `x.mcap` is `x.partial.mcap` until then.
pub(crate) fn partial_path(path: &Path) -> PathBuf {
    with_state(path, "partial")
}

/// The name while a recording is recovered: `x.recovering.mcap`, never that of one to recover.
pub(crate) fn recovering_path(path: &Path) -> PathBuf {
    with_state(path, "recovering")
}

fn with_state(path: &Path, state: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}.{state}.mcap"))
}

/// Gives the file its final name, which is on the disk when this returns.
pub(crate) fn rename(from: &Path, to: &Path) -> io::Result<()> {
    std::fs::rename(from, to)?;
    let folder = to.parent().filter(|p| !p.as_os_str().is_empty());
    File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
}

fn other(error: mcap::McapError) -> io::Error {
    match error {
        mcap::McapError::Io(error) => error,
        error => io::Error::other(error),
    }
}
