//! What a reader of an ANSYS deck keeps from command to command.

use std::collections::BTreeSet;

/// Which nodes or elements the next command's ALL means.
#[derive(Clone, Debug, Default)]
pub(super) enum Selection {
    /// Everything.
    #[default]
    All,
    /// These numbers.
    Some(BTreeSet<u32>),
    /// A selection this reader does not follow: a command that uses it is refused.
    Unknown,
}

/// A load as given; its value is looked up at the end, when the step's time is known.
#[derive(Debug)]
pub(super) struct PendingLoad {
    pub line: usize,
    pub targets: Vec<u32>,
    pub value: String,
    pub kind: LoadKind,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum LoadKind {
    /// A displacement in the directions of these bits; it must be 0.
    Hold(u8),
    /// A force component.
    Force(usize),
    /// A force per area along an axis of the surface element's coordinate system.
    Surface(usize),
}
