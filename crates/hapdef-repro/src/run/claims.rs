//! The paper's claims about contacts, gauges and maps on the rig.

use hapdef::{ContactStats, MapError};

use super::made::Made;
use super::patches::SizePoint;
use super::scores::{TOP, TOP_WITH_SPREAD};
use crate::tables::{
    Check, Claim, Fate, MapMetric, MetricVerdict, PAPER_FVU_DOUBLE, PAPER_FVU_SINGLE,
};

/// The patch size that the paper finds best.
const PAPER_SIZE: usize = 24;

/// Every claim that is not about Table 1.
pub(crate) fn claims(of: &Made<'_>) -> Vec<Claim> {
    let mut claims = vec![
        figure_4(of),
        direct_or_chain(of),
        single_or_2018(of),
        double_or_single(of),
        exchange(of),
        accuracy(of),
        map(of),
        force_error_grows(of),
        spurious_are_weak(of),
    ];
    claims.extend(of.sizes.as_deref().map(best_size));
    claims
}

fn mm(stats: &ContactStats) -> Option<f64> {
    (stats.n > 0).then_some(stats.mean_mm)
}

fn newton(stats: &ContactStats) -> Option<f64> {
    (stats.n > 0).then_some(stats.mean_n)
}

/// An accuracy with a name for it.
type Named<'a> = (&'a str, &'a ContactStats);

