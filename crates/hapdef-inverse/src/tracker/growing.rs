//! Contacts have come: their places are searched again and again as their forces grow.

use crate::chi_square::upper_tail;
use crate::estimator::MAX_CONTACTS;
use crate::tracker::compare::{N_TRIALS, SCANS, TurnedOut, compare};
use crate::tracker::hypotheses::HypothesisRef;
use crate::tracker::pair_search::search_pairs;
use crate::tracker::proposals::{SCAN_STEPS, scan_beside};
use crate::tracker::sliding;
use crate::tracker::state::{Growing, State};
use crate::tracker::workspace::Workspace;

/// Least weight of a frame, N: the force is the weight, and frames in which none is solved would
/// leave a sum without any.
const LEAST_WEIGHT: f64 = 0.05;

/// Frames between refinements: a place changes little between, and each takes a share of the budget.
const STRIDE: usize = 4;

/// The earliest age at which a contact is held: a force whose slow average has seen two of its own lengths,
/// sixteen frames each, has come to rest.
const LEAST_AGE: usize = 32;

/// A force is steady if its averages differ by less than this share …
const STEADY_SHARE: f64 = 0.02;

/// … and this, N.
const STEADY_N: f64 = 0.05;

/// Where the frames are explained from this age on, a misfit is another contact that comes, not one
/// that came at the same time.
const GOOD_AGE: usize = 16;

/// What is not explained stays open for so many times the usual frames: to hold it makes its wrong places
/// known ones, but the tracker can't wait for ever.
const OPEN_FACTOR: usize = 4;

/// Alarms in a row after which refining is not enough, where the frames were explained before: something
/// else has come, and only held contacts let it be looked for.
const N_STUCK: usize = 3;

pub(super) fn step(mut now: Growing, work: &mut Workspace, is_alarm: bool) -> State {
    now.age += 1;
    let age = now.age;
    let force_n = work.hypotheses.best().mobile_force();
    work.gathered.add(&work.z, force_n.max(LEAST_WEIGHT));
    now.averages_n[0] += (force_n - now.averages_n[0]) / 4.0;
    now.averages_n[1] += (force_n - now.averages_n[1]) / 16.0;
    work.frame.info.is_refined = true;
    let is_due = age.is_power_of_two() && SCANS.contains(&age) || age.is_multiple_of(64);
    if is_due {
        if compare(work, age) == Some(TurnedOut::Slide) {
            return State::Sliding(sliding::start(work, now.was_explained, now.n_stuck));
        }
    } else if (is_alarm || age.is_multiple_of(STRIDE)) && !work.pair_birth.is_ready() {
        work.settle(HypothesisRef::Best, N_TRIALS);
        work.refresh();
    }
    let is_alarm = is_alarm && work.solve();
    now.n_stuck = if is_alarm { now.n_stuck + 1 } else { 0 };
    if work.pair_birth.is_active() {
        if search_pairs(work) {
            now.averages_n = [work.hypotheses.best().mobile_force(); 2];
            now.n_stuck = 0;
        }
    } else if is_due {
        consider_pairs(&mut now, work);
    }
    if !is_to_hold(&now, work) {
        return State::Growing(now);
    }
    work.pair_birth.stop();
    work.hold_mobile();
    State::HOLDING
}

/// Looks for two contacts at once where those that came do not explain the frames gathered, and
/// never did.
fn consider_pairs(now: &mut Growing, work: &mut Workspace) {
    let fit = work.settle(HypothesisRef::Best, 0);
    let best = work.hypotheses.best();
    let n_mobile = best.n_mobile();
    let n_dof = work.n_live.saturating_sub(best.n + 2 * n_mobile);
    let is_good = n_dof == 0 || upper_tail(fit.chi2, n_dof) >= work.params.pair_p;
    let force_n = best.mobile_force();
    if is_good {
        now.was_explained = now.age >= GOOD_AGE;
        return;
    }
    let is_room = work.before.n + 2 <= work.most_contacts().min(MAX_CONTACTS);
    if now.was_explained || n_mobile > 2 || !is_room || work.spend(SCAN_STEPS) < SCAN_STEPS {
        return;
    }
    work.hypotheses.begin();
    if let Some(base) = work.hypotheses.add(&work.before) {
        scan_beside(work, base, force_n);
        work.pair_birth.prepare(&work.hypotheses.candidates[base], &work.buffers.scan);
        let scale = work.gathered.frame(&mut work.buffers.z);
        work.pair_birth.start(&work.buffers.z, scale);
    }
}

fn is_to_hold(now: &Growing, work: &Workspace) -> bool {
    let [fast, slow] = now.averages_n;
    let settle_frames = work.params.settle_frames;
    let is_steady = (fast - slow).abs() < STEADY_SHARE * slow + STEADY_N;
    let is_other = now.n_stuck >= N_STUCK && now.was_explained;
    let is_time = (is_steady && now.age >= LEAST_AGE) || now.age >= settle_frames;
    let is_explained = now.was_explained || now.age >= OPEN_FACTOR * settle_frames;
    is_other || (is_time && is_explained && !work.pair_birth.is_active())
}
