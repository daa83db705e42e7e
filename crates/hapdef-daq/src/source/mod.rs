//! Where frames come from: one trait, and links that carry bytes.

mod fault;
#[cfg(feature = "serial")]
mod low_latency;
mod memory;
pub(crate) mod pace;
#[cfg(feature = "serial")]
mod ports;
mod protocol;
mod reader;
mod replay;
#[cfg(feature = "serial")]
mod serial;
mod session;
mod stream;
mod tcp;
#[cfg(feature = "tokio")]
mod tokio;
mod watch;

use std::time::Duration;

pub use fault::{LinkFault, LinkState, TopicFault};
pub use memory::{MemoryDevice, MemoryLink, memory_link};
#[cfg(feature = "serial")]
pub use ports::{PortInfo, permission_remedy, serial_ports};
pub use protocol::Protocol;
pub use replay::ReplaySource;
#[cfg(feature = "serial")]
pub use serial::{SerialLink, SerialOutput, SerialParams};
pub use stream::{StreamParams, StreamSource};
pub use tcp::TcpLink;
#[cfg(feature = "tokio")]
pub use tokio::{AsyncLink, AsyncSerial, AsyncSource, AsyncTcp};

use crate::Message;
use crate::csv_line::CsvCounts;
use crate::hdp1::{LossCounts, RejectedCounts};

/// Something that frames come from.
pub trait FrameSource: Send {
    /// Waits for at most `timeout` and hands out what came, in order. Trouble with the link comes
    /// as [`Message::Link`]; a source that can come back goes on.
    fn poll(&mut self, timeout: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus;

    /// What came so far.
    fn stats(&self) -> SourceStats;

    /// What it is, in words: a path, an address.
    fn name(&self) -> String;
}

impl<S: FrameSource + ?Sized> FrameSource for Box<S> {
    fn poll(&mut self, timeout: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        (**self).poll(timeout, sink)
    }

    fn stats(&self) -> SourceStats {
        (**self).stats()
    }

    fn name(&self) -> String {
        (**self).name()
    }
}

/// Whether a source may say more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceStatus {
    /// There may be more.
    Open,
    /// It has said everything.
    Ended,
}

/// What came from a source so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SourceStats {
    /// Bytes read.
    pub n_bytes: u64,
    /// Frames handed out.
    pub n_frames: u64,
    /// DATA packets delivered and lost.
    pub losses: LossCounts,
    /// Packets refused.
    pub rejected: RejectedCounts,
    /// Lines read and refused, where the source sends lines.
    pub lines: CsvCounts,
    /// Times the link was opened.
    pub n_opened: u64,
    /// Frames per second, as counted over the last full second.
    pub rate_hz: f64,
    /// Frames whose time is that of their arrival, as the device's clock was not believed.
    pub n_host_time: u64,
    /// Round trip of the last PING, ns; 0 before the first.
    pub round_trip_ns: u64,
    /// How much faster the device's clock runs than the host's, ppm; 0 until it is known.
    pub drift_ppm: f64,
    /// How far the map from the device's time to the host's is off the packets that came fastest, root
    /// mean square, µs; none until it is known.
    pub clock_residual_us: Option<f64>,
}

/// A link that carries bytes in both directions.
pub trait Link: Send {
    /// Opens it, or opens it again.
    ///
    /// # Errors
    /// Why it can't be opened now.
    fn open(&mut self) -> Result<(), LinkFault>;

    /// Waits for at most `timeout` for bytes: how many were read, 0 if none came.
    ///
    /// # Errors
    /// The link is gone; it has to be opened again.
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Result<usize, LinkFault>;

    /// Sends bytes, or as many of them as go without waiting long.
    ///
    /// # Errors
    /// The link is gone.
    fn write(&mut self, bytes: &[u8]) -> Result<(), LinkFault>;

    /// Closes it.
    fn close(&mut self);

    /// What it is, in words.
    fn name(&self) -> String;
}
