//! What can be wrong with a link, and what to do then.

use std::io;
use std::sync::Arc;

use thiserror::Error;

use crate::clock::ClockFault;

/// Why a link is not open.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum LinkFault {
    #[error("{name}: disconnected; waiting for it to come back")]
    Disconnected { name: String },
    #[error("{name}: not there; plug it in, or see with `hapdef doctor` what the ports are called")]
    NotFound { name: String },
    #[error("{name}: connection refused; is the device's program running, and is the port right?")]
    Refused { name: String },
    #[error("{name}: {message}; check the host's name, its cable or Wi-Fi, and the firewall")]
    Unreachable { name: String, message: String },
    #[error("{name}: permission denied; {remedy}")]
    PermissionDenied { name: String, remedy: String },
    #[error("{name}: another program has it open; close that (fuser {name} says which it is)")]
    Busy { name: String },
    #[error("{name}: {message}")]
    Io { name: String, message: String },
    #[error("{name}: ended")]
    Ended { name: String },
    #[error(
        "{name}: no router of zenoh at {address}; start it there (ros2 run rmw_zenoh_cpp rmw_zenohd), or name \
         where it is: ros2:DOMAIN@HOST:PORT"
    )]
    NoRouter { name: String, address: String },
    #[error(
        "{name}: nobody publishes it; in ROS_DOMAIN_ID {domain_id} there is {found}: start its publisher, with \
         RMW_IMPLEMENTATION=rmw_zenoh_cpp, or name another topic or domain"
    )]
    NoPublisher { name: String, domain_id: u32, found: String },
}

/// Why a topic's messages are no readings.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum TopicFault {
    #[error(
        "topic {topic}: its messages are {found}, expected {expected}: publish the readings as \
         std_msgs/Float64MultiArray, or record them (ros2 bag record -s mcap) and read that: replay:FILE"
    )]
    OtherType { topic: String, found: String, expected: String },
    #[error("topic {topic}: {message}")]
    NoNumbers { topic: String, message: String },
    #[error(
        "topic {topic}: a message has {found} numbers, expected {expected}, one for each gauge: name the topic \
         of this limb's gauges, or the limb that has them"
    )]
    OtherChannels { topic: String, expected: usize, found: usize },
    #[error("topic {topic}: a message was refused and counts as lost: {message}")]
    Unlike { topic: String, message: String },
    #[error(
        "topic {topic}: it has several publishers, and what another one than the first sends is left out: stop \
         all but one"
    )]
    Several { topic: String },
    #[error(
        "topic {topic}: it has a publisher, and no message came for {for_s} s: is its node running?"
    )]
    Silent { topic: String, for_s: u64 },
}

/// What became of a link.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LinkState {
    /// It is open.
    Open,
    /// It is closed and will be opened again as soon as that works.
    Away(LinkFault),
    /// It is open, but no bytes come.
    Silent {
        /// For how long, s.
        for_s: u64,
    },
    /// Bytes come, but nothing that could be understood.
    NotUnderstood {
        /// How many bytes.
        n_bytes: u64,
        /// What to try.
        remedy: Arc<str>,
    },
    /// Whole packets come, and no reading can be had of them.
    Refused {
        /// How many packets.
        n_packets: u64,
        /// Why, and what to do.
        why: Arc<str>,
    },
    /// Lines of another number of integers come.
    OtherChannels {
        /// Integers that a line has to have.
        expected: usize,
        /// Integers that they have.
        found: usize,
    },
    /// The messages of a topic of ROS 2 are no readings, or none come.
    Topic(TopicFault),
    /// The device's clock is not believed: frames have the time of their arrival while it is not.
    Clock(ClockFault),
    /// A recording was played to its end, and parts of it could not be read.
    Damaged {
        /// Whole chunks that were played.
        n_chunks: u64,
        /// Stretches between them that were left out.
        n_damaged: u64,
        /// Bytes of those.
        n_bytes: u64,
    },
}

impl LinkFault {
    /// The fault of an error while a connection is made.
    pub(crate) fn of_connecting(name: String, error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::ConnectionRefused => Self::Refused { name },
            _ => Self::Unreachable { name, message: error.to_string() },
        }
    }

    /// The fault of an error while a link is used: all but a few kinds mean that it is gone.
    pub(crate) fn of_use(name: &str, error: &io::Error) -> Self {
        use io::ErrorKind as K;
        let name = name.to_owned();
        match error.kind() {
            K::InvalidInput | K::InvalidData | K::Unsupported | K::OutOfMemory => {
                Self::Io { name, message: error.to_string() }
            }
            _ => Self::Disconnected { name },
        }
    }
}

impl TopicFault {
    /// Whether no later message mends it.
    #[must_use]
    pub fn is_lasting(&self) -> bool {
        use TopicFault as F;
        matches!(self, F::OtherType { .. } | F::NoNumbers { .. } | F::OtherChannels { .. })
    }
}

impl std::fmt::Display for LinkState {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Open => write!(f, "open"),
            Self::Away(fault) => write!(f, "{fault}"),
            Self::Silent { for_s } => write!(
                f,
                "no bytes for {for_s} s: is the device on, does its firmware run (press its reset)?"
            ),
            Self::NotUnderstood { n_bytes, remedy } => {
                write!(f, "{n_bytes} bytes came, none of them a packet: {remedy}")
            }
            Self::Refused { n_packets, why } => {
                write!(f, "{n_packets} whole packets came, and no reading: {why}")
            }
            Self::OtherChannels { expected, found } => write!(
                f,
                "lines of {found} numbers come, {expected} are expected: connect the device of this \
                 limb, or set the number of channels"
            ),
            Self::Topic(fault) => write!(f, "{fault}"),
            Self::Clock(fault) => write!(
                f,
                "the device's clock is not believed, {fault}: readings get the time of their arrival; \
                 reset the device, and see to it that its firmware counts µs since it started"
            ),
            Self::Damaged { n_chunks: 0, .. } => {
                write!(f, "not one readable chunk in the file: is it a recording of hapdef?")
            }
            Self::Damaged { n_damaged, n_bytes, .. } => write!(
                f,
                "{n_damaged} damaged stretches of the recording, {n_bytes} bytes, were left out: \
                 hapdef recover says what is lost"
            ),
        }
    }
}
