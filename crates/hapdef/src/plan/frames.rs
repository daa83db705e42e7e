//! Frames on which finding contacts is timed.

use std::time::Instant;

use hapdef_inverse::{
    ContactEstimate, ContactEstimator, ContactTracker, InverseError, Press, ResponseMap, ScanSites,
    SkinPoint, TrackerParams,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Least distance of two contacts, m, and force of each, N.
const MIN_GAP_M: f64 = 0.012;
const FORCE_N: f64 = 20.0;

/// Frames that are timed: untouched, of one contact, of two.
pub(super) const N_FRAMES: [usize; 3] = [2000, 60, 60];

/// Frames in which a contact is followed before they are timed, and that are.
const N_FOLLOWED: usize = 400;

/// A frame, and where its contacts are.
pub(super) struct DrawnFrame {
    pub(super) points: Vec<SkinPoint>,
    /// `[n_gauges]`, µε.
    pub(super) readings_ue: Vec<f64>,
}

/// Draws frames of a response map, at scan sites.
pub(super) struct FrameDraws<'a> {
    pub(super) map: &'a ResponseMap,
    pub(super) sites: &'a ScanSites,
    /// Standard deviation of a reading's noise, µε.
    pub(super) noise_ue: f64,
    rng: ChaCha8Rng,
}

/// A frame that was searched, or the mean over some.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Searched {
    pub(super) seconds: f64,
    /// The most contacts that were searched for.
    pub(super) most_contacts: usize,
}

impl<'a> FrameDraws<'a> {
    pub(super) fn new(map: &'a ResponseMap, sites: &'a ScanSites, noise_ue: f64) -> Self {
        Self { map, sites, noise_ue, rng: ChaCha8Rng::seed_from_u64(1) }
    }

    /// `n` frames of `n_contacts` each; those of none have no noise either, which the estimator
    /// searches once in a thousand frames.
    pub(super) fn frames(&mut self, n_contacts: usize, n: usize) -> Vec<DrawnFrame> {
        (0..n).map(|_| self.frame(n_contacts)).collect()
    }

    /// Presses for a calibration: single contacts.
    pub(super) fn presses(&mut self, n: usize) -> Vec<Press> {
        let press = |frame: DrawnFrame| Press {
            point: frame.points[0],
            force_n: FORCE_N,
            readings: frame.readings_ue,
        };
        self.frames(1, n).into_iter().map(press).collect()
    }

    fn frame(&mut self, n_contacts: usize) -> DrawnFrame {
        let (map, sites) = (self.map, self.sites);
        let mut points: Vec<SkinPoint> = Vec::new();
        while points.len() < n_contacts {
            let site = self.rng.random_range(0..sites.len());
            let x = sites.positions()[site];
            let is_apart = |p: &SkinPoint| (map.skin().position(p) - x).norm() >= MIN_GAP_M;
            if points.iter().all(is_apart) {
                points.push(sites.points()[site]);
            }
        }
        let sd_ue = if n_contacts == 0 { 0.0 } else { self.noise_ue };
        let noise = (0..map.n_gauges()).map(|_| sd_ue * self.unit_noise());
        let mut readings_ue: Vec<f64> = noise.collect();
        for point in &points {
            let each = readings_ue.iter_mut().zip(map.normal(point));
            each.for_each(|(sum, g)| *sum += FORCE_N * g);
        }
        DrawnFrame { points, readings_ue }
    }

    fn unit_noise(&mut self) -> f64 {
        StandardNormal.sample(&mut self.rng)
    }
}

/// Frames on their own.
pub(super) fn searched(
    estimator: &ContactEstimator,
    frames: &[DrawnFrame],
) -> Result<Vec<Searched>, InverseError> {
    let (mut scratch, mut estimate) = (estimator.scratch(), ContactEstimate::default());
    estimator.estimate_into(&frames[0].readings_ue, &mut scratch, &mut estimate)?;
    let mut search = |frame: &DrawnFrame| {
        let start = Instant::now();
        estimator.estimate_into(&frame.readings_ue, &mut scratch, &mut estimate)?;
        Ok(Searched {
            seconds: start.elapsed().as_secs_f64(),
            most_contacts: estimate.info.most_contacts,
        })
    };
    frames.iter().map(&mut search).collect()
}

impl Searched {
    /// The mean over frames that were searched for exactly `n_contacts`; one that goes on to more is
    /// another step of the plan. Over all, where there is none.
    pub(super) fn mean_of(frames: &[Self], n_contacts: usize) -> Self {
        let is_so = |frame: &&Self| frame.most_contacts == n_contacts;
        match frames.iter().any(|frame| is_so(&frame)) {
            true => Self::mean(frames.iter().filter(is_so)),
            false => Self::mean(frames.iter()),
        }
    }

    /// The mean over frames; the most contacts of any.
    pub(super) fn mean<'a>(frames: impl Iterator<Item = &'a Self> + Clone) -> Self {
        let n = frames.clone().count().max(1) as f64;
        frames.fold(Self::default(), |sum, frame| Self {
            seconds: sum.seconds + frame.seconds / n,
            most_contacts: sum.most_contacts.max(frame.most_contacts),
        })
    }
}

/// Time of a frame in which one contact is followed, s, the same frame again and again.
pub(super) fn followed_s(
    estimator: &ContactEstimator,
    frame: &DrawnFrame,
) -> Result<f64, InverseError> {
    let mut tracker = ContactTracker::new(estimator, TrackerParams::default())?;
    let mut follow = || {
        let start = Instant::now();
        for _ in 0..N_FOLLOWED {
            tracker.step(&frame.readings_ue, None)?;
        }
        Ok::<_, InverseError>(start.elapsed().as_secs_f64() / N_FOLLOWED as f64)
    };
    follow()?;
    follow()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_that_goes_on_to_more_contacts_is_no_part_of_the_mean() {
        let frame = |seconds, most_contacts| Searched { seconds, most_contacts };
        let frames = [frame(1.0, 1), frame(30.0, 2), frame(3.0, 1)];
        let single = Searched::mean_of(&frames, 1);
        assert_eq!(single.seconds, 2.0);
        let pair = Searched::mean_of(&frames, 2);
        assert_eq!(pair.seconds, 30.0);
        let none_ended_so = Searched::mean_of(&frames[..1], 2);
        assert_eq!(none_ended_so.seconds, 1.0);
    }
}
