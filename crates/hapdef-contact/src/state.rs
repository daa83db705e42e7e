//! States of contacts, frames and gauges.

use std::fmt::{self, Display, Formatter};

/// What a contact is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// It has come, and its place is searched anew as its force grows.
    Born,
    /// It stays where it is: only its force is solved every frame, its place and the map's error
    /// there sharpen as frames add up.
    Held,
    /// It moves over the skin.
    Sliding,
}

/// Whether something touches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TouchPhase {
    /// The tare is being taken: nothing may touch.
    #[default]
    Taring,
    /// Nothing touches.
    Untouched,
    /// Something touches.
    Touched,
    /// The sensor can't know whether and where something touches.
    Unknown(UnknownReason),
}

/// Why the sensor can't know whether something touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnknownReason {
    /// A contact that matters could be where the gauges that count would not see it.
    TooFewGauges,
    /// No readings have come for too long.
    StreamStalled,
    /// The baselines are not those of an untouched limb.
    TareInvalid,
    /// No contacts that are believed explain the readings.
    Misfit,
    /// The baselines drift faster than they are followed.
    Drift,
}

/// What the frame decides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing touches.
    #[default]
    Untouched,
    /// The contacts are those reported.
    Identified,
    /// The contacts reported are the best guess, but the frame does not decide.
    NotIdentifiable(WhyNot),
}

/// Why the contacts are not identified.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhyNot {
    /// The readings leave a contact's place open: its standard deviation is that of the whole skin.
    SingularInformation,
    /// Another explanation in a different place is as good, or one contact in place of two that are
    /// followed nearer to each other than two can be told apart.
    TiedExplanations,
    /// Even as many contacts as may be do not explain the readings.
    Misfit,
    /// The contacts take all that the gauges measure, or all but one number, or two where a further
    /// contact may touch: nothing is left to check them by, and other contacts would explain the
    /// readings as well.
    Unchecked,
    /// Fewer contacts and more noise than was assumed explain the readings nearly as well.
    Noise,
}

/// What is wrong with a gauge, if anything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GaugeHealth {
    /// Nothing.
    #[default]
    Good,
    /// At an end of its converter's range.
    Saturated,
    /// It repeats a value while others move.
    Dead,
    /// It jumped alone.
    Spike,
    /// No number.
    NotFinite,
    /// Good again, but not for long enough to count.
    Recovering,
}

impl Phase {
    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Born => "born",
            Self::Held => "held",
            Self::Sliding => "sliding",
        }
    }
}

impl TouchPhase {
    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Taring => "taring",
            Self::Untouched => "untouched",
            Self::Touched => "touched",
            Self::Unknown(_) => "unknown",
        }
    }

    /// Why it is not known whether something touches; `None` while taring, too.
    #[must_use]
    pub const fn why_unknown(self) -> Option<UnknownReason> {
        match self {
            Self::Unknown(why) => Some(why),
            Self::Taring | Self::Untouched | Self::Touched => None,
        }
    }

    /// Whether a controller may act on the contacts, or on there being none.
    #[must_use]
    pub const fn is_known(self) -> bool {
        matches!(self, Self::Untouched | Self::Touched)
    }
}

impl Display for TouchPhase {
    /// For people, in a few words.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Taring => f.write_str("taring, touch nothing"),
            Self::Untouched | Self::Touched => f.write_str(self.word()),
            Self::Unknown(why) => write!(f, "unknown: {why}"),
        }
    }
}

impl UnknownReason {
    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::TooFewGauges => "too_few_gauges",
            Self::StreamStalled => "stream_stalled",
            Self::TareInvalid => "tare_invalid",
            Self::Misfit => "misfit",
            Self::Drift => "drift",
        }
    }
}

impl Display for UnknownReason {
    /// For people, in a few words.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooFewGauges => "too few gauges count to exclude a contact",
            Self::StreamStalled => "no readings come",
            Self::TareInvalid => "the tare is not valid",
            Self::Misfit => "readings not explained",
            Self::Drift => "the readings drift faster than is followed",
        })
    }
}

impl WhyNot {
    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::SingularInformation => "singular_information",
            Self::TiedExplanations => "tied_explanations",
            Self::Misfit => "misfit",
            Self::Unchecked => "unchecked",
            Self::Noise => "noise",
        }
    }
}

impl GaugeHealth {
    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Saturated => "saturated",
            Self::Dead => "dead",
            Self::Spike => "spike",
            Self::NotFinite => "no_number",
            Self::Recovering => "recovering",
        }
    }
}
