//! The one error type of the crate.

use thiserror::Error;

/// What can go wrong when messages are made and sent.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RosError {
    /// A value has no CDR encoding, or bytes are none of it.
    #[error("{type_name}: {message}")]
    Cdr {
        /// Rust type of the message.
        type_name: &'static str,
        /// What the encoder says.
        message: String,
    },
    /// Bytes that don't begin as little-endian CDR does.
    #[error("a message begins with {found:02x?}, little-endian CDR with [00, 01, 00, 00]")]
    Encapsulation {
        /// Its first bytes.
        found: Vec<u8>,
    },
    /// A parameter is out of range.
    #[error("{name}: expected {expected}, found {found}")]
    Parameter {
        /// Which one.
        name: &'static str,
        /// What it must be.
        expected: &'static str,
        /// What it is.
        found: String,
    },
    /// The server for Foxglove did not start.
    #[error("serving Foxglove at {address}: {message}; choose another address or port")]
    Server {
        /// Where.
        address: String,
        /// What it says.
        message: String,
    },
    /// Zenoh has no session or did not take a message.
    #[error("zenoh: {message}; is the router running (ros2 run rmw_zenoh_cpp rmw_zenohd)?")]
    Zenoh {
        /// What it says.
        message: String,
    },
}
