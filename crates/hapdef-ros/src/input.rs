//! What is said, in plain numbers: readings, health.

use hapdef_contact::TouchPhase;

/// A reading of all gauges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings<'a> {
    /// Its sample instant, ns since 1970 UTC.
    pub stamp_ns: u64,
    /// Number of its packet.
    pub seq: u32,
    /// Packets missing directly before it.
    pub n_lost_before: u32,
    /// One a gauge, tared, µε.
    pub microstrain: &'a [f64],
}

/// Whether contacts can be known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// When, ns since 1970 UTC.
    pub stamp_ns: u64,
    /// Whether something touches, or why that is not known.
    pub phase: TouchPhase,
    /// The contacts are those of an earlier time.
    pub is_stale: bool,
    /// Contacts of the last reading.
    pub n_contacts: usize,
    /// Smallest force that would show wherever it pressed, N.
    pub smallest_seen_n: Option<f64>,
}

/// How a part is doing.
#[derive(Clone, Debug, PartialEq)]
pub struct Health {
    /// When, ns since 1970 UTC.
    pub stamp_ns: u64,
    /// Which part: `hapdef: acquisition`.
    pub name: String,
    /// How bad it is.
    pub level: Level,
    /// In a few words.
    pub message: String,
    /// Which hardware, if it is some.
    pub hardware_id: String,
    /// Its values, by name.
    pub values: Vec<(String, String)>,
}

/// How bad it is, by the numbers of diagnostic_msgs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Nothing is wrong.
    #[default]
    Ok = 0,
    /// Look at it.
    Warn = 1,
    /// It does not work.
    Error = 2,
    /// Nothing has been heard of it.
    Stale = 3,
}
