//! Something is new: a contact more, a slide, another hypothesis after all, or nothing.

use hapdef_contact::Phase;

use crate::chi_square::upper_tail;
use crate::tracker::frame::ContactId;
use crate::tracker::hypotheses::HypothesisRef;
use crate::tracker::hypothesis::Track;
use crate::tracker::proposals::{N_BASES, propose_births, propose_replacement, propose_slides};
use crate::tracker::sliding;
use crate::tracker::state::{DetectionWindow, Growing, Holding, State};
use crate::tracker::workspace::Workspace;

/// Frames in which alarms are held off after a detection window without result: a residual that nothing
/// explains would open the next one at once, and its scans would take every frame's budget. Two of the
/// usual blocks, in which held contacts learn from the frames that don't alarm.
const N_HOLDOFF: usize = 16;

/// The last decision of a window is made after so many times the frames of the first, on an eighth of its
/// noise variance: what is not decided then is left to the mean of a block.
const LAST_LOOK: usize = 8;

/// Standard deviations of the forces' prior beyond which what comes in one frame waits for more frames: of a force
/// that grows by kilonewtons a frame the place is not exact in the first, and later frames are explained best by
/// two contacts (`one_place_is_never_surely_two_contacts`).
const EXPECTED_SDS: f64 = 3.0;

/// Opens a window with the frame that alarmed. One that nothing there explains is decided at once where a contact
/// more explains it and no slide may: a press that comes fast is seen in its first frame.
pub(super) fn begin(work: &mut Workspace) -> State {
    work.gathered.clear();
    work.gathered.add(&work.z, 1.0);
    let is_misfit = upper_tail(work.frame.chi2, work.frame.n_dof) < work.params.misfit_p;
    let born = if is_misfit { decide_at_once(work) } else { None };
    born.unwrap_or(State::Detecting(DetectionWindow { age: 1 }))
}

/// A contact more, if it explains the one frame gathered, and better by the usual margin than what is there and
/// than any slide of a whole window: without the slides 5 of 8 presses beside a slide were right instead of 8
/// (`a_press_beside_a_sliding_contact_is_no_phantom`), since a slide that begins looks like a birth in one frame.
/// What comes has to be more than what the forces there change by.
fn decide_at_once(work: &mut Workspace) -> Option<State> {
    if work.hypotheses.best().n >= work.most_contacts() {
        return None;
    }
    let held = work.hypotheses.best().tracks().iter();
    let changed_n: f64 = held.map(|track| (track.force_n - track.steady.0).abs()).sum();
    work.hypotheses.begin();
    let stay = work.hypotheses.copy(0)?;
    work.settle(HypothesisRef::Candidate(stay), 0);
    propose_slides(work, stay, LAST_LOOK * work.params.detection_frames);
    let rival = work.hypotheses.winner()?;
    let rival_cost = work.hypotheses.fits[rival].cost;
    let nowhere = work.model.sites.points()[0];
    let newcomer = Track::new(ContactId(work.next_id), nowhere, work.frame.index);
    propose_births(work, stay, newcomer);
    let born = work.hypotheses.winner()?;
    let (fit, candidate) = (work.hypotheses.fits[born], &work.hypotheses.candidates[born]);
    let n = candidate.n;
    let force_n = candidate.mobile_force();
    let is_clear = fit.cost < rival_cost - work.params.birth_margin;
    let is_expected = (changed_n..EXPECTED_SDS * work.settings.force_scale_n).contains(&force_n);
    if born == rival || !is_clear || !is_expected || work.is_odd(fit.chi2, n) {
        return None;
    }
    let next = adopt_winner(work, born, 1, None);
    work.refresh();
    Some(next)
}

/// Gathers frames since the alarm, and decides when there are enough.
pub(super) fn step(now: DetectionWindow, work: &mut Workspace) -> State {
    let age = now.age + 1;
    work.gathered.add(&work.z, 1.0);
    let first = work.params.detection_frames;
    if age.is_multiple_of(first) && (age / first).is_power_of_two() {
        if let Some(next) = decide(work, age) {
            return next;
        }
        if age >= LAST_LOOK * first {
            work.gathered.clear();
            return State::Holding(Holding { holdoff: N_HOLDOFF });
        }
    }
    State::Detecting(DetectionWindow { age })
}

/// Lets the candidates compete on the frames gathered; the next state if something changed.
fn decide(work: &mut Workspace, age: usize) -> Option<State> {
    work.hypotheses.begin();
    let n_alive = work.hypotheses.n_alive();
    for j in 0..n_alive {
        if let Some(c) = work.hypotheses.copy(j) {
            let behind = work.hypotheses.candidates[c].cost() - work.hypotheses.best().cost();
            work.hypotheses.candidates[c].handicap = behind;
            work.settle(HypothesisRef::Candidate(c), 0);
        }
    }
    let nowhere = work.model.sites.points()[0];
    let newcomer = Track::new(ContactId(work.next_id), nowhere, work.frame.index);
    for j in 0..n_alive.min(N_BASES) {
        if work.hypotheses.candidates[j].n < work.most_contacts() {
            propose_births(work, j, newcomer);
        }
    }
    let weakest = propose_replacement(work, newcomer);
    propose_slides(work, 0, age);
    let stay = work.hypotheses.fits[0].cost;
    let margin = work.params.birth_margin;
    let winner = work.hypotheses.winner().filter(|&c| {
        let is_other = c > 0 && c < n_alive;
        let margin = if is_other { 0.0 } else { margin };
        c > 0 && work.hypotheses.fits[c].cost < stay - margin
    });
    let winner = winner?;
    let next = adopt_winner(work, winner, n_alive, weakest);
    work.refresh();
    Some(next)
}

fn adopt_winner(
    work: &mut Workspace,
    winner: usize,
    n_alive: usize,
    weakest: Option<(usize, ContactId)>,
) -> State {
    let is_birth =
        work.hypotheses.candidates[winner].tracks().iter().any(|track| track.phase == Phase::Born);
    let replaced = weakest.filter(|_| is_birth);
    let before = replaced.map_or(0, |(base, _)| base);
    work.before.copy_from(&work.hypotheses.candidates[before]);
    let delta = work.params.hypothesis_delta;
    work.hypotheses.take(&work.model, winner, delta);
    if winner < n_alive {
        work.frame.info.is_switched = true;
        work.gathered.clear();
        return State::HOLDING;
    }
    if !is_birth {
        return State::Sliding(sliding::start(work, false, 0));
    }
    if let Some((_, id)) = replaced {
        work.frame.released.push(id);
        work.frame.info.n_released += 1;
    }
    work.next_id += 1;
    work.frame.info.n_born += 1;
    State::Growing(Growing::new(work, work.gathered.n_frames, false))
}
