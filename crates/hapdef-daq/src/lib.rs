//! Bytes to frames at 1 kHz, every lost frame counted, no damaged frame delivered.

mod error;
#[cfg(feature = "faults")]
pub mod faults;
pub mod hdp1;

pub use error::DaqError;
