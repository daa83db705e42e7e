//! What is said, in plain numbers: readings, health.

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
