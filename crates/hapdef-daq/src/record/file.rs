//! The MCAP file of a recording: definitions, messages, flushes, ending.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{WriteOptions, Writer};

use super::further::{TopicDef, channel_of, is_ros2};
use super::topics::TOPICS;
use crate::DaqError;

/// Time from one chunk to the next: a damaged byte costs no more readings than that, and with some for the
/// flush itself nothing older than 100 ms is unwritten.
pub(crate) const CHUNK_SPAN: Duration = Duration::from_millis(80);
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

/// An empty file to write, which no other recorder, of whatever process, is given until this handle and its
/// copies are gone. A file that is there is overwritten where there is no `remedy`, what to do about it.
///
/// # Errors
/// [`DaqError::BeingWritten`], [`DaqError::AlreadyThere`] with the remedy; a file that can't be made.
pub fn claim(path: &Path, remedy: Option<&'static str>) -> Result<File, DaqError> {
    let failed = |source| DaqError::File { action: "writing", path: path.to_owned(), source };
    let being_written = || DaqError::BeingWritten { path: path.to_owned() };
    if is_claimed(path) {
        return Err(being_written());
    }
    let mut options = OpenOptions::new();
    options.write(true).truncate(false).create(true).create_new(remedy.is_some());
    let file = options.open(path).map_err(|source| match (source.kind(), remedy) {
        (io::ErrorKind::AlreadyExists, Some(remedy)) => {
            DaqError::AlreadyThere { path: path.to_owned(), remedy }
        }
        _ => failed(source),
    })?;
    // A file system without locks claims nothing.
    let is_taken = matches!(file.try_lock(), Err(TryLockError::WouldBlock));
    let found = file.metadata().map_err(failed)?;
    // It may have been finished, and so renamed, since it was opened.
    if is_taken || !std::fs::metadata(path).is_ok_and(|data| is_same_file(&data, &found)) {
        return Err(being_written());
    }
    if found.len() > 0 {
        file.set_len(0).map_err(failed)?;
    }
    Ok(file)
}

/// Refuses a recording to `path` while another is written there.
///
/// # Errors
/// [`DaqError::BeingWritten`].
pub fn check_unclaimed(path: &Path) -> Result<(), DaqError> {
    match [path.to_owned(), partial_path(path)].into_iter().find(|path| is_claimed(path)) {
        Some(path) => Err(DaqError::BeingWritten { path }),
        None => Ok(()),
    }
}

fn is_claimed(path: &Path) -> bool {
    let is_file = std::fs::metadata(path).is_ok_and(|data| data.is_file());
    is_file
        && File::open(path)
            .is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

pub(crate) fn is_same_file(a: &std::fs::Metadata, b: &std::fs::Metadata) -> bool {
    (a.dev(), a.ino()) == (b.dev(), b.ino())
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
    if is_claimed(to) {
        let words = format!("another program is writing {}", to.display());
        return Err(io::Error::new(io::ErrorKind::ResourceBusy, words));
    }
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
