//! Why a tare is not taken, or does not hold.

use std::fmt::{self, Display, Formatter};

use hapdef_contact::Contact;

/// Why a tare is not taken, or does not hold.
#[derive(Clone, Debug, PartialEq)]
pub struct TareFault {
    /// What is wrong with it.
    pub kind: TareFaultKind,
    /// The contacts that explain it, if some do.
    pub contacts: Vec<Contact>,
    /// What holds now.
    pub outcome: TareOutcome,
}

/// What is wrong with a tare.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TareFaultKind {
    /// Its readings moved.
    Moved {
        /// The gauge that moved most beyond noise and drift.
        gauge: usize,
        /// How far, µε.
        by_ue: f64,
    },
    /// A contact explains what its readings are above those that were untouched before.
    Pressed,
    /// What pressed unseen when it was taken has let go: its release, mirrored, explains the readings.
    PressedUnseen,
}

/// What holds after a tare was found wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TareOutcome {
    /// The zero before it.
    Kept,
    /// Nothing: the next tare has begun.
    Again,
    /// Nothing, until somebody tares.
    Waits,
    /// The zero, less what pressed.
    PutRight,
}

/// What becomes of the zero when it turns out that something pressed unseen while it was taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Retare {
    /// The phase is unknown until somebody tares.
    #[default]
    Ask,
    /// It is moved by what was let go.
    Auto,
}

impl TareFaultKind {
    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Moved { .. } => "moved",
            Self::Pressed => "pressed",
            Self::PressedUnseen => "pressed_unseen",
        }
    }
}

impl TareOutcome {
    /// Its word.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::Again => "again",
            Self::Waits => "waits",
            Self::PutRight => "put_right",
        }
    }
}

impl Display for TareFault {
    /// What is wrong, where what pressed, and what to do.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.kind {
            TareFaultKind::Moved { gauge, by_ue } => {
                write!(f, "tare refused: gauge {gauge} moved by {by_ue:.1} µε meanwhile")?;
            }
            TareFaultKind::Pressed => f.write_str("tare refused: something presses")?,
            TareFaultKind::PressedUnseen => {
                f.write_str("the tare was taken while something pressed that has let go now")?;
            }
        }
        for (i, contact) in self.contacts.iter().enumerate() {
            let [x, y, z] = [0, 1, 2].map(|axis| contact.position_m[axis] * 1e3);
            let start = if i == 0 { ": " } else { ", " };
            write!(f, "{start}{:.1} N at ({x:.0}, {y:.0}, {z:.0}) mm", contact.force_n)?;
        }
        f.write_str(match self.outcome {
            TareOutcome::Kept => "; the zero before it stays: tare while nothing touches",
            TareOutcome::Again => "; it begins again: touch nothing",
            TareOutcome::Waits => "; tare again while nothing touches",
            TareOutcome::PutRight => "; the zero was put right",
        })
    }
}
