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

/// Means over frames that were searched.
#[derive(Clone, Copy, Debug)]
pub(super) struct Searched {
    pub(super) seconds: f64,
    /// Steps of refinement.
    pub(super) steps: f64,
}

impl<'a> FrameDraws<'a> {
    pub(super) fn new(map: &'a ResponseMap, sites: &'a ScanSites, noise_ue: f64) -> Self {
        Self {
            map,
            sites,
            noise_ue,
            rng: ChaCha8Rng::seed_from_u64(1),
        }
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
        DrawnFrame {
            points,
            readings_ue,
        }
    }

    fn unit_noise(&mut self) -> f64 {
        StandardNormal.sample(&mut self.rng)
    }
}

/// Frames on their own.
pub(super) fn searched(
    estimator: &ContactEstimator,
    frames: &[DrawnFrame],
) -> Result<Searched, InverseError> {
    let (mut scratch, mut estimate) = (estimator.scratch(), ContactEstimate::default());
    let mut n_steps = 0;
    estimator.estimate_into(&frames[0].readings_ue, &mut scratch, &mut estimate)?;
    let start = Instant::now();
    for frame in frames {
        estimator.estimate_into(&frame.readings_ue, &mut scratch, &mut estimate)?;
        n_steps += estimate.info.n_steps;
    }
    let n = frames.len() as f64;
    Ok(Searched {
        seconds: start.elapsed().as_secs_f64() / n,
        steps: n_steps as f64 / n,
    })
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
