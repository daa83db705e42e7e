//! Errors of many frames in one row.

use anyhow::Result;
use hapdef::{ContactPair, FAR_M, MAX_ONE_TO_ONE, ScoredContact, gospa, score_one_to_one};
use hapdef_bench::Named;
use hapdef_bench::stats::{mean, quantile, sorted};
use hapdef_inverse::{CHI2_95, ContactEstimate, Skin, Verdict};
use serde::{Deserialize, Serialize};

use super::world::Frame;
use crate::run::scores::GOSPA;

/// Points of a row's curve.
const N_CURVE: usize = 100;

/// Frames of a row, matched one to one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Score {
    pairs: Vec<ContactPair>,
    n_true: usize,
    n_missed: usize,
    n_spurious: usize,
    n_frames: usize,
    n_count_right: usize,
    n_unsure: usize,
    n_clean: usize,
    /// Sum of the frames' GOSPA, m.
    gospa_m: f64,
    /// Of the contacts whose covariance was reported: those, and those inside their 95 % region.
    n_regions: usize,
    n_inside: usize,
    times_us: Vec<f64>,
}

/// A row in numbers.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Row {
    pub(crate) name: String,
    #[serde(flatten)]
    pub(crate) errors: Errors,
    /// Frames that the estimator says it can't decide, %.
    pub(crate) unsure_pct: f64,
    /// Matched contacts inside their 95 % region, %, where regions are reported.
    pub(crate) coverage95_pct: Option<f64>,
    pub(crate) p50_us: f64,
    pub(crate) p99_us: f64,
    /// Share of the true contacts, %, and how far from its match the last of them is, mm.
    #[serde(skip)]
    pub(crate) within_mm: Vec<(f64, f64)>,
}

/// Errors of frames. Position and force errors are those of matched contacts; GOSPA minds the others, too.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Errors {
    pub(crate) n_frames: usize,
    /// Sum of the frames' GOSPA with [`GOSPA`] over the number of true contacts, mm: the mean position
    /// error where a missed or spurious contact costs 10 mm.
    pub(crate) gospa_mm: f64,
    pub(crate) mean_mm: f64,
    pub(crate) median_mm: f64,
    pub(crate) p90_mm: f64,
    /// True contacts that have a match within 10 mm, %.
    pub(crate) within10_pct: f64,
    pub(crate) mean_n: f64,
    /// True contacts without a match, %.
    pub(crate) missed_pct: f64,
    /// Contacts without a true one, per 100 frames.
    pub(crate) spurious_pct: f64,
    /// Frames whose contacts are all within 10 mm and no other is reported, %.
    pub(crate) clean_pct: f64,
    /// Frames whose number of contacts is right, %.
    pub(crate) count_pct: f64,
    /// Mean error of the displacement of the whole skin, µm, where that is looked at.
    pub(crate) map_um: Option<f64>,
}

impl Named for Row {
    fn name(&self) -> &str {
        &self.name
    }
}

impl Score {
    /// Adds a frame and what was found in it.
    pub(crate) fn add(
        &mut self,
        skin: &Skin,
        frame: &Frame,
        found: &[ScoredContact],
        time_us: f64,
    ) -> Result<Vec<ContactPair>> {
        let truth: Vec<ScoredContact> = frame
            .contacts
            .iter()
            .map(|c| (skin.position(&c.point).coords.into(), c.force_n))
            .collect();
        let kept = &found[..found.len().min(MAX_ONE_TO_ONE)];
        let matched = score_one_to_one(kept, &truth)?;
        let beyond_kept_m = (found.len() - kept.len()) as f64 * GOSPA.cutoff_m / 2.0;
        self.gospa_m += gospa(kept, &truth, &GOSPA)?.total_m + beyond_kept_m;
        self.n_frames += 1;
        self.n_true += truth.len();
        self.n_missed += matched.missed.len();
        self.n_spurious += matched.spurious.len() + found.len() - kept.len();
        self.n_count_right += usize::from(found.len() == truth.len());
        self.n_clean += usize::from(matched.is_within(FAR_M) && kept.len() == found.len());
        self.times_us.push(time_us);
        self.pairs.extend(&matched.pairs);
        Ok(matched.pairs)
    }

