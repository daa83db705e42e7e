//! A contact that moves over the skin, followed until it stays.

use hapdef_contact::Phase;
use nalgebra::Point3;

use crate::tracker::compare::{SCANS, TurnedOut, compare};
use crate::tracker::frame::ContactId;
use crate::tracker::hypotheses::HypothesisRef;
use crate::tracker::hypothesis::Track;
use crate::tracker::proposals::{SCAN_STEPS, propose_births, scan_beside};
use crate::tracker::state::{Growing, Sliding, State};
use crate::tracker::workspace::Workspace;

/// What is left of the frames gathered after each frame: five frames count, over which a contact at the
/// usual 0.1 m/s moves half a millimetre.
const KEEP: f64 = 0.8;

/// So many frames a sliding contact's place is behind at most, standard deviation: what is left of those gathered.
/// Without it a strong contact that slides is a misfit wherever it is found: 1.95 instead of 1.66 %, and 1.46 instead
/// of 1.30 %, of the frames of twice 32 random scripts (hapdef's example scripts, seeds 0 and 2).
const LAG_FRAMES: f64 = 5.0;

/// Trial steps in each frame.
const N_TRIALS: usize = 4;

/// The map's slope jumps at edges of faces, and a sliding contact may stay behind at one. Frames between
/// hops, sites that are tried, and how far away, in spacings of the sites.
const HOP_FRAMES: usize = 8;
const N_HOPS: usize = 4;
const HOP_SPACINGS: f64 = 3.0;

/// Frames after which it is asked whether the contact moved: at the usual
/// 0.1 m/s it moves by 3 mm in them, eight times what counts as still.
const BLOCK: usize = 32;

/// The age of a contact that has come to rest: it has explained its frames, and half of the
/// least age of a held contact is left for its force to become steady.
const REST_AGE: usize = 16;

/// It stays if it moved less than this, m, …
const STILL_M: f64 = 4e-4;

/// … or less than so many standard deviations of its place.
const STILL_SDS: f64 = 2.0;

/// Alarms in a row after which something else must have happened. More than for a contact that has come:
/// while one slides its place lags by what the fading sum remembers, so that single alarms say little.
const N_STUCK: usize = 24;

/// Alarms in a row after which it is asked whether a contact comes beside the one that slides, and asked again
/// after twice and four times as many, once it has slid for longer than what it is competes anew. Left to [`N_STUCK`], the sliding contact is dragged to what it can't
/// explain, and held there: of three contacts the third then read 94 N at the rim for 60 ms
/// (`a_press_beside_a_sliding_contact_is_no_phantom`).
const N_NEW: usize = 3;

/// The best hypothesis has a contact that begins to slide.
pub(super) fn start(work: &mut Workspace, was_explained: bool, n_stuck: usize) -> Sliding {
    work.hypotheses.keep_best_only();
    work.frame.info.n_slides += 1;
    let anchor_m = sliding_place(work).map_or_else(Point3::origin, |(place, _)| place);
    Sliding { age: 0, n_still: 0, anchor_m, was_explained, n_stuck }
}

/// What happens next is decided by residuals to which the sliding contact's place is what was found; the frame's is
/// taken with what it may be behind.
pub(super) fn step(now: Sliding, work: &mut Workspace) -> State {
    lag(work, 0.0);
    let is_alarm = work.solve();
    let next = go_on(now, work, is_alarm);
    if matches!(next, State::Sliding(_)) {
        lag(work, LAG_FRAMES * work.params.slide_m_per_s * work.params.frame_period_s);
    }
    next
}

fn go_on(mut now: Sliding, work: &mut Workspace, is_alarm: bool) -> State {
    now.age += 1;
    let age = now.age;
    work.gathered.fade(KEEP);
    work.gathered.add(&work.z, 1.0);
    work.frame.info.is_refined = true;
    let further_m = work.params.slide_m_per_s * work.params.frame_period_s;
    for track in &mut work.hypotheses.best_mut().tracks {
        if let Some((_, sd_m)) = &mut track.slide {
            *sd_m += further_m;
        }
    }
    if age.is_power_of_two() && SCANS.contains(&age) {
        if compare(work, age) == Some(TurnedOut::Birth) {
            let grown = Growing::new(work, *SCANS.start(), now.was_explained);
            return State::Growing(Growing { n_stuck: now.n_stuck, ..grown });
        }
    } else if age.is_multiple_of(HOP_FRAMES) {
        hop(work);
    } else {
        work.settle(HypothesisRef::Best, N_TRIALS);
        work.refresh();
    }
    let is_alarm = is_alarm && work.solve();
    now.n_stuck = if is_alarm { now.n_stuck + 1 } else { 0 };
    let n_new = now.n_stuck / N_NEW;
    if age > *SCANS.end()
        && now.n_stuck == n_new * N_NEW
        && n_new.is_power_of_two()
        && let Some(next) = birth_beside(work)
    {
        return next;
    }
    if now.n_stuck >= N_STUCK {
        work.hold_mobile();
        return State::HOLDING;
    }
    if !age.is_multiple_of(BLOCK) {
        return State::Sliding(now);
    }
    let Some((place, sd_m)) = sliding_place(work) else {
        return State::Sliding(now);
    };
    let moved_m = (place - now.anchor_m).norm();
    now.anchor_m = place;
    let is_still = moved_m < STILL_M.max(STILL_SDS * sd_m);
    if is_still && now.n_still >= 1 {
        return come_to_rest(work, now.n_stuck);
    }
    now.n_still = if is_still { now.n_still + 1 } else { 0 };
    State::Sliding(now)
}

