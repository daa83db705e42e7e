//! What the figures of the frontier should be.

use anyhow::Result;
use hapdef_report::ReportTable;

use super::scaling::{ADJOINT, FACTOR, FRAME_GAUGES, FRAME_NODES};
use super::{Measured, planned};
use hapdef_bench::{Target, Wanted, target_table};

/// Exponents of times with what they grow with, by their metrics.
const EXPONENTS: [(&str, &str, Wanted); 4] = [
    (FACTOR, "time of ordering and factor with nodes, exponent", Wanted::AtMost(1.5)),
    (ADJOINT, "time of the adjoint solves with nodes, exponent", Wanted::AtMost(1.5)),
    (FRAME_NODES, "time of a followed frame with nodes, exponent", Wanted::Flat),
    (FRAME_GAUGES, "time of a followed frame with gauges, exponent", Wanted::AtMost(1.1)),
];

/// The figures beside what they should be.
pub(super) fn table(measured: &Measured) -> Result<ReportTable> {
    let note = "Times faster: the same scene with everything it may want over the same with single contacts \
                alone, as further below; a followed frame with the displacement of the whole skin.";
    Ok(target_table(&targets(measured), note)?)
}

fn targets(measured: &Measured) -> Vec<Target> {
    let skips = &measured.skips;
    let target = |what, wanted, measured| Target { what, wanted, measured };
    let searched = &skips.searched;
    let same_pct = 100.0 * searched.n_equal as f64 / searched.n_single.max(1) as f64;
    let mut targets = vec![
        target("design, times faster", Wanted::AtLeast(5.0), Some(skips.design_speedup())),
        target(
            "a followed frame, times faster",
            Wanted::AtLeast(3.0),
            Some(skips.followed.speedup()),
        ),
        target("a searched frame, times faster", Wanted::AtLeast(3.0), Some(searched.speedup())),
        target("searched contacts that are the same, %", Wanted::AtLeast(100.0), Some(same_pct)),
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
