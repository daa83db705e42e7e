//! What figures should be, and whether they are.

use hapdef_report::{TextCell, TextTable};
use serde::Serialize;

/// A figure and the least or most that it should be.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Target {
    /// The figure in words, with its unit.
    pub what: &'static str,
    /// What it should be.
    pub wanted: Wanted,
    /// None where it was not measured.
    pub measured: Option<f64>,
}

/// What a figure should be.
#[derive(Clone, Copy, Debug, Serialize)]
pub enum Wanted {
    /// This or more.
    AtLeast(f64),
    /// This or less.
    AtMost(f64),
    /// In this range, its ends included.
    Between(f64, f64),
    /// An exponent within a tenth of zero.
    Flat,
}

/// The figures beside what they should be.
pub(crate) fn target_table(targets: &[Target]) -> TextTable {
    TextTable {
        header: ["", "should be", "is", ""].map(str::to_owned).to_vec(),
        rows: targets.iter().map(Target::cells).collect(),
    }
}

impl Wanted {
    /// Whether a figure is what it should be.
    #[must_use]
    pub fn is_met(self, figure: f64) -> bool {
        match self {
            Self::AtLeast(least) => figure >= least,
            Self::AtMost(most) => figure <= most,
            Self::Between(least, most) => (least..=most).contains(&figure),
            Self::Flat => figure.abs() <= 0.1,
        }
    }

    pub(crate) fn text(self) -> String {
        match self {
            Self::AtLeast(least) => format!("at least {least}"),
            Self::AtMost(most) => format!("at most {most}"),
            Self::Between(least, most) => format!("{least} to {most}"),
            Self::Flat => "0 ± 0.1".into(),
        }
    }
}

impl Target {
    fn cells(&self) -> Vec<TextCell> {
        let (measured, verdict) = match self.measured {
            Some(figure) if self.wanted.is_met(figure) => (format!("{figure:.2}"), "met"),
            Some(figure) => (format!("{figure:.2}"), "missed"),
            None => ("–".into(), "not measured"),
        };
        let cells = [self.what.to_owned(), self.wanted.text(), measured];
        let mut cells = cells.map(TextCell::plain).to_vec();
        cells.push(TextCell { text: verdict.into(), strong: verdict == "met" });
        cells
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_is_met_or_missed_or_was_not_measured() {
        let verdict = |wanted, measured| {
            let what = "x";
            let target = Target { what, wanted, measured };
            target.cells()[3].text.clone()
        };
        assert_eq!(verdict(Wanted::AtLeast(5.0), Some(5.0)), "met");
        assert_eq!(verdict(Wanted::AtLeast(5.0), Some(4.99)), "missed");
        assert_eq!(verdict(Wanted::AtMost(2.0), Some(2.01)), "missed");
        assert_eq!(verdict(Wanted::AtMost(2.0), Some(f64::NAN)), "missed");
        assert_eq!(verdict(Wanted::Between(92.0, 98.0), Some(98.1)), "missed");
        assert_eq!(verdict(Wanted::Between(92.0, 98.0), Some(92.0)), "met");
        assert_eq!(verdict(Wanted::Flat, Some(-0.1)), "met");
        assert_eq!(verdict(Wanted::Flat, Some(0.11)), "missed");
        assert_eq!(verdict(Wanted::Flat, None), "not measured");
    }
}
