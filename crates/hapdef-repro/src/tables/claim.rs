//! Claims of the paper and how they fared, by comparisons of two numbers each.

use hapdef_report::{TextCell, TextTable, cell_text};

/// How a claim fared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fate {
    /// In every comparison.
    Holds,
    /// In some comparisons.
    HoldsPartly,
    /// In none.
    Fails,
    /// No comparison breaks it, but some were not measured.
    NotMeasured,
}

/// One comparison: the claim says that `low` is below `high`, in the same unit.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Check {
    /// Where it was made, such as "I–III on IV"; may be empty.
    pub place: String,
    /// What should be lower.
    pub low_name: String,
    /// Its value; `None` if not measured.
    pub low: Option<f64>,
    /// What should be higher.
    pub high_name: String,
    /// Its value; `None` if not measured.
    pub high: Option<f64>,
    /// Whether equal is enough.
    pub or_equal: bool,
}

/// A claim judged by one metric.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct MetricVerdict {
    /// The metric, such as "mean |error|".
    pub metric: String,
    /// How the claim fared.
    pub fate: Fate,
    /// Comparisons the claim consists of.
    pub n_checks: usize,
    /// Comparisons that hold.
    pub n_held: usize,
    /// Comparisons of which a side was not measured.
    pub n_missing: usize,
    /// The deciding numbers in one line.
    pub reason: String,
}

/// A claim of the paper.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Claim {
    /// Short name for machines.
    pub id: &'static str,
    /// The claim, in words.
    pub text: &'static str,
    /// What the paper prints for it.
    pub paper: &'static str,
    /// A verdict per metric.
    pub verdicts: Vec<MetricVerdict>,
}

impl Fate {
    /// In words.
    pub fn name(self) -> &'static str {
        ["holds", "holds partly", "fails", "not measured"][self as usize]
    }
}

impl Check {
    /// `low` must be below `high`.
    pub fn below(
        place: impl Into<String>,
        low: (&str, Option<f64>),
        high: (&str, Option<f64>),
    ) -> Self {
        Self {
            place: place.into(),
            low_name: low.0.to_owned(),
            low: low.1,
            high_name: high.0.to_owned(),
            high: high.1,
            or_equal: false,
        }
    }

    /// `low` must not be above `high`.
    pub fn at_most(
        place: impl Into<String>,
        low: (&str, Option<f64>),
        high: (&str, Option<f64>),
    ) -> Self {
        Self { or_equal: true, ..Self::below(place, low, high) }
    }

    /// Whether it holds; `None` if a side was not measured. A number that is not finite on either
    /// side proves nothing and breaks it.
    pub fn holds(&self) -> Option<bool> {
        let (low, high) = (self.low?, self.high?);
        let kept = if self.or_equal { low <= high } else { low < high };
        Some(kept && low.is_finite() && high.is_finite())
    }

    /// How far it is from holding: low over high.
    fn ratio(&self) -> f64 {
        match (self.low, self.high) {
            (Some(low), Some(high)) if low.is_finite() && high.is_finite() => low / high,
            _ => f64::INFINITY,
        }
    }

    fn shown(&self, unit: &str) -> String {
        let place = if self.place.is_empty() { String::new() } else { format!("{}: ", self.place) };
        format!(
            "{place}{} {}, {} {} {unit}",
            self.low_name,
            cell_text(self.low),
            self.high_name,
            cell_text(self.high)
        )
        .trim_end()
        .to_owned()
    }
}

impl MetricVerdict {
    /// Judges a claim by its comparisons, whose values are in `unit`.
    pub fn of(metric: impl Into<String>, unit: &str, checks: &[Check]) -> Self {
        let n_held = checks.iter().filter(|c| c.holds() == Some(true)).count();
        let n_missing = checks.iter().filter(|c| c.holds().is_none()).count();
        let fate = match (n_held, n_missing) {
            _ if n_missing == checks.len() => Fate::NotMeasured,
            _ if n_held == checks.len() => Fate::Holds,
            _ if n_held + n_missing == checks.len() => Fate::NotMeasured,
            (0, _) => Fate::Fails,
            _ => Fate::HoldsPartly,
        };
        Self {
            metric: metric.into(),
            fate,
            n_checks: checks.len(),
            n_held,
            n_missing,
            reason: reason(fate, n_held, unit, checks),
        }
    }
}

