//! Candidates that may explain the frames gathered better: contacts more, contacts replaced, slides.

use hapdef_contact::Phase;

use crate::estimator::MAX_CONTACTS;
use crate::skin_point::SkinPoint;
use crate::tracker::frame::ContactId;
use crate::tracker::hypotheses::HypothesisRef;
use crate::tracker::hypothesis::{Hypothesis, Track};
use crate::tracker::workspace::Workspace;

/// Places that a new contact is refined from: each costs a frame up to eight trial steps of its hundred.
const N_PEAKS: usize = 3;

/// Hypotheses to which a contact is added: the second may be the right one, whose place a newcomer
/// settles; further ones would take the budget of the slides.
pub(super) const N_BASES: usize = 2;

/// Trial steps of each candidate.
const N_TRIALS: usize = 8;

/// What a scan counts of the budget, so that a frame's time is bounded whatever it does: see
/// [`crate::TrackerParams::steps_per_frame`].
pub(super) const SCAN_STEPS: usize = 8;

/// How far a contact may have slid unnoticed, m: about the error of a held place. It adds to
/// what the usual 0.1 m/s allows, 0.3 mm in the first three frames.
const LEAST_SLIDE_M: f64 = 2e-4;

/// Where no contact more can be held: candidates with `newcomer` in place of the weakest contact.
/// Returns the candidate without either and who it lacks.
pub(super) fn propose_replacement(
    work: &mut Workspace,
    newcomer: Track,
) -> Option<(usize, ContactId)> {
    let first = &work.hypotheses.candidates[0];
    if first.n < work.most_contacts() {
        return None;
    }
    let forces = first.forces();
    let weakest = (0..first.n).min_by(|&i, &j| forces[i].total_cmp(&forces[j]))?;
    let id = first.tracks[weakest].id;
    let base = work.hypotheses.copy_candidate(0)?;
    work.hypotheses.candidates[base].remove(weakest);
    propose_births(work, base, newcomer);
    Some((base, id))
}

/// Candidates with `newcomer` more than candidate `base`, at the best places of a scan for a
/// contact of about its force.
pub(super) fn propose_births(work: &mut Workspace, base: usize, newcomer: Track) {
    if work.spend(SCAN_STEPS) < SCAN_STEPS {
        return;
    }
    scan_beside(work, base, newcomer.force_n);
    work.buffers.scan.find_peaks(&work.model, N_PEAKS);
    for k in 0..work.buffers.scan.peaks.len() {
        let site = work.buffers.scan.peaks[k].site;
        let point = work.model.sites.points()[site];
        if !is_apart(work, &work.hypotheses.candidates[base], &point) {
            continue;
        }
        let Some(c) = work.hypotheses.copy_candidate(base) else {
            return;
        };
        let track = Track { point, ..newcomer };
        work.hypotheses.candidates[c].push(&work.model, track);
        work.settle(HypothesisRef::Candidate(c), N_TRIALS);
        let candidate = &work.hypotheses.candidates[c];
        let born = &candidate.tracks[candidate.n - 1];
        let is_weak = born.force_n < work.params.release_force_n;
        if is_weak || !is_apart(work, &work.hypotheses.candidates[base], &born.point) {
            work.hypotheses.fits[c].cost = f64::INFINITY;
        }
    }
}

/// Scans the sites beside candidate `base` on the frames gathered.
pub(super) fn scan_beside(work: &mut Workspace, base: usize, newcomer_n: f64) {
    work.frame.info.n_scans += 1;
    let scale = work.gathered.frame(&mut work.buffers.z);
    let hypothesis = &work.hypotheses.candidates[base];
    let forces = hypothesis.forces().map(|a| a * scale);
    let buffers = &mut work.buffers;
    buffers.filter.weigh_beside(
        hypothesis,
        &forces,
        scale,
        newcomer_n * scale,
        &mut buffers.metric,
    );
    let solved = buffers.metric.solve(&buffers.z);
    buffers.scan.scan(&buffers.metric, &solved.forces);
}

/// Candidates in which one of the contacts of candidate `base` has slid for `n_frames`.
pub(super) fn propose_slides(work: &mut Workspace, base: usize, n_frames: usize) {
    let time_s = n_frames as f64 * work.params.frame_period_s;
    let sd_m = work.params.slide_m_per_s * time_s + LEAST_SLIDE_M;
    for i in 0..work.hypotheses.candidates[base].n {
        let track = work.hypotheses.candidates[base].tracks[i];
        if track.force_n < work.params.release_force_n {
            continue;
        }
        let Some(c) = work.hypotheses.copy_candidate(base) else {
            return;
        };
        let from = work.model.skin().position(&track.point);
        let candidate = &mut work.hypotheses.candidates[c];
        candidate.tracks[i].phase = Phase::Sliding;
        candidate.tracks[i].slide = Some((from, sd_m));
        candidate.forget(&work.model, i);
        work.settle(HypothesisRef::Candidate(c), N_TRIALS);
    }
}

/// Whether no two contacts of candidate `c` are nearer to each other than contacts come: one that slides is else
/// taken for two, where it was and where it is.
pub(super) fn are_apart(work: &Workspace, c: usize) -> bool {
    let tracks = work.hypotheses.candidates[c].tracks();
    let skin = work.model.skin();
    let place = |track: &Track| skin.position(&track.point);
    let far = |a: &Track, b: &Track| (place(a) - place(b)).norm() >= work.params.min_gap_m;
    (0..tracks.len()).all(|i| tracks[..i].iter().all(|other| far(other, &tracks[i])))
}

fn is_apart(work: &Workspace, hypothesis: &Hypothesis, point: &SkinPoint) -> bool {
    let skin = work.model.skin();
    let x = skin.position(point);
    let far = |track: &Track| (skin.position(&track.point) - x).norm() >= work.params.min_gap_m;
    debug_assert!(hypothesis.n <= MAX_CONTACTS);
    hypothesis.tracks().iter().all(far)
}