    /// Adds a frame with an estimate by superposition.
    pub(crate) fn add_estimate(
        &mut self,
        skin: &Skin,
        frame: &Frame,
        estimate: &ContactEstimate,
        time_us: f64,
    ) -> Result<Vec<ContactPair>> {
        let found: Vec<ScoredContact> =
            estimate.contacts.iter().map(|c| (c.position_m.coords.into(), c.force_n)).collect();
        let pairs = self.add(skin, frame, &found, time_us)?;
        let is_sure = !matches!(estimate.verdict, Verdict::NotIdentifiable(_));
        self.n_unsure += usize::from(!is_sure);
        let is_right = found.len() == frame.contacts.len();
        for pair in pairs.iter().filter(|_| is_sure && is_right) {
            let truth = skin.position(&frame.contacts[pair.truth].point);
            let distance2 = estimate.contacts[pair.detected].distance_2(skin, &truth, 0.0);
            self.n_regions += 1;
            self.n_inside += usize::from(distance2.is_some_and(|d| d <= CHI2_95));
        }
        Ok(pairs)
    }

    /// The row's numbers.
    pub(crate) fn row(&self, name: &str) -> Row {
        let mm: Vec<f64> = sorted(self.pairs.iter().map(|p| p.position_error_m * 1e3));
        let near = self.pairs.iter().filter(|p| p.position_error_m <= FAR_M);
        let times = sorted(self.times_us.iter().copied());
        let share = |n: usize, of: usize| n as f64 / of.max(1) as f64 * 100.0;
        Row {
            name: name.into(),
            errors: Errors {
                n_frames: self.n_frames,
                gospa_mm: self.gospa_m * 1e3 / self.n_true.max(1) as f64,
                mean_mm: mean(mm.iter().copied()),
                median_mm: quantile(&mm, 0.5),
                p90_mm: quantile(&mm, 0.9),
                within10_pct: share(near.count(), self.n_true),
                mean_n: mean(self.pairs.iter().map(|p| p.force_error_n.abs())),
                missed_pct: share(self.n_missed, self.n_true),
                spurious_pct: share(self.n_spurious, self.n_frames),
                count_pct: share(self.n_count_right, self.n_frames),
                clean_pct: share(self.n_clean, self.n_frames),
                map_um: None,
            },
            unsure_pct: share(self.n_unsure, self.n_frames),
            coverage95_pct: (self.n_regions > 0).then(|| share(self.n_inside, self.n_regions)),
            p50_us: quantile(&times, 0.5),
            p99_us: quantile(&times, 0.99),
            within_mm: (1..=N_CURVE)
                .map(|k| (k * mm.len()).div_ceil(N_CURVE))
                .filter_map(|n| Some((share(n, self.n_true), *mm.get(n.checked_sub(1)?)?)))
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::world::tests::on_a_triangle;
    use super::*;

    /// Two true contacts 60 mm apart; one is found 2 mm off, the other not, and one is made up.
    #[test]
    fn gospa_counts_what_the_mean_of_matched_contacts_leaves_out() {
        let (skin, contacts) = on_a_triangle(&[[0.01, 0.01], [0.07, 0.01]]);
        let frame = Frame { contacts, readings_ue: Vec::new() };
        let row = |found: &[ScoredContact]| {
            let mut score = Score::default();
            score.add(&skin, &frame, found, 1.0).unwrap();
            score.row("").errors
        };
        let near = ([0.012, 0.01, 0.0], 10.0);
        let one = row(&[near]);
        assert!((one.mean_mm - 2.0).abs() < 1e-9, "{one:?}");
        assert!((one.gospa_mm - (2.0 + 10.0) / 2.0).abs() < 1e-9, "{one:?}");
        assert_eq!((one.missed_pct, one.clean_pct), (50.0, 0.0));
        let with_other = row(&[near, ([0.072, 0.01, 0.0], 9.0), ([0.0, 0.09, 0.0], 1.0)]);
        assert!((with_other.gospa_mm - (2.0 + 2.0 + 10.0) / 2.0).abs() < 1e-9);
        assert_eq!((with_other.missed_pct, with_other.spurious_pct), (0.0, 100.0));
        let far = row(&[near, ([0.0, 0.09, 0.0], 9.0)]);
        assert!((far.gospa_mm - (2.0 + 20.0) / 2.0).abs() < 1e-9, "{far:?}");
    }
}
