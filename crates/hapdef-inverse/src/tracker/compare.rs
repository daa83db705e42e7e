//! A contact that came and contacts that slide compete again, while they move.

use hapdef_contact::Phase;

use crate::chi_square::upper_tail;
use crate::tracker::filter::MAX_CROSSINGS;
use crate::tracker::frame::ContactId;
use crate::tracker::hypotheses::HypothesisRef;
use crate::tracker::hypothesis::Track;
use crate::tracker::proposals::{N_BASES, propose_births, propose_slides};
use crate::tracker::workspace::Workspace;
use crate::walk::AtWall;

/// The first age at which the whole skin is scanned again, and the last. In between at powers of two: a
/// place that was found while the force was small may be in the wrong basin, and twice the frames show it.
pub(super) const SCANS: std::ops::RangeInclusive<usize> = 4..=64;

/// The last age at which a slide may be all that happened: its prior grows with them, to 3 mm at the
/// usual 0.1 m/s.
const SLIDE_AGE: usize = 32;

/// Places around a contact are tried where what it explains is less probable than this, since a descent
/// may end at a kink between two faces; in nine of ten frames of a right place they are not, …
const HOP_P: f64 = 0.1;

/// … from this age on, …
const LEAST_HOP_AGE: usize = 8;

/// … in so many directions, this far away at one age and the next, in spacings of the sites.
const N_DIRECTIONS: u32 = 6;
const HOP_SPACINGS: [f64; 2] = [0.4, 0.8];

/// Trial steps of a refinement.
pub(super) const N_TRIALS: usize = 6;

/// What the contact that moves has turned out to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TurnedOut {
    /// What seemed to slide is a contact more.
    Birth,
    /// What seemed to have come is a contact that slides.
    Slide,
}

/// Lets a contact that came and contacts that slide compete again on the frames gathered since
/// `n_frames`: the hypotheses there are, the best places of a new scan, slides.
pub(super) fn compare(work: &mut Workspace, n_frames: usize) -> Option<TurnedOut> {
    let best = work.hypotheses.best();
    let mobile = best.tracks().iter().find(|track| track.is_mobile());
    let n_mobile = best.n_mobile();
    let &mobile = mobile?;
    work.hypotheses.begin();
    for j in 0..work.hypotheses.n_alive() {
        if let Some(c) = work.hypotheses.copy(j) {
            work.settle(HypothesisRef::Candidate(c), N_TRIALS);
        }
    }
    if n_mobile == 1 {
        propose_again(work, &mobile, n_frames);
        propose_hops(work, &mobile, n_frames);
    }
    if let Some(winner) = work.hypotheses.winner() {
        let delta = work.params.hypothesis_delta;
        work.hypotheses.take(&work.model, winner, delta);
    }
    let turned_out = turned_out(work, &mobile);
    work.refresh();
    turned_out
}

/// Candidates from the contacts there were before `mobile` moved.
fn propose_again(work: &mut Workspace, mobile: &Track, n_frames: usize) {
    let newcomer = Track::new(ContactId(work.next_id), mobile.point, work.frame.index);
    if mobile.phase == Phase::Born {
        for j in 0..work.hypotheses.n_alive().min(N_BASES) {
            propose_elsewhere(work, j, mobile);
        }
    }
    if let Some(base) = work.hypotheses.add(&work.before) {
        let now = work.hypotheses.candidates[0].tracks;
        let forces_now = &now[..work.hypotheses.candidates[0].n];
        for track in &mut work.hypotheses.candidates[base].tracks {
            let same = forces_now.iter().find(|other| other.id == track.id);
            track.force_n = same.map_or(track.force_n, |other| other.force_n);
        }
        if mobile.phase != Phase::Born && work.before.n < work.most_contacts() {
            propose_births(work, base, newcomer);
        }
        if n_frames <= SLIDE_AGE {
            propose_slides(work, base, n_frames);
        }
    }
}

/// Candidates with the contact `mobile` of candidate `from` in other places.
fn propose_elsewhere(work: &mut Workspace, from: usize, mobile: &Track) {
    let tracks = work.hypotheses.candidates[from].tracks();
    let Some(i) = tracks.iter().position(|track| track.id == mobile.id) else {
        return;
    };
    if let Some(base) = work.hypotheses.copy_candidate(from) {
        work.hypotheses.candidates[base].remove(i);
        propose_births(work, base, *mobile);
    }
}

/// Candidates that start around the place of `mobile` where it does not explain the frames well:
/// the map's slope jumps at edges of faces, and steps downhill may end at a kink.
fn propose_hops(work: &mut Workspace, mobile: &Track, n_frames: usize) {
    let from = work.hypotheses.candidates[0].tracks().iter();
    let Some(i) = from.clone().position(|track| track.id == mobile.id) else {
        return;
    };
    let n_dof = work.n_live.saturating_sub(work.hypotheses.candidates[0].n + 2);
    let p = upper_tail(work.hypotheses.fits[0].chi2, n_dof);
    if n_frames < LEAST_HOP_AGE || p > HOP_P {
        return;
    }
    let spacings = HOP_SPACINGS[n_frames.trailing_zeros() as usize % 2];
    let distance_m = spacings * work.model.sites.spacing_m();
    let point = work.hypotheses.candidates[0].tracks[i].point;
    let [t1, t2] = work.model.skin().tangents(&point);
    for turn in 0..N_DIRECTIONS {
        let angle = f64::from(turn) / f64::from(N_DIRECTIONS) * std::f64::consts::TAU;
        let step = (t1 * angle.cos() + t2 * angle.sin()) * distance_m;
        let skin = work.model.skin();
        let walk = skin.walk_at_most(&point, &step, AtWall::Slide, MAX_CROSSINGS);
        let Some(c) = work.hypotheses.copy_candidate(0) else {
            return;
        };
        work.hypotheses.candidates[c].tracks[i].point = walk.point;
        work.settle(HypothesisRef::Candidate(c), N_TRIALS);
    }
}

/// What `mobile`, the contact that moved before, has turned out to be.
fn turned_out(work: &mut Workspace, mobile: &Track) -> Option<TurnedOut> {
    let best = work.hypotheses.best();
    let &now = best.tracks().iter().find(|track| track.is_mobile())?;
    match (mobile.phase, now.phase) {
        (Phase::Sliding, Phase::Born) => {
            work.next_id += u64::from(now.id.0 == work.next_id);
            work.frame.info.n_born += 1;
            Some(TurnedOut::Birth)
        }
        (Phase::Born, Phase::Sliding) => {
            work.frame.released.push(mobile.id);
            work.frame.info.n_released += 1;
            work.pair_birth.stop();
            Some(TurnedOut::Slide)
        }
        _ => None,
    }
}
