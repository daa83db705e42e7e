//! What is said, in plain numbers: readings, contacts, health.

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

/// The contacts behind a reading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contacts {
    /// Sample instant of the reading, ns since 1970 UTC.
    pub stamp_ns: u64,
    /// Number of the reading's packet.
    pub seq: u32,
    /// How good the explanation is, where that is known.
    pub quality: Option<Quality>,
    /// The contacts, the strongest first.
    pub contacts: Vec<Contact>,
    /// Other explanations of the reading, nearly as good, the best first; may be empty.
    pub alternatives: Vec<Alternative>,
}

/// Another explanation of a reading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Alternative {
    /// How much worse it is: −2 ln evidence less that of the reported contacts.
    pub delta_cost: f64,
    /// Its contacts: where on the skin, m, and normal force, N.
    pub contacts: Vec<([f64; 3], f64)>,
}

/// How good an explanation of a reading is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Whether the reading decides for these contacts.
    pub is_identified: bool,
    /// Probability of a residual as large.
    pub p_value: f64,
}

/// One contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Stays the same while the contact lasts, where contacts are followed; else its place in the
    /// list.
    pub id: u32,
    /// Where on the skin, m.
    pub position_m: [f64; 3],
    /// Unit normal of the skin there, outwards; zero where it is not known: the contact has no
    /// frame, wrench and markers then.
    pub normal: [f64; 3],
    /// Its normal force, N.
    pub force_n: f64,
    /// How sure it is, where that is known.
    pub uncertainty: Option<Uncertainty>,
}

/// Covariance of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertainty {
    /// Two unit tangents of the skin, at right angles.
    pub tangents: [[f64; 3]; 2],
    /// Covariance of (position along tangent 1, along tangent 2, force), m and N, row by row.
    pub covariance: [f64; 9],
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
