//! What leaving out what a scene does not want is worth: single contacts alone, against everything.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use hapdef::stages::compliance_table;
use hapdef::touch::{response_map, superposition};
use hapdef::{Limb, Run};
use hapdef_bench::stats::median;
use hapdef_inverse::{
    ContactEstimate, ContactEstimator, ContactTracker, LocatedContact, TrackerParams,
};
use serde::Serialize;

use super::configuration::Configuration;
use super::lab::{Lab, found_um};
use super::made_anew;
use crate::compare::cells::estimate_us;
use crate::compare::sequence::Script;
use crate::compare::world::Frame;

/// Contacts nearer than this, and forces nearer than this share, are equal, m.
const EQUAL_M: f64 = 1e-9;
const EQUAL_SHARE: f64 = 1e-9;

/// Rounds in which frames are timed, and designs.
const ROUNDS: usize = 5;
const DESIGN_ROUNDS: usize = 3;

/// A scene that wants everything, and one that wants single contacts alone, on the same frames of
/// one contact.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Skips {
    /// Most contacts of the scene that wants everything.
    pub(super) max_contacts: usize,
    /// Median time of response, estimator, and the displacement of the whole skin under a load on each
    /// of its nodes, s.
    pub(super) full_design_s: f64,
    /// Median time of response and estimator, s.
    pub(super) lean_design_s: f64,
    /// Frames of which nothing is known before.
    pub(super) searched: Compared,
    /// Frames of a contact that is followed from the one before, as in live use.
    pub(super) followed: Compared,
}

/// Both on the same frames.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Compared {
    /// Median of a frame: up to the scene's number of contacts, and the displacement of the whole
    /// skin, µs.
    pub(super) full_us: f64,
    /// Median of its contacts alone, µs.
    pub(super) contacts_us: f64,
    /// Median of a frame: one contact, µs.
    pub(super) lean_us: f64,
    /// Answers compared, and those in which both find the same contact to rounding.
    pub(super) n: usize,
    pub(super) n_equal: usize,
    /// Answers of the full scene that are one contact.
    pub(super) n_single: usize,
}

impl Compared {
    pub(super) fn speedup(&self) -> f64 {
        self.full_us / self.lean_us
    }

    /// The same where neither scene wants the displacement of the skin.
    pub(super) fn contacts_speedup(&self) -> f64 {
        self.contacts_us / self.lean_us
    }

    /// Answers that are the same, %.
    pub(super) fn equal_pct(&self) -> f64 {
        100.0 * self.n_equal as f64 / self.n.max(1) as f64
    }

    /// Fails where the full scene finds one contact and the lean one something else. Not for followed
    /// contacts, whose place depends on the way there: the share of equal ones is reported.
    fn checked(self) -> Result<Self> {
        let Self { n_single, n_equal, .. } = self;
        ensure!(
            n_equal >= n_single,
            "of {n_single} frames in which the scene that wants everything finds one contact, the scene of \
             single contacts finds the same in {n_equal}; what is left out must not change it"
        );
        Ok(self)
    }
}

impl Skips {
    pub(super) fn design_speedup(&self) -> f64 {
        self.full_design_s / self.lean_design_s
    }
}

/// Measures both. What the design makes goes to `folder`, which is emptied.
pub(super) fn measure(lab: &mut Lab<'_>, folder: &Path) -> Result<Skips> {
    let (run, limb) = (lab.run, lab.limb);
    run.say("a scene that wants everything, and one that wants single contacts");
    let full = lab.ready(&Configuration::USUAL)?.estimator;
    let lean = lab.ready_for(&Configuration::USUAL, 1)?.estimator;
    let [full_design_s, lean_design_s] = designs(run, limb, folder)?;
    Ok(Skips {
        max_contacts: run.scene.contact.max_contacts,
        full_design_s,
        lean_design_s,
        searched: searched(lab, &full, &lean)?.checked()?,
        followed: followed(lab, &full, &lean)?,
    })
}

fn searched(lab: &Lab<'_>, full: &ContactEstimator, lean: &ContactEstimator) -> Result<Compared> {
    let mut both = Both::default();
    for round in 0..ROUNDS {
        for frame in &lab.frames.singles {
            let (found, contacts_us) = estimate(full, frame)?;
            let shown_us = lab.show(&found.contacts);
            let (alone, lean_us) = estimate(lean, frame)?;
            both.time(contacts_us, shown_us, lean_us);
            if round == 0 {
                both.answers(&found.contacts, &alone.contacts);
            }
        }
    }
    Ok(both.compared())
}

/// Scripts of one contact: times of the frames in which it presses, and the last answers.
fn followed(lab: &Lab<'_>, full: &ContactEstimator, lean: &ContactEstimator) -> Result<Compared> {
    let mut both = Both::default();
    let n_gauges = full.map().n_gauges();
    for scripted in &lab.frames.single_scripts {
        let mut trackers = [tracker(full, lab.run.scene.contact.max_contacts)?, tracker(lean, 1)?];
        for (i, frame) in scripted.readings_ue.iter().enumerate() {
            let [full, lean] = &mut trackers;
            let start = Instant::now();
            full.step(&frame[..n_gauges], None)?;
            let contacts_us = start.elapsed().as_secs_f64() * 1e6;
            let shown_us = lab.show(&contacts(full));
            let start = Instant::now();
            lean.step(&frame[..n_gauges], None)?;
            let lean_us = start.elapsed().as_secs_f64() * 1e6;
            if i >= Script::first_frame_of(1) {
                both.time(contacts_us, shown_us, lean_us);
            }
        }
        let [found, alone] = trackers.each_ref().map(contacts);
        both.answers(&found, &alone);
    }
    Ok(both.compared())
}

