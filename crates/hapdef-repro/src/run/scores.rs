//! Contacts scored both ways: the paper's lenient rule, and one-to-one with counts and GOSPA.

use anyhow::Result;
use hapdef::{
    ContactPair, ContactStats, FoundContact, Gospa, GospaParams, Hapdefx, gospa, score_lenient,
    score_one_to_one, scored,
};
use hapdef_bench::{Column, page_table, table};
use hapdef_report::ReportTable;
use serde::Serialize;

use super::chain::Choice;
use super::frames::{Frame, Frames};

/// GOSPA's cut-off: a contact missed or false costs half of it, the 10 mm of k-Max's radius.
pub(crate) const GOSPA: GospaParams = GospaParams { cutoff_m: 0.020, p: 1.0 };

/// Least forces that are tried for a candidate to count as a contact, N.
const LEAST_FORCES_N: std::ops::RangeInclusive<u32> = 1..=40;

/// How candidates become contacts.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Rule {
    /// The count T is given.
    Given(Choice),
    /// The count is not given: every candidate of at least so many N.
    Counted(f64),
}

/// The T strongest, without and with the paper's T + 1 exchange.
pub(crate) const TOP: Rule = Rule::Given(Choice::Force);
pub(crate) const TOP_WITH_SPREAD: Rule = Rule::Given(Choice::ForceWithSpread);

/// Scores of a set of presses by a rule.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct BothWays {
    /// For the table.
    pub(crate) name: String,
    /// Presses.
    pub(crate) n: usize,
    /// The paper's rule: each point to the closest true contact.
    pub(crate) lenient: ContactStats,
    /// Each point to a true contact of its own.
    pub(crate) one_to_one: ContactStats,
    /// Share of the presses in which as many contacts were found as there were.
    pub(crate) count_right: f64,
    /// Mean GOSPA of a press, mm.
    pub(crate) gospa_mm: f64,
    /// Missed contacts a press, by GOSPA's pairing.
    pub(crate) missed: f64,
    /// False contacts a press, by GOSPA's pairing.
    pub(crate) false_alarms: f64,
}

/// All rows of the table, and the least force of the counted ones, N.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Scores {
    /// Least force of a contact where the count is not given, N: the value of 0.5 to 20 N that
    /// counts right most often in the simulated validation samples of one to four contacts.
    pub(crate) least_force_n: f64,
    /// Rows.
    pub(crate) rows: Vec<BothWays>,
}

impl Scores {
    /// Scores everything.
    pub(crate) fn of(chain: &Hapdefx, frames: &Frames) -> Result<Self> {
        let least_force_n = pick_least_force(&frames.validation);
        let rules = [TOP, TOP_WITH_SPREAD, Rule::Counted(least_force_n)];
        let mut sets =
            vec![("rig, single", &frames.rig_single), ("rig, double", &frames.rig_double)];
        let names = ["simulated, I", "simulated, II", "simulated, III", "simulated, IV"];
        sets.extend(names.into_iter().zip(&frames.test));
        let mut rows = vec![];
        for (name, set) in sets.into_iter().filter(|(_, set)| !set.is_empty()) {
            for rule in rules {
                if set[0].truth.len() > 1 || rule != TOP_WITH_SPREAD {
                    rows.push(both_ways(name, chain, set, rule)?);
                }
            }
        }
        Ok(Self { least_force_n, rows })
    }

    /// The row of a set and rule.
    pub(crate) fn row(&self, set: &str, rule: Rule) -> Option<&BothWays> {
        let name = title(set, rule);
        self.rows.iter().find(|row| row.name == name)
    }

    /// For people.
    pub(crate) fn table(&self) -> Result<ReportTable> {
        let note = format!(
            "Lenient is the paper's rule: each of the T strongest candidates to the closest \
             true contact. One-to-one gives each a true contact of its own. T + 1: the \
             paper's exchange. Counted: the number is not given; a candidate of at least \
             {} N is a contact, the force that counts right most often on simulated \
             validation samples. GOSPA (Rahmathullah et al. 2017): α = 2, p = {}, c = {} mm, \
             mean of a press; missed and false contacts cost {} mm each. Rig: from readings. \
             Simulated: from true virtual gauges.",
            self.least_force_n,
            GOSPA.p,
            GOSPA.cutoff_m * 1e3,
            GOSPA.cutoff_m * 0.5e3,
        );
        Ok(page_table("Contacts, scored both ways", note, table(&COLUMNS, &self.rows), self)?)
    }
}

