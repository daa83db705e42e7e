//! How well contacts are found in presses of known places and forces.

use std::time::Instant;

use hapdef_bench::stats::median;
use hapdef_live::Touch;
use hapdef_live::estimator::TouchEstimator;
use serde::Serialize;

use super::probing::ProbedPress;
use crate::error::HapdefError;
use crate::scoring::{ContactPair, MAX_ONE_TO_ONE, OneToOne, ScoredContact, score_one_to_one};
use crate::stats::{ContactStats, FAR_M};

/// Errors of presses of one number of contacts. The strongest contacts found, as many as there are, are
/// paired with the true ones.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TouchScore {
    /// Contacts of each press.
    pub n_contacts: usize,
    /// Presses.
    pub n_presses: usize,
    /// Errors of the contacts that were found.
    pub errors: ContactStats,
    /// Median distance of all true contacts, mm, where one that is not found is infinitely far.
    pub median_mm: f64,
    /// Share of true contacts that are found within 10 mm.
    pub share_within_10mm: f64,
    /// Share of presses of which the number of contacts is right.
    pub share_count_right: f64,
    /// Median time of a press's last frame, ms.
    pub median_ms: f64,
    /// The press whose contacts were found about as far off as is usual: true and found.
    #[serde(skip)]
    pub typical: [Vec<ScoredContact>; 2],
}

impl TouchScore {
    /// Looks for the contacts of the last frame of each press with an estimator of its own.
    ///
    /// # Errors
    /// What `estimator` returns, [`HapdefError::Live`] when the readings don't fit it,
    /// [`HapdefError::Scoring`] when a press has more contacts than are paired.
    pub fn of<E: TouchEstimator>(
        presses: &[ProbedPress],
        mut estimator: impl FnMut() -> Result<E, HapdefError>,
    ) -> Result<Self, HapdefError> {
        let mut frames = Vec::with_capacity(presses.len());
        for press in presses {
            frames.push(Found::of(&mut estimator()?, press)?);
        }
        let pairs: Vec<ContactPair> =
            frames.iter().flat_map(|frame| frame.matched.pairs.iter().copied()).collect();
        let n_missed: usize = frames.iter().map(|frame| frame.matched.missed.len()).sum();
        let n_true = pairs.len() + n_missed;
        let n_near = pairs.iter().filter(|pair| pair.position_error_m <= FAR_M).count();
        let n_right = frames.iter().filter(|frame| frame.is_count_right).count();
        let errors_mm = pairs.iter().map(|pair| pair.position_error_m * 1e3);
        let lost_mm = std::iter::repeat_n(f64::INFINITY, n_missed);
        let median_mm = median(errors_mm.chain(lost_mm));
        let share = |n: usize, of: usize| n as f64 / of.max(1) as f64;
        Ok(Self {
            n_contacts: presses.first().map_or(0, |press| press.contacts.len()),
            n_presses: presses.len(),
            errors: ContactStats::of(&pairs, n_true),
            median_mm,
            share_within_10mm: share(n_near, n_true),
            share_count_right: share(n_right, presses.len()),
            median_ms: median(frames.iter().map(|frame| frame.time_ms)),
            typical: typical(presses, frames, median_mm),
        })
    }
}

/// What was found in a press.
struct Found {
    contacts: Vec<ScoredContact>,
    matched: OneToOne,
    is_count_right: bool,
    time_ms: f64,
}

impl Found {
    fn of(estimator: &mut impl TouchEstimator, press: &ProbedPress) -> Result<Self, HapdefError> {
        let mut touch = Touch::default();
        let mut time_ms = 0.0;
        for readings_ue in &press.frames_ue {
            let start = Instant::now();
            estimator.estimate(readings_ue, &mut touch)?;
            time_ms = start.elapsed().as_secs_f64() * 1e3;
        }
        let found = touch.contacts.iter().map(|c| (c.position_m.coords.into(), c.force_n));
        let mut contacts: Vec<ScoredContact> = found.collect();
        contacts.sort_by(|a, b| b.1.total_cmp(&a.1));
        let is_count_right = contacts.len() == press.contacts.len();
        contacts.truncate(press.contacts.len().min(MAX_ONE_TO_ONE));
        let matched = score_one_to_one(&contacts, &press.contacts)?;
        Ok(Self { contacts, matched, is_count_right, time_ms })
    }

    /// Mean distance of its contacts, mm; none where one is missed.
    fn mean_mm(&self) -> Option<f64> {
        let pairs = &self.matched.pairs;
        let sum_m: f64 = pairs.iter().map(|pair| pair.position_error_m).sum();
        (self.is_count_right && !pairs.is_empty()).then(|| sum_m * 1e3 / pairs.len() as f64)
    }
}

fn typical(presses: &[ProbedPress], frames: Vec<Found>, usual_mm: f64) -> [Vec<ScoredContact>; 2] {
    let off = |frame: &Found| frame.mean_mm().map(|mm| (mm - usual_mm).abs());
    let all = presses.iter().zip(frames).filter_map(|(press, frame)| {
        off(&frame).map(|off_mm| (off_mm, [press.contacts.clone(), frame.contacts]))
    });
    all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, contacts)| contacts).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use hapdef_live::estimator::TouchFrame;
    use hapdef_live::{Contact, LiveError};
    use nalgebra::Point3;

    use super::*;

    /// Finds a contact of 5 N at the place that the readings are, and none where they are negative.
    struct Echo;

    impl TouchEstimator for Echo {
        fn name(&self) -> &'static str {
            "echo"
        }

        fn n_gauges(&self) -> usize {
            3
        }

        fn estimate_frame(
            &mut self,
            frame: &TouchFrame<'_>,
            touch: &mut Touch,
        ) -> Result<(), LiveError> {
            let at = frame.readings_ue;
            let contact = Contact::new(Point3::new(at[0], at[1], at[2]), 5.0);
            touch.contacts = if at[0] < 0.0 { Vec::new() } else { vec![contact] };
            Ok(())
        }
    }

    #[test]
    fn what_is_missed_is_infinitely_far() {
        let press = |found_x_m: f64| ProbedPress {
            contacts: vec![([0.1, 0.0, 0.0], 4.0)],
            frames_ue: vec![vec![found_x_m, 0.0, 0.0]],
        };
        let presses = [press(0.101), press(0.103), press(0.12), press(-1.0), press(-1.0)];
        let score = TouchScore::of(&presses, || Ok(Echo)).unwrap();
        assert!((score.median_mm - 20.0).abs() < 1e-9, "{score:?}");
        assert_eq!((score.share_within_10mm, score.share_count_right), (0.4, 0.6));
        assert!((score.errors.mean_mm - 8.0).abs() < 1e-9 && score.errors.n_expected == 5);
        let [truth, found] = score.typical;
        assert_eq!((truth[0].0[0], found[0].0[0]), (0.1, 0.12));
    }
}
