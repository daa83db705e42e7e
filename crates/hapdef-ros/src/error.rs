//! The one error type of the crate.

use thiserror::Error;

/// What can go wrong when messages are made and sent.
#[derive(Debug, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum RosError {
    #[error("{type_name}: {message}")]
    Cdr { type_name: &'static str, message: String },
    #[error("a message begins with {found:02x?}, little-endian CDR with [00, 01, 00, 00]")]
    Encapsulation { found: Vec<u8> },
    #[error("{name}: expected {expected}, found {found}")]
    Parameter { name: &'static str, expected: &'static str, found: String },
    #[error("serving Foxglove at {address}: {message}; choose another address or port")]
    Server { address: String, message: String },
    #[error("zenoh: {message}; is the router running (ros2 run rmw_zenoh_cpp rmw_zenohd)?")]
    Zenoh { message: String },
}