const COLUMNS: [Column<BothWays>; 11] = [
    Column::new("presses, rule", |r| r.name.clone()),
    Column::new("lenient, mm", |r| format!("{:.1}", r.lenient.mean_mm)),
    Column::new("lenient, N", |r| format!("{:.1}", r.lenient.mean_n)),
    Column::new("found", |r| format!("{} of {}", r.one_to_one.n, r.one_to_one.n_expected)),
    Column::new("one-to-one, mm", |r| format!("{:.1}", r.one_to_one.mean_mm)),
    Column::new("median, mm", |r| format!("{:.1}", r.one_to_one.median_mm)),
    Column::new("one-to-one, N", |r| format!("{:.1}", r.one_to_one.mean_n)),
    Column::new("count right", |r| format!("{:.0} %", r.count_right * 100.0)),
    Column::new("GOSPA, mm", |r| format!("{:.1}", r.gospa_mm)),
    Column::new("missed", |r| format!("{:.2}", r.missed)),
    Column::new("false", |r| format!("{:.2}", r.false_alarms)),
];

/// The contacts that a rule takes from a press's candidates.
pub(crate) fn choose(chain: &Hapdefx, frame: &Frame, rule: Rule) -> Result<Vec<FoundContact>> {
    match rule {
        Rule::Given(choice) => choice.of(chain, &frame.found, frame.truth.len()),
        Rule::Counted(least_n) => Ok(counted(&frame.found, least_n)),
    }
}

fn counted(found: &[FoundContact], least_n: f64) -> Vec<FoundContact> {
    found.iter().filter(|c| c.force_n >= least_n).copied().collect()
}

fn title(set: &str, rule: Rule) -> String {
    let rule = match rule {
        Rule::Given(Choice::ForceWithSpread) => "T given, T + 1",
        Rule::Given(_) => "T given",
        Rule::Counted(_) => "counted",
    };
    format!("{set}, {rule}")
}

fn pick_least_force(validation: &[Vec<Frame>]) -> f64 {
    let n_right = |least_n: f64| {
        let frames = validation.iter().flatten();
        let right = |frame: &&Frame| counted(&frame.found, least_n).len() == frame.truth.len();
        frames.filter(right).count()
    };
    // max_by_key takes the last of equals: reversed, the smallest force.
    let best = LEAST_FORCES_N.rev().max_by_key(|half| n_right(0.5 * f64::from(*half)));
    0.5 * f64::from(best.unwrap_or(1))
}

fn both_ways(set: &str, chain: &Hapdefx, frames: &[Frame], rule: Rule) -> Result<BothWays> {
    let (mut lenient, mut strict): (Vec<ContactPair>, Vec<ContactPair>) = (vec![], vec![]);
    let (mut n_right, mut metrics): (usize, Vec<Gospa>) = (0, vec![]);
    for frame in frames {
        let found = scored(&choose(chain, frame, rule)?);
        lenient.extend(score_lenient(&found, &frame.truth)?);
        strict.extend(score_one_to_one(&found, &frame.truth)?.pairs);
        n_right += usize::from(found.len() == frame.truth.len());
        metrics.push(gospa(&found, &frame.truth, &GOSPA)?);
    }
    let n = frames.len() as f64;
    let mean = |value: &dyn Fn(&Gospa) -> f64| metrics.iter().map(value).sum::<f64>() / n;
    let n_expected = frames.iter().map(|frame| frame.truth.len()).sum();
    Ok(BothWays {
        name: title(set, rule),
        n: frames.len(),
        lenient: ContactStats::of(&lenient, n_expected),
        one_to_one: ContactStats::of(&strict, n_expected),
        count_right: n_right as f64 / n,
        gospa_mm: mean(&|g| g.total_m * 1e3),
        missed: mean(&|g| g.n_missed as f64),
        false_alarms: mean(&|g| g.n_false as f64),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(n_true: usize, forces_n: &[f64]) -> Frame {
        let found = forces_n.iter().enumerate().map(|(node, force_n)| FoundContact {
            node,
            position_m: [0.0; 3],
            force_n: *force_n,
            displacement_um: 1.0,
        });
        Frame { truth: vec![([0.0; 3], 1.0); n_true], found: found.collect() }
    }

    /// One true contact beside a spurious one of 2.9 N, two of at least 4.2 N: 3 N, not more.
    #[test]
    fn the_least_force_counts_right_most_often() {
        let frames = vec![vec![frame(1, &[9.0, 2.9])], vec![frame(2, &[9.0, 4.2, 1.0])]];
        assert!((pick_least_force(&frames) - 3.0).abs() < 1e-12);
        assert!((pick_least_force(&[]) - 0.5).abs() < 1e-12);
    }
}
