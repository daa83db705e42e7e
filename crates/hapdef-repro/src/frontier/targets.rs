//! What the figures of the frontier should be, and whether they are.

use anyhow::Result;
use hapdef_report::{ReportTable, TextCell, TextTable};
use serde::Serialize;

use super::scaling::{ADJOINT, FACTOR, FRAME_GAUGES, FRAME_NODES};
use super::{Measured, planned};

/// A figure and the least or most that it should be.
#[derive(Clone, Debug, Serialize)]
struct Target {
    what: &'static str,
    wanted: Wanted,
    /// None where it was not measured.
    measured: Option<f64>,
}

/// What a figure should be.
#[derive(Clone, Copy, Debug, Serialize)]
enum Wanted {
    AtLeast(f64),
    AtMost(f64),
    /// An exponent within a tenth of zero.
    Flat,
}

/// Exponents of times with what they grow with, by their metrics.
const EXPONENTS: [(&str, &str, Wanted); 4] = [
    (
        FACTOR,
        "time of ordering and factor with nodes, exponent",
        Wanted::AtMost(1.5),
    ),
    (
        ADJOINT,
        "time of the adjoint solves with nodes, exponent",
        Wanted::AtMost(1.5),
    ),
    (
        FRAME_NODES,
        "time of a followed frame with nodes, exponent",
        Wanted::Flat,
    ),
    (
        FRAME_GAUGES,
        "time of a followed frame with gauges, exponent",
        Wanted::AtMost(1.1),
    ),
];

impl Wanted {
    fn is_met(self, figure: f64) -> bool {
        match self {
            Self::AtLeast(least) => figure >= least,
            Self::AtMost(most) => figure <= most,
            Self::Flat => figure.abs() <= 0.1,
        }
    }

    fn text(self) -> String {
        match self {
            Self::AtLeast(least) => format!("at least {least}"),
            Self::AtMost(most) => format!("at most {most}"),
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
        cells.push(TextCell {
            text: verdict.into(),
            strong: verdict == "met",
        });
        cells
    }
}

/// The figures beside what they should be.
pub(super) fn table(measured: &Measured) -> Result<ReportTable> {
    let targets = targets(measured);
    let header = ["", "should be", "is", ""];
    Ok(ReportTable {
        title: "What was asked for".into(),
        note: "Times faster: the same scene with everything it may want over the same with single contacts \
               alone, as further below; a followed frame with the displacement of the whole skin."
            .into(),
        text: TextTable {
            header: header.map(str::to_owned).to_vec(),
            rows: targets.iter().map(Target::cells).collect(),
        },
        data: serde_json::to_value(&targets)?,
    })
}

fn targets(measured: &Measured) -> Vec<Target> {
    let skips = &measured.skips;
    let target = |what, wanted, measured| Target {
        what,
        wanted,
        measured,
    };
    let searched = &skips.searched;
    let same_pct = 100.0 * searched.n_equal as f64 / searched.n_single.max(1) as f64;
    let mut targets = vec![
        target(
            "design, times faster",
            Wanted::AtLeast(5.0),
            Some(skips.design_speedup()),
        ),
        target(
            "a followed frame, times faster",
            Wanted::AtLeast(3.0),
            Some(skips.followed.speedup()),
        ),
        target(
            "a searched frame, times faster",
            Wanted::AtLeast(3.0),
            Some(searched.speedup()),
        ),
        target(
            "searched contacts that are the same, %",
            Wanted::AtLeast(100.0),
            Some(same_pct),
        ),
        target(
            "worst of expected and measured times, one over the other",
            Wanted::AtMost(2.0),
            planned::worst_ratio(&measured.planned),
        ),
    ];
    for (metric, what, wanted) in EXPONENTS {
        let growth = measured.growths.iter().find(|g| g.metric == metric);
        targets.push(target(what, wanted, growth.map(|g| g.exponent)));
    }
    targets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_is_met_or_missed_or_was_not_measured() {
        let verdict = |wanted, measured| {
            let what = "x";
            let target = Target {
                what,
                wanted,
                measured,
            };
            target.cells()[3].text.clone()
        };
        assert_eq!(verdict(Wanted::AtLeast(5.0), Some(5.0)), "met");
        assert_eq!(verdict(Wanted::AtLeast(5.0), Some(4.99)), "missed");
        assert_eq!(verdict(Wanted::AtMost(2.0), Some(2.01)), "missed");
        assert_eq!(verdict(Wanted::AtMost(2.0), Some(f64::NAN)), "missed");
        assert_eq!(verdict(Wanted::Flat, Some(-0.1)), "met");
        assert_eq!(verdict(Wanted::Flat, Some(0.11)), "missed");
        assert_eq!(verdict(Wanted::Flat, None), "not measured");
    }
}