/// The comparison that is closest to breaking, or farthest from holding.
fn reason(fate: Fate, n_held: usize, unit: &str, checks: &[Check]) -> String {
    let measured = checks.iter().filter(|c| c.holds().is_some());
    let worst = measured.max_by(|a, b| a.ratio().total_cmp(&b.ratio()));
    let Some(worst) = worst else {
        return "nothing was measured".to_owned();
    };
    let shown = worst.shown(unit);
    match (fate, checks.len()) {
        (_, 1) => shown,
        (Fate::Holds, n) => format!("all {n}; closest {shown}"),
        (_, n) => format!("{n_held} of {n}; worst {shown}"),
    }
}

impl Claim {
    /// Over all metrics: holds or fails where every measured metric says so.
    pub fn fate(&self) -> Fate {
        let measured = || self.verdicts.iter().filter(|v| v.fate != Fate::NotMeasured);
        if measured().next().is_none() || measured().count() < self.verdicts.len() {
            return Fate::NotMeasured;
        }
        for fate in [Fate::Holds, Fate::Fails] {
            if measured().all(|v| v.fate == fate) {
                return fate;
            }
        }
        Fate::HoldsPartly
    }
}

/// One row per claim and metric; what holds stands out.
pub fn claims_text(claims: &[Claim]) -> TextTable {
    let header = ["claim", "paper", "metric", "verdict", "why"];
    let rows = claims.iter().flat_map(|claim| {
        claim.verdicts.iter().enumerate().map(|(i, verdict)| {
            let first = |text: &str| TextCell::plain(if i == 0 { text } else { "" });
            vec![
                first(claim.text),
                first(claim.paper),
                TextCell::plain(&verdict.metric),
                TextCell {
                    text: verdict.fate.name().to_owned(),
                    strong: verdict.fate == Fate::Holds,
                },
                TextCell::plain(&verdict.reason),
            ]
        })
    });
    TextTable { header: header.map(str::to_owned).to_vec(), rows: rows.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(checks: &[(Option<f64>, Option<f64>)]) -> MetricVerdict {
        let check = |&(low, high): &(Option<f64>, Option<f64>)| {
            Check::below("here", ("a", low), ("b", high))
        };
        MetricVerdict::of("m", "mm", &checks.iter().map(check).collect::<Vec<_>>())
    }

    #[test]
    fn the_count_of_checks_decides() {
        let (good, bad, none) = ((Some(1.0), Some(2.0)), (Some(2.0), Some(2.0)), (None, Some(1.0)));
        assert_eq!(verdict(&[good, good]).fate, Fate::Holds);
        assert_eq!(verdict(&[good, bad]).fate, Fate::HoldsPartly);
        assert_eq!(verdict(&[bad, bad]).fate, Fate::Fails);
        assert_eq!(verdict(&[good, none]).fate, Fate::NotMeasured);
        assert_eq!(verdict(&[bad, none]).fate, Fate::Fails);
        assert_eq!(verdict(&[none]).reason, "nothing was measured");
        assert_eq!(verdict(&[(Some(f64::NAN), Some(1.0))]).fate, Fate::Fails);
    }

    #[test]
    fn the_reason_names_the_worst_comparison() {
        let found = verdict(&[(Some(1.0), Some(2.0)), (Some(3.0), Some(2.0))]);
        assert_eq!(found.reason, "1 of 2; worst here: a 3.0, b 2.0 mm");
        assert_eq!(verdict(&[(Some(1.0), Some(4.0))]).reason, "here: a 1.0, b 4.0 mm");
        let draw = Check::at_most("", ("a", Some(2.0)), ("b", Some(2.0)));
        assert_eq!(draw.holds(), Some(true));
    }

    #[test]
    fn a_claim_holds_by_every_metric_or_partly() {
        let good = verdict(&[(Some(1.0), Some(2.0))]);
        let bad = verdict(&[(Some(2.0), Some(1.0))]);
        let claim = |verdicts: &[&MetricVerdict]| Claim {
            id: "x",
            text: "a is below b",
            paper: "",
            verdicts: verdicts.iter().map(|v| (*v).clone()).collect(),
        };
        assert_eq!(claim(&[&good, &good]).fate(), Fate::Holds);
        assert_eq!(claim(&[&good, &bad]).fate(), Fate::HoldsPartly);
        assert_eq!(claim(&[&bad]).fate(), Fate::Fails);
        assert_eq!(claim(&[]).fate(), Fate::NotMeasured);
        let text = claims_text(&[claim(&[&good, &bad])]).to_markdown();
        assert!(text.contains("| **holds** | here: a 1.0"), "{text}");
        assert!(text.contains("|  |  | m | fails | here: a 2.0"), "{text}");
    }
}
