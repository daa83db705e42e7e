//! Bytes to frames at 1 kHz: every lost frame is counted, no damaged frame is delivered.
//!
//! A [`source::Link`] carries bytes, [`source::StreamSource`] makes a [`source::FrameSource`] of it
//! by [`hdp1`] or [`csv_line`], [`acquire()`] reads it on a thread of its own and hands [`Message`]s to
//! [`Receiver`]s; [`Fanout`] passes on what viewers want, who may be slow. [`clock::ClockMap`] maps
//! the device's time to the host's.
//!
//! Features: `serial` (serial ports), `tokio` (boards on a tokio runtime), `record` (recordings in MCAP, replay, recovery, export),
//! `realtime` (SCHED_FIFO and locked memory, Linux), `faults` (seeded damage for tests and rigs).
//! This crate knows nothing of limbs or estimators.

mod acquire;
pub mod clock;
pub mod csv_line;
mod error;
mod fanout;
#[cfg(feature = "faults")]
pub mod faults;
mod frame;
pub mod hdp1;
mod realtime;
#[cfg(feature = "record")]
pub mod record;
pub mod source;

pub use acquire::{AcquireParams, AcquireStats, Acquisition, Receiver, acquire};
pub use error::DaqError;
pub use fanout::{Bounded, Fanout, Latest};
pub use frame::{Frame, Message};
pub use realtime::{enter_realtime, without_realtime};
