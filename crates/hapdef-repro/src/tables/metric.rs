//! Ways of measuring the error of a map.

use hapdef::MapError;

/// What the cells of a table measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MapMetric {
    /// Mean absolute error, µm.
    #[default]
    MeanAbs,
    /// Root mean square error, µm.
    Rms,
    /// Fraction of variance unexplained, %.
    Fvu,
}

impl MapMetric {
    /// In the order in which they are reported.
    pub const ALL: [Self; 3] = [Self::MeanAbs, Self::Rms, Self::Fvu];

    /// For tables.
    pub fn name(self) -> &'static str {
        ["mean |error|", "RMS", "FVU"][self as usize]
    }

    /// The unit that is printed.
    pub fn unit(self) -> &'static str {
        ["µm", "µm", "%"][self as usize]
    }

    /// A map's error by it, in [`Self::unit`].
    pub fn of(self, error: &MapError) -> f64 {
        match self {
            Self::MeanAbs => error.mean_abs_um,
            Self::Rms => error.rms_um,
            Self::Fvu => 100.0 * error.fvu,
        }
    }
}
