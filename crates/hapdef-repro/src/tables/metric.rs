//! Ways of measuring the error of a map.

/// What the cells of a table measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MapMetric {
    /// Mean absolute error, m.
    #[default]
    MeanAbs,
    /// Root mean square error, m.
    Rms,
    /// Fraction of variance unexplained, a share.
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

    /// Printed value over stored value.
    pub(super) fn scale(self) -> f64 {
        [1e6, 1e6, 1e2][self as usize]
    }
}
