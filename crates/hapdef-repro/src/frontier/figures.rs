//! The figures of the frontier: METRIC lines, and what they should be.

use hapdef_bench::{Figure, Goal, Measurements, Metric, Named, Study, Wanted};

use super::growth::Growth;
use super::{Measured, planned};

/// Names of exponents that should be at most or about something.
pub(super) const FACTOR: &str = "factor_exponent";
pub(super) const ADJOINT: &str = "adjoint_exponent";
pub(super) const FRAME_NODES: &str = "frame_nodes_exponent";
pub(super) const FRAME_GAUGES: &str = "frame_gauges_exponent";

pub(super) const STUDY: Study<Measured> = Study {
    folder: "frontier",
    metrics: &METRICS,
    goals: &GOALS,
    goals_note: GOALS_NOTE,
    file: Some("frontier.json"),
};

/// What is printed as METRIC lines, beside the exponents of the growths.
const METRICS: [Metric<Measured>; 9] = [
    metric("frontier.points", "1", |m| Some(m.points.len() as f64)),
    Metric::all(
        "frontier.plan_time_ratio_worst",
        "1",
        |m| planned::worst_ratio(&m.planned),
        "--without-nets",
    ),
    metric("frontier.design_speedup", "1", |m| Some(m.skips.design_speedup())),
    metric("frontier.frame_speedup", "1", |m| Some(m.skips.followed.speedup())),
    metric("frontier.frame_speedup_searched", "1", |m| Some(m.skips.searched.speedup())),
    metric("frontier.frame_speedup_contacts", "1", |m| Some(m.skips.followed.contacts_speedup())),
    metric("frontier.frame_speedup_contacts_searched", "1", |m| {
        Some(m.skips.searched.contacts_speedup())
    }),
    metric("frontier.equal_followed_pct", "%", |m| Some(m.skips.followed.equal_pct())),
    metric("frontier.equal_searched_pct", "%", |m| Some(m.skips.searched.equal_pct())),
];

/// What the figures should be.
const GOALS: [Goal<Measured>; 9] = [
    goal("design, times faster", Wanted::AtLeast(5.0), |m| Some(m.skips.design_speedup())),
    goal("a followed frame, times faster", Wanted::AtLeast(3.0), |m| {
        Some(m.skips.followed.speedup())
    }),
    goal("a searched frame, times faster", Wanted::AtLeast(3.0), |m| {
        Some(m.skips.searched.speedup())
    }),
    goal("searched contacts that are the same, %", Wanted::AtLeast(100.0), |m| {
        let searched = &m.skips.searched;
        Some(100.0 * searched.n_equal as f64 / searched.n_single.max(1) as f64)
    }),
    goal("worst of expected and measured times, one over the other", Wanted::AtMost(2.0), |m| {
        planned::worst_ratio(&m.planned)
    }),
    exponent(FACTOR, "time of ordering and factor with nodes, exponent", Wanted::AtMost(1.5)),
    exponent(ADJOINT, "time of the adjoint solves with nodes, exponent", Wanted::AtMost(1.5)),
    exponent(FRAME_NODES, "time of a followed frame with nodes, exponent", Wanted::Flat),
    exponent(FRAME_GAUGES, "time of a followed frame with gauges, exponent", Wanted::AtMost(1.1)),
];

const GOALS_NOTE: &str = "Times faster: the same scene with everything it may want over the same \
    with single contacts alone, as further below; a followed frame with the displacement of the whole skin.";

impl Measurements for Measured {
    type Row = Growth;

    fn rows(&self) -> &[Growth] {
        &self.growths
    }
}

impl Named for Growth {
    /// Growths are named by the metrics of their exponents.
    fn name(&self) -> &str {
        self.metric
    }
}

const fn metric(
    name: &'static str,
    unit: &'static str,
    of: fn(&Measured) -> Option<f64>,
) -> Metric<Measured> {
    Metric::all(name, unit, of, "not measured")
}

const fn goal(
    what: &'static str,
    wanted: Wanted,
    of: fn(&Measured) -> Option<f64>,
) -> Goal<Measured> {
    Goal { what, wanted, figure: Figure::All(of) }
}

const fn exponent(metric: &'static str, what: &'static str, wanted: Wanted) -> Goal<Measured> {
    Goal { what, wanted, figure: Figure::Row(metric, |growth: &Growth| growth.exponent) }
}
