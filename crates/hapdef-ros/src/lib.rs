//! Contacts, gauges and diagnostics as messages that ROS tools read.
//!
//! [`RosEncoder`] makes CDR messages of plain structs ([`Readings`], [`hapdef_contact::Touch`], [`Health`]) and
//! hands them to a [`MessageSink`]: [`McapSink`] writes them beside the raw readings of a recording,
//! `FoxgloveServer` (feature `foxglove`) shows them live, `ZenohSink` (feature `zenoh`) publishes
//! them as ROS 2 does by rmw_zenoh; `ZenohSource` (the same feature) reads others' topics so. [`topics()`] lists what is said where; docs/ros.md explains it.
//!
//! This crate knows nothing of how contacts are found.

mod cdr;
mod encode;
mod error;
#[cfg(feature = "foxglove")]
mod foxglove_server;
mod frames;
mod input;
mod markers;
mod mcap_sink;
pub mod msg;
#[cfg(any(test, feature = "zenoh"))]
mod rmw_names;
mod robot_board;
mod schema;
mod sink;
mod slots;
mod topics;
#[cfg(feature = "zenoh")]
mod zenoh_session;
#[cfg(feature = "zenoh")]
mod zenoh_sink;
#[cfg(feature = "zenoh")]
mod zenoh_source;

pub use cdr::{from_cdr, to_cdr};
pub use encode::RosEncoder;
pub use error::RosError;
#[cfg(feature = "foxglove")]
pub use foxglove_server::FoxgloveServer;
pub use input::{Health, Known, Level, Readings};
pub use mcap_sink::McapSink;
pub use robot_board::RobotBoard;
pub use schema::{dds_name, definition, type_hash};
pub use sink::{MessageSink, Sinks};
pub use topics::{RosParams, TopicKind, topics};
#[cfg(feature = "zenoh")]
pub use zenoh_sink::{ZenohParams, ZenohSink};
#[cfg(feature = "zenoh")]
pub use zenoh_source::{ZenohSource, ZenohSourceParams};
