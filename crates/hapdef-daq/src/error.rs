//! The one error type of the crate.

use thiserror::Error;

use crate::hdp1::SampleFormat;

/// What can go wrong when bytes become frames and frames become files.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum DaqError {
    #[error("a packet of {len} bytes: HDP1 carries 1536 at most, send fewer scans per packet")]
    PacketTooLong { len: usize },
    #[error("{what}: correct the device's description")]
    BadHello { what: &'static str },
    #[error("{found} samples for a packet, scans × channels of HELLO are {expected}")]
    SampleCount { expected: usize, found: usize },
    #[error("sample {found} does not fit {format:?}: clip it and set the SATURATED flag")]
    SampleRange { found: i32, format: SampleFormat },
    #[error("the reader's thread could not be started: {source}")]
    Thread { source: std::io::Error },
    #[error("{action} {path}: {source}")]
    File { action: &'static str, path: std::path::PathBuf, source: std::io::Error },
    #[error(
        "{path}: {free_bytes} bytes free, {needed_bytes} are asked for: make room, record \
         elsewhere, or lower min_free_bytes"
    )]
    DiskFull { path: std::path::PathBuf, free_bytes: u64, needed_bytes: u64 },
    #[error("{path}: is there already, {remedy}")]
    AlreadyThere { path: std::path::PathBuf, remedy: &'static str },
    #[error(
        "{path}: another program is writing it: wait until that has ended, or record to another name"
    )]
    BeingWritten { path: std::path::PathBuf },
    #[error("recording {path} stopped: {fault}; what was written until then can be read")]
    Recording { path: std::path::PathBuf, fault: String },
    #[error("{path}: {n_bytes} bytes and not one readable chunk: is it a recording of hapdef?")]
    NothingToRecover { path: std::path::PathBuf, n_bytes: u64 },
    #[error("{path}: not one reading in it: there is nothing to play")]
    NoFrames { path: std::path::PathBuf },
    #[error(
        "{path}: no topic {topic}; it has {found}: name one that has the gauges' readings (--topic)"
    )]
    NoTopic { path: std::path::PathBuf, topic: String, found: String },
    #[error("{path}: topic {topic}: {message}")]
    NoNumbers { path: std::path::PathBuf, topic: String, message: String },
    #[error("the definition of {type_name}: {message}")]
    NoDefinition { type_name: String, message: String },
    #[error("the calibration record is no JSON object: {message}")]
    BadCalibration { message: String },
}
