//! The one error type of the crate.

use thiserror::Error;

use crate::hdp1::SampleFormat;

/// What can go wrong when bytes become frames and frames become files.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DaqError {
    /// A packet that HDP1 has no room for.
    #[error("a packet of {len} bytes: HDP1 carries 1536 at most, send fewer scans per packet")]
    PacketTooLong {
        /// Bytes of its body.
        len: usize,
    },
    /// A HELLO that no decoder takes.
    #[error("{what}: correct the device's description")]
    BadHello {
        /// What is wrong.
        what: &'static str,
    },
    /// Samples that are not HELLO's scans × channels.
    #[error("{found} samples for a packet, scans × channels of HELLO are {expected}")]
    SampleCount {
        /// Samples expected.
        expected: usize,
        /// Samples given.
        found: usize,
    },
    /// A sample that its format can't hold.
    #[error("sample {found} does not fit {format:?}: clip it and set the SATURATED flag")]
    SampleRange {
        /// The sample.
        found: i32,
        /// HELLO's format.
        format: SampleFormat,
    },
    /// No thread could be started.
    #[error("the reader's thread could not be started: {source}")]
    Thread {
        /// What the operating system says.
        source: std::io::Error,
    },
    /// A file could not be used.
    #[error("{action} {path}: {source}")]
    File {
        /// What was being done.
        action: &'static str,
        /// With which file.
        path: std::path::PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The disk has not enough room to start with.
    #[error(
        "{path}: {free_bytes} bytes free, {needed_bytes} are asked for: make room, record \
         elsewhere, or lower min_free_bytes"
    )]
    DiskFull {
        /// The recording.
        path: std::path::PathBuf,
        /// Bytes free.
        free_bytes: u64,
        /// Bytes that have to be free.
        needed_bytes: u64,
    },
    /// A file of that name exists and must not be overwritten.
    #[error("{path}: is there already, {remedy}")]
    AlreadyThere {
        /// The file.
        path: std::path::PathBuf,
        /// What it is, and what to do.
        remedy: &'static str,
    },
    /// A recording broke off; what was written until then can be read.
    #[error("recording {path} stopped: {fault}; what was written until then can be read")]
    Recording {
        /// The recording.
        path: std::path::PathBuf,
        /// What happened.
        fault: String,
    },
    /// A file without anything that can be read.
    #[error("{path}: {n_bytes} bytes and not one readable chunk: is it a recording of hapdef?")]
    NothingToRecover {
        /// The file.
        path: std::path::PathBuf,
        /// Its length.
        n_bytes: u64,
    },
    /// A recording without a reading.
    #[error("{path}: not one reading in it: there is nothing to play")]
    NoFrames {
        /// The file.
        path: std::path::PathBuf,
    },
    /// A calibration record that is no JSON object.
    #[error("the calibration record is no JSON object: {message}")]
    BadCalibration {
        /// What the parser says.
        message: String,
    },
}