/// A claim that one accuracy is below another, in position and in force.
fn compared(
    id: &'static str,
    text: &'static str,
    paper: &'static str,
    pairs: &[[Named<'_>; 2]],
) -> Claim {
    let judge = |metric: &str, unit: &str, value: fn(&ContactStats) -> Option<f64>| {
        let checks: Vec<Check> = pairs
            .iter()
            .map(|[low, high]| Check::below("", (low.0, value(low.1)), (high.0, value(high.1))))
            .collect();
        MetricVerdict::of(metric, unit, &checks)
    };
    Claim {
        id,
        text,
        paper,
        verdicts: vec![judge("position", "mm", mm), judge("force", "N", newton)],
    }
}

fn figure_4(of: &Made<'_>) -> Claim {
    let [svr, knn, fnn] = [0, 1, 2].map(|i| of.singles.stats(&of.singles.direct[i]));
    compared(
        "fnn_best_directly",
        "single contacts, straight from readings: FNN better than k-NN, k-NN better than SVR",
        "figure 4A: by a small and by a big margin",
        &[[("FNN", &fnn), ("k-NN", &knn)], [("k-NN", &knn), ("SVR", &svr)]],
    )
}

fn direct_or_chain(of: &Made<'_>) -> Claim {
    let single = &of.scores.single;
    compared(
        "direct_beats_chain",
        "single contacts: the direct FNN better than the whole chain",
        "3 mm, 1.5 N against 5 mm, 3 N",
        &[[("direct", &single.direct), ("chain", &single.hapdefx)]],
    )
}

fn single_or_2018(of: &Made<'_>) -> Claim {
    let svr = of.singles.stats(&of.singles.direct[0]);
    let mut claim = compared(
        "chain_locates_better_than_2018",
        "single contacts: the chain locates better than HapDef 2018 (SVR)",
        "5 mm against 8 mm",
        &[[("chain", &of.scores.single.hapdefx), ("HapDef 2018", &svr)]],
    );
    claim.verdicts.truncate(1);
    claim
}

fn double_or_single(of: &Made<'_>) -> Claim {
    let double = of.scores.double.as_ref().map_or_else(ContactStats::default, |d| d.lenient_spread);
    compared(
        "double_harder_than_single",
        "the chain: one contact better than two",
        "5 mm, 3 N against 10 mm, 6 N",
        &[[("single", &of.scores.single.hapdefx), ("double", &double)]],
    )
}

/// The T + 1 exchange, by the paper's rule and by those it does not use.
fn exchange(of: &Made<'_>) -> Claim {
    let [plain, spread] = [TOP, TOP_WITH_SPREAD].map(|r| of.both.row("rig, double", r));
    let judge = |metric: &str, value: &dyn Fn(&super::scores::BothWays) -> Option<f64>| {
        let check =
            Check::below("", ("T + 1", spread.and_then(value)), ("T", plain.and_then(value)));
        MetricVerdict::of(metric, "mm", &[check])
    };
    Claim {
        id: "exchange_helps",
        text: "two contacts: taking point T + 1 for T where it is near in force and farther off lowers the position error",
        paper: "10 mm against 14 mm",
        verdicts: vec![
            judge("lenient", &|row| mm(&row.lenient)),
            judge("one-to-one", &|row| mm(&row.one_to_one)),
            judge("GOSPA", &|row| Some(row.gospa_mm)),
        ],
    }
}

/// Table 2's own numbers for the chain.
fn accuracy(of: &Made<'_>) -> Claim {
    let single = &of.scores.single.hapdefx;
    let double = of.scores.double.as_ref().map(|d| &d.lenient_spread);
    let judge =
        |metric: &str, unit: &str, value: fn(&ContactStats) -> Option<f64>, paper: [f64; 2]| {
            let checks = [("single", Some(single), paper[0]), ("double", double, paper[1])];
            let checks = checks.map(|(place, ours, paper)| {
                Check::at_most(place, ("ours", ours.and_then(value)), ("paper", Some(paper)))
            });
            MetricVerdict::of(metric, unit, &checks)
        };
    Claim {
        id: "table2_accuracy",
        text: "the chain's accuracy on one and on two contacts (lenient, T + 1) is the paper's or better",
        paper: "5 mm, 3 N; 10 mm, 6 N",
        verdicts: vec![
            judge("position", "mm", mm, [5.0, 10.0]),
            judge("force", "N", newton, [3.0, 6.0]),
        ],
    }
}

/// FVU of the map from readings; the paper prints whole per cent.
fn map(of: &Made<'_>) -> Claim {
    let double = of.scores.double.as_ref().map(|d| d.map);
    let check = |name: &str, ours: Option<MapError>, paper: f64| {
        let paper = paper * 100.0 + 0.5;
        let ours = ours.map(|map| map.fvu * 100.0);
        Check::at_most(name, ("ours", ours), ("paper, rounded up", Some(paper)))
    };
    let checks = [
        check("single", Some(of.scores.single.map), PAPER_FVU_SINGLE),
        check("double", double, PAPER_FVU_DOUBLE),
    ];
    Claim {
        id: "map_fvu",
        text: "the map from readings leaves no more variance unexplained than the paper's",
        paper: "4 % single, 29 % double",
        verdicts: vec![MetricVerdict::of("FVU", "%", &checks)],
    }
}

/// Figure 8B: from the weakest to the strongest bin of forces.
fn force_error_grows(of: &Made<'_>) -> Claim {
    let bins = of.singles.by_force(&of.singles.ablations[0], of.strongest_n());
    let ends = bins.first().zip(bins.last());
    let check = Check::below(
        "",
        ("weakest presses", ends.map(|(weak, _)| weak.force_error_n)),
        ("strongest presses", ends.map(|(_, strong)| strong.force_error_n)),
    );
    Claim {
        id: "force_error_grows",
        text: "single contacts: the chain's force error grows with the force",
        paper: "figure 8B",
        verdicts: vec![MetricVerdict::of("force", "N", &[check])],
    }
}

/// Of each double press with spurious candidates: the strongest spurious one against the weaker of
/// the two that lie nearest to the true contacts.
fn spurious_are_weak(of: &Made<'_>) -> Claim {
    let (mut n_weak, mut n_spurious) = (0_u32, 0_u32);
    for frame in of.frames.rig_double.iter().filter(|frame| frame.found.len() > frame.truth.len()) {
        let found = hapdef::scored(&frame.found);
        let Ok(matched) = hapdef::score_one_to_one(&found, &frame.truth) else {
            continue;
        };
        let real = matched.pairs.iter().map(|pair| found[pair.detected].1);
        let spurious = matched.spurious.iter().map(|i| found[*i].1);
        n_spurious += 1;
        let weakest = real.fold(f64::INFINITY, f64::min);
        n_weak += u32::from(spurious.fold(f64::NEG_INFINITY, f64::max) < weakest);
    }
    let share = (n_spurious > 0).then(|| 100.0 * f64::from(n_weak) / f64::from(n_spurious));
    let check = Check::below("", ("half", Some(50.0)), ("presses in which all are weaker", share));
    Claim {
        id: "spurious_are_weak",
        text: "two contacts: spurious candidates are weaker than the real ones, in most presses",
        paper: "figure 9A: typically by far the lowest magnitudes",
        verdicts: vec![MetricVerdict::of("force", "%", &[check])],
    }
}

/// Whether 24 virtual gauges give the least error on two contacts with F_T a net.
fn best_size(points: &[SizePoint]) -> Claim {
    let judge = |metric: MapMetric| {
        let double = |point: &SizePoint| metric.of(&point.errors[2][1]);
        let paper = points.iter().find(|point| point.size == PAPER_SIZE).map(double);
        let rivals = points.iter().filter(|point| point.size != PAPER_SIZE);
        let best = rivals.min_by(|a, b| double(a).total_cmp(&double(b)));
        let name = best.map_or(String::new(), |b| format!("best of the others, {}:", b.size));
        let check = Check::below("", ("24 gauges:", paper), (&name, best.map(double)));
        MetricVerdict::of(metric.name(), metric.unit(), &[check])
    };
    Claim {
        id: "optimum_24",
        text: "24 virtual gauges around each gauge give the best map of two contacts (F_T a net)",
        paper: "figure 5A",
        verdicts: MapMetric::ALL.map(judge).to_vec(),
    }
}

/// Claims made, and those that hold by every metric.
pub(crate) fn count(claims: &[Claim]) -> (usize, usize) {
    let n_held = claims.iter().filter(|claim| claim.fate() == Fate::Holds).count();
    (claims.len(), n_held)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(doubles_um: &[(usize, f64)]) -> Vec<SizePoint> {
        let error = |um: f64| MapError { mean_abs_um: um, rms_um: 2.0 * um, fvu: 0.01 * um };
        let point = |&(size, um): &(usize, f64)| SizePoint {
            size,
            errors: [[error(1.0); 2], [error(1.0); 2], [error(1.0), error(um)]],
        };
        doubles_um.iter().map(point).collect()
    }

    #[test]
    fn the_best_size_is_that_of_the_net_on_two_contacts() {
        let best = best_size(&points(&[(1, 9.0), (24, 5.0), (60, 7.0)]));
        assert_eq!(best.fate(), Fate::Holds);
        let reason = &best.verdicts[0].reason;
        assert_eq!(reason, "24 gauges: 5.0, best of the others, 60: 7.0 µm");
        let other = best_size(&points(&[(1, 4.0), (24, 5.0), (60, 7.0)]));
        assert_eq!(other.fate(), Fate::Fails);
        assert_eq!(best_size(&points(&[(1, 4.0)])).fate(), Fate::NotMeasured);
    }
}