/// A contact more beside the one that slides, if that explains the frames better: both are searched from
/// then on as contacts that have come.
fn birth_beside(work: &mut Workspace) -> Option<State> {
    work.hypotheses.begin();
    let stay = work.hypotheses.copy(0)?;
    if work.hypotheses.candidates[stay].n >= work.most_contacts() {
        return None;
    }
    work.settle(HypothesisRef::Candidate(stay), N_TRIALS);
    let nowhere = work.model.sites.points()[0];
    let newcomer = Track::new(ContactId(work.next_id), nowhere, work.frame.index);
    propose_births(work, stay, newcomer);
    let fits = &work.hypotheses.fits;
    let least = fits[stay].cost - work.params.birth_margin;
    let winner = work.hypotheses.winner().filter(|&c| fits[c].cost < least)?;
    work.hypotheses.take(&work.model, winner, 0.0);
    let best = work.hypotheses.best_mut();
    for track in &mut best.tracks[..best.n] {
        if track.phase == Phase::Sliding {
            (track.phase, track.slide) = (Phase::Born, None);
        }
    }
    work.set_before();
    work.next_id += 1;
    work.frame.info.n_born += 1;
    work.refresh();
    Some(State::Growing(Growing::new(work, *SCANS.start(), false)))
}

/// Residuals are taken with sliding contacts' places known no better than this.
fn lag(work: &mut Workspace, sd_m: f64) {
    work.hypotheses.best_mut().set_lag(sd_m);
    work.refresh();
}

/// Lets the sliding contact go on from the best sites around it: the map's slope jumps at edges of
/// faces, and steps downhill may end at a kink.
fn hop(work: &mut Workspace) {
    let best = work.hypotheses.best();
    let moving = (0..best.n).find(|&i| best.tracks[i].phase == Phase::Sliding);
    let Some(i) = moving.filter(|_| work.spend(SCAN_STEPS) == SCAN_STEPS) else {
        return;
    };
    let track = work.hypotheses.best().tracks[i];
    work.hypotheses.begin();
    let (Some(stay), Some(base)) = (work.hypotheses.copy(0), work.hypotheses.copy(0)) else {
        return;
    };
    work.settle(HypothesisRef::Candidate(stay), N_TRIALS);
    work.hypotheses.candidates[base].remove(i);
    scan_beside(work, base, track.force_n);
    let x = work.model.skin().position(&track.point);
    let reach_m = HOP_SPACINGS * work.model.sites.spacing_m();
    let far = |y: &nalgebra::Point3<f64>| (y - x).norm() > reach_m;
    for (gain, y) in work.buffers.scan.gains.iter_mut().zip(work.model.sites.positions()) {
        *gain = if far(y) { 0.0 } else { *gain };
    }
    work.model.largest(&work.buffers.scan.gains, N_HOPS, &mut work.buffers.scan.peaks);
    for k in 0..work.buffers.scan.peaks.len() {
        let Some(c) = work.hypotheses.copy_candidate(base) else {
            break;
        };
        let point = work.model.sites.points()[work.buffers.scan.peaks[k].site];
        work.hypotheses.candidates[c].push(&work.model, Track { point, ..track });
        work.settle(HypothesisRef::Candidate(c), N_TRIALS);
    }
    if let Some(winner) = work.hypotheses.winner() {
        work.hypotheses.take(&work.model, winner, 0.0);
    }
    work.refresh();
}

/// From now on the contact is searched like one that has come.
fn come_to_rest(work: &mut Workspace, n_stuck: usize) -> State {
    let best = work.hypotheses.best_mut();
    for i in 0..best.n {
        if best.tracks[i].phase == Phase::Sliding {
            best.tracks[i].phase = Phase::Born;
            best.tracks[i].slide = None;
            work.before.copy_from(best);
            work.before.remove(i);
        }
    }
    work.gathered.clear();
    State::Growing(Growing { n_stuck, ..Growing::new(work, REST_AGE, true) })
}

/// Where the sliding contact is, and its standard deviation, m.
fn sliding_place(work: &Workspace) -> Option<(Point3<f64>, f64)> {
    let best = work.hypotheses.best();
    let track = best.tracks().iter().find(|s| s.phase == Phase::Sliding)?;
    let c = &track.covariance;
    let sd_m = (c[(0, 0)] + c[(1, 1)]).sqrt();
    Some((work.model.skin().position(&track.point), sd_m))
}
