//! How hard contacts are searched, in one word.

/// How hard contacts are searched: [`crate::EstimatorParams::of`] and [`crate::TrackerParams::of`] are
/// the parameters. Errors and times of each are in `docs/contacts.md`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Effort {
    /// For two contacts two fifths of the usual time; their number is right less often.
    Fast,
    /// What everything is tuned with.
    #[default]
    Usual,
    /// For two contacts three times the usual time; fewer of three contacts are far off.
    Thorough,
}

impl Effort {
    /// Every effort, the least first.
    pub const ALL: [Self; 3] = [Self::Fast, Self::Usual, Self::Thorough];

    /// Scan sites that go with it, for [`crate::ScanSites::farthest`].
    #[must_use]
    pub const fn n_sites(self) -> usize {
        match self {
            Self::Fast => 400,
            Self::Usual => 800,
            Self::Thorough => 1200,
        }
    }
}