fn tracker(estimator: &ContactEstimator, max_contacts: usize) -> Result<ContactTracker> {
    let params = TrackerParams { max_contacts, ..TrackerParams::default() };
    Ok(ContactTracker::new(estimator, params)?)
}

fn contacts(tracker: &ContactTracker) -> Vec<LocatedContact> {
    let held = tracker.last().contacts.iter();
    held.map(|held| held.contact).collect()
}

impl Lab<'_> {
    /// Time of the displacement of the whole skin, which only the full scene wants, µs.
    fn show(&self, contacts: &[LocatedContact]) -> f64 {
        let start = Instant::now();
        if !contacts.is_empty() {
            std::hint::black_box(found_um(&self.maps_of, contacts));
        }
        start.elapsed().as_secs_f64() * 1e6
    }
}

/// Times and answers of both scenes.
#[derive(Default)]
struct Both {
    /// Of the full scene, of its contacts alone, and of the lean scene, µs.
    times_us: [Vec<f64>; 3],
    /// Whether each answer of the full scene is one contact, and the lean scene's the same.
    answers: Vec<(bool, bool)>,
}

impl Both {
    fn time(&mut self, contacts_us: f64, shown_us: f64, lean_us: f64) {
        let both = [contacts_us + shown_us, contacts_us, lean_us];
        self.times_us.iter_mut().zip(both).for_each(|(all, us)| all.push(us));
    }

    fn answers(&mut self, full: &[LocatedContact], lean: &[LocatedContact]) {
        self.answers.push((full.len() == 1, is_equal(full, lean)));
    }

    fn compared(self) -> Compared {
        let [full_us, contacts_us, lean_us] = self.times_us.map(median);
        Compared {
            full_us,
            contacts_us,
            lean_us,
            n: self.answers.len(),
            n_equal: self.answers.iter().filter(|(_, is_equal)| *is_equal).count(),
            n_single: self.answers.iter().filter(|(is_single, _)| *is_single).count(),
        }
    }
}

/// Median times of both designs, s, measured in turns, nothing from a cache.
fn designs(run: &Run, limb: &Limb, folder: &Path) -> Result<[f64; 2]> {
    let mut times_s = [Vec::new(), Vec::new()];
    for _ in 0..DESIGN_ROUNDS {
        run.check_stop("the designs")?;
        let anew = made_anew(run, folder)?;
        let start = Instant::now();
        std::hint::black_box(compliance_table(&anew, limb)?);
        make_estimator(run, limb, run.scene.contact.max_contacts)?;
        times_s[0].push(start.elapsed().as_secs_f64());
        let start = Instant::now();
        make_estimator(run, limb, 1)?;
        times_s[1].push(start.elapsed().as_secs_f64());
    }
    std::fs::remove_dir_all(folder).with_context(|| folder.display().to_string())?;
    Ok(times_s.map(median))
}

/// A response and an estimator on it, not calibrated.
fn make_estimator(run: &Run, limb: &Limb, max_contacts: usize) -> Result<()> {
    let mut scene = run.scene.clone();
    scene.contact.max_contacts = max_contacts;
    let map = response_map(limb, scene.contact.tip_radius_m, run.threads)?;
    let spec = scene.estimator.superposition();
    std::hint::black_box(superposition(&scene, &spec, map)?);
    Ok(())
}

fn estimate(estimator: &ContactEstimator, frame: &Frame) -> Result<(ContactEstimate, f64)> {
    let mut scratch = estimator.scratch();
    let mut estimate = ContactEstimate::default();
    let readings = &frame.readings_ue[..estimator.map().n_gauges()];
    let time_us = estimate_us(estimator, readings, &mut scratch, &mut estimate)?;
    Ok((estimate, time_us))
}

fn is_equal(a: &[LocatedContact], b: &[LocatedContact]) -> bool {
    let ([a], [b]) = (a, b) else {
        return false;
    };
    let gap_m = (a.position_m - b.position_m).norm();
    gap_m < EQUAL_M && (a.force_n / b.force_n - 1.0).abs() < EQUAL_SHARE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_of_single_contacts_that_finds_another_one_is_refused() {
        let compared = |n_single, n_equal| Compared {
            full_us: 10.0,
            contacts_us: 1.5,
            lean_us: 2.0,
            n: 8,
            n_equal,
            n_single,
        };
        let fine = compared(6, 6).checked().unwrap();
        assert_eq!((fine.equal_pct(), fine.speedup()), (75.0, 5.0));
        let error = compared(6, 5).checked().unwrap_err();
        assert!(
            error.to_string().ends_with("the same in 5; what is left out must not change it"),
            "{error}"
        );
    }
}
