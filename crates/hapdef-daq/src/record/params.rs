//! How a recording is made, how it goes, what became of it.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use super::further::TopicDef;
use crate::clock::HostClock;

/// How a recording is made.
#[derive(Clone)]
pub struct RecordParams {
    /// The calibration in use, a JSON object, kept as it is.
    pub calibration: Option<Vec<u8>>,
    /// What is recorded, in words: the name of the source.
    pub source: String,
    /// The clocks that the source uses, too.
    pub clock: Arc<dyn HostClock>,
    /// Bytes of the disk that have to stay free.
    pub min_free_bytes: u64,
    /// Overwrite what is left of a recording of the same name that was broken off.
    pub overwrites: bool,
    /// Topics beside the readings; [`super::Recorder::topics`] writes them. With a schema in
    /// `ros2msg` among them the file is a bag of ROS 2, and the readings' own topics, which are
    /// JSON, go without schema, because ROS's readers refuse any other kind.
    pub topics: Vec<TopicDef>,
}

impl Default for RecordParams {
    /// No calibration, the system's clocks, 64 MiB free, the readings alone.
    fn default() -> Self {
        Self {
            calibration: None,
            source: String::new(),
            clock: Arc::new(crate::clock::SystemClock),
            min_free_bytes: 64 << 20,
            overwrites: false,
            topics: Vec::new(),
        }
    }
}

/// How a recording is going.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecordStats {
    /// Frames handed to the operating system.
    pub n_frames: u64,
    /// Bytes handed to the operating system.
    pub n_bytes: u64,
    /// Frames that were dropped before they came here: the disk was too slow for too long.
    pub n_dropped: u64,
    /// What else the device and the link said that was dropped before it came here.
    pub n_events_dropped: u64,
    /// Messages of further topics handed to the operating system.
    pub n_messages: u64,
    /// Messages of further topics that were dropped before they came here.
    pub n_messages_dropped: u64,
    /// Longest time from one flush to the next.
    pub worst_flush: Duration,
    /// Why the recording stopped, if it did.
    pub fault: Option<Arc<str>>,
}

/// A finished recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordInfo {
    /// Its file.
    pub path: PathBuf,
    /// Frames in it.
    pub n_frames: u64,
    /// Bytes of it.
    pub n_bytes: u64,
    /// Frames that were dropped before they came here.
    pub n_dropped: u64,
    /// What else the device and the link said that was dropped before it came here.
    pub n_events_dropped: u64,
    /// Messages of further topics in it.
    pub n_messages: u64,
    /// Messages of further topics that were dropped before they came here.
    pub n_messages_dropped: u64,
}
