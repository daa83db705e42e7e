//! Plays a scene to the tracker.

use std::time::Instant;

use anyhow::Result;
use hapdef_inverse::{ContactEstimator, ContactTracker, ScanSites, SearchOutcome, TrackerParams};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::limb_error::LimbError;
use crate::row::Row;
use crate::script::{Kind, Script};

/// Frames that a full search takes.
const SEARCH_FRAMES: u64 = 30;

/// Times that each scene is played for its times: the least counts, other programs share the machine.
const N_PLAYS: usize = 5;

pub(crate) struct Bench<'a> {
    pub(crate) estimator: &'a ContactEstimator,
    pub(crate) sites: &'a ScanSites,
    pub(crate) sd: f64,
    pub(crate) relative: f64,
}

impl Bench<'_> {
    pub(crate) fn play(&self, kind: Kind, seed: u64, row: &mut Row) -> Result<()> {
        let map = self.estimator.map();
        let script = Script::draw(kind, map.skin(), seed);
        let frames = self.frames(&script, seed);
        let mut times_us = vec![f64::INFINITY; frames.len()];
        for play in 0..N_PLAYS {
            let mut tracker = ContactTracker::new(self.estimator, TrackerParams::default())?;
            let mut scratch = self.estimator.scratch();
            let mut pending: Option<SearchOutcome> = None;
            for (index, readings) in frames.iter().enumerate() {
                let due = |o: &mut SearchOutcome| index as u64 >= o.frame + SEARCH_FRAMES;
                let start = Instant::now();
                if let Some(outcome) = pending.take_if(due) {
                    tracker.adopt(&outcome);
                }
                tracker.step(readings, None)?;
                let time_us = start.elapsed().as_secs_f64() * 1e6;
                times_us[index] = times_us[index].min(time_us);
                if let Some(request) = tracker.wanted_search() {
                    let mut outcome = SearchOutcome::default();
                    request.run(self.estimator, &mut scratch, &mut outcome)?;
                    pending = Some(outcome);
                    row.n_searches += usize::from(play == 0);
                }
                if play == 0 {
                    row.frame(map.skin(), &script, index, tracker.last())?;
                }
            }
        }
        row.end(&times_us);
        Ok(())
    }

    fn frames(&self, script: &Script, seed: u64) -> Vec<Vec<f64>> {
        let map = self.estimator.map();
        let points = self.sites.points();
        let limb = LimbError::draw(map, points, self.relative, seed ^ 0x5eed);
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xf00d);
        let mut held: Vec<_> = script
            .presses
            .iter()
            .map(|press| (press.point, limb.response(map, &press.point)))
            .collect();
        let mut frames = Vec::with_capacity(script.n_frames);
        for frame in 0..script.n_frames {
            let mut y = vec![0.0; map.n_gauges()];
            for (press, (at, response)) in script.presses.iter().zip(&mut held) {
                let force_n = press.force_n(frame);
                if force_n == 0.0 {
                    continue;
                }
                let point = press.point(map.skin(), frame);
                if point != *at {
                    (*at, *response) = (point, limb.response(map, &point));
                }
                for (y, g) in y.iter_mut().zip(response.iter()) {
                    *y += force_n * g;
                }
            }
            for y in &mut y {
                let n: f64 = StandardNormal.sample(&mut rng);
                *y += self.sd * n;
            }
            frames.push(y);
        }
        frames
    }
}
