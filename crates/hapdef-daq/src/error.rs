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
}
