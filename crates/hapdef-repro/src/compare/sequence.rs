//! Contacts that arrive one after another, followed at 1 kHz.

use std::time::Instant;

use anyhow::Result;
use hapdef::ScoredContact;
use hapdef_inverse::{
    ContactEstimator, ContactTracker, EstimatorScratch, SearchOutcome, TrackerParams,
};
use rand::RngExt;

use super::score::Score;
use super::world::{Draw, Frame, TrueContact, World};

/// Frames from one arrival to the next, and of each rise of the force.
const BETWEEN: usize = 200;
const RISE: usize = 40;

/// Frames that a full search is given before it is adopted.
const SEARCH_FRAMES: u64 = 30;

/// Contacts in the order in which they come.
pub(crate) struct Script {
    pub(crate) contacts: Vec<TrueContact>,
}

/// What following many scripts gave.
#[derive(Default)]
pub(crate) struct Followed {
    /// The frames before each further arrival and the last frame, by number of contacts.
    pub(crate) score: Score,
    /// Time of every frame, µs.
    pub(crate) times_us: Vec<f64>,
    /// Full searches that were wanted.
    pub(crate) n_searches: usize,
}

impl Script {
    /// `k` contacts of 5 N to the scene's strongest, at least `gap_m` apart.
    pub(crate) fn draw(draw: &mut Draw<'_>, k: usize, gap_m: f64, strongest_n: f64) -> Self {
        let places = draw.places(k, [gap_m, f64::MAX]);
        let contact = |place| {
            let force_n = draw.rng.random_range(5.0..=strongest_n);
            draw.contact(place, force_n, 0.0)
        };
        Self {
            contacts: places.into_iter().map(contact).collect(),
        }
    }

    /// The script with its first `n` contacts, and its frames before the next arrives.
    pub(crate) fn first(&self, n: usize) -> (Self, usize) {
        let contacts = self.contacts[..n].to_vec();
        (Self { contacts }, BETWEEN * n + BETWEEN / 2)
    }

    /// First frame in which `n` contacts press.
    pub(crate) fn first_frame_of(n: usize) -> usize {
        BETWEEN / 2 + (n - 1) * BETWEEN + 1
    }

    pub(crate) fn n_frames(&self) -> usize {
        BETWEEN * (self.contacts.len() + 1)
    }

    /// Force of each contact in `frame`, N.
    pub(crate) fn forces_n(&self, frame: usize) -> Vec<f64> {
        let rise = |(i, contact): (usize, &TrueContact)| {
            let since = frame.saturating_sub(BETWEEN / 2 + i * BETWEEN) as f64;
            contact.force_n * (since / RISE as f64).min(1.0)
        };
        self.contacts.iter().enumerate().map(rise).collect()
    }

    /// Readings of every frame `[n_frames][n_channels]`, µε.
    pub(crate) fn readings(&self, world: &World, stream: u64) -> Result<Vec<Vec<f64>>> {
        let units: Result<Vec<Vec<f64>>> = self
            .contacts
            .iter()
            .map(|c| world.unit_strains(c))
            .collect();
        let units = units?;
        let mut electronics = world.electronics(stream)?;
        let frames = (0..self.n_frames()).map(|frame| {
            let forces = self.forces_n(frame);
            let mut sum = vec![0.0; units[0].len()];
            for (force_n, unit) in forces.iter().zip(&units) {
                for (sum, unit) in sum.iter_mut().zip(unit) {
                    *sum += force_n * unit;
                }
            }
            electronics.measure(&mut sum);
            sum
        });
        Ok(frames.collect())
    }
}

impl Followed {
    /// Follows one script; the readings' first channels are the estimator's gauges.
    pub(crate) fn follow(
        &mut self,
        estimator: &ContactEstimator,
        scratch: &mut EstimatorScratch,
        script: &Script,
        readings: &[Vec<f64>],
    ) -> Result<()> {
        let skin = estimator.map().skin();
        let n_gauges = estimator.map().n_gauges();
        let mut tracker = ContactTracker::new(estimator, TrackerParams::default())?;
        let mut pending: Option<SearchOutcome> = None;
        for (index, frame) in readings.iter().enumerate() {
            let due = |o: &mut SearchOutcome| index as u64 >= o.frame + SEARCH_FRAMES;
            let ready = pending.take_if(due);
            let start = Instant::now();
            if let Some(outcome) = &ready {
                tracker.adopt(outcome);
            }
            tracker.step(&frame[..n_gauges], None)?;
            self.times_us.push(start.elapsed().as_secs_f64() * 1e6);
            if let Some(request) = tracker.wanted_search() {
                let mut outcome = SearchOutcome::default();
                request.run(estimator, scratch, &mut outcome)?;
                pending = Some(outcome);
                self.n_searches += 1;
            }
        }
        let last = Frame {
            contacts: script.contacts.clone(),
            readings_ue: Vec::new(),
        };
        let contacts = &tracker.last().contacts;
        let found: Vec<ScoredContact> = contacts
            .iter()
            .map(|c| (c.contact.position_m.coords.into(), c.contact.force_n))
            .collect();
        let time_us = self.times_us.last().copied().unwrap_or(0.0);
        self.score.add(skin, &last, &found, time_us)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use hapdef_inverse::{Skin, SkinFaces, SkinParams, SkinPoint};
    use nalgebra::{Point3, Vector3};

    use super::*;

    #[test]
    fn so_many_contacts_press_from_the_frame_that_is_told_to_the_end() {
        let corners = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]].map(Point3::from);
        let faces = SkinFaces::Linear(&[[0, 1, 2]]);
        let skin = Skin::new(corners.to_vec(), faces, None, &SkinParams::default()).unwrap();
        let contact = TrueContact {
            point: SkinPoint::new(&skin, 0, [1.0 / 3.0; 3]).unwrap(),
            force_n: 10.0,
            friction: Vector3::zeros(),
        };
        let whole = Script {
            contacts: vec![contact; 3],
        };
        for n in 1..=3 {
            let (script, n_frames) = whole.first(n);
            let pressing = |frame| script.forces_n(frame).iter().filter(|f| **f > 0.0).count();
            let first = Script::first_frame_of(n);
            assert_eq!((pressing(first - 1), pressing(first)), (n - 1, n));
            assert!((first..n_frames).all(|frame| pressing(frame) == n));
        }
    }
}
