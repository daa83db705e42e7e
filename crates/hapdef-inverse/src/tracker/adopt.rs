//! What becomes of the outcome of a full search.

use nalgebra::Point3;

use crate::estimator::MAX_CONTACTS;
use crate::tracker::exchange::Belief;
use crate::tracker::frame::ContactId;
use crate::tracker::hypotheses::HypothesisRef;
use crate::tracker::hypothesis::Track;
use crate::tracker::proposals::are_apart;
use crate::tracker::recent::Recent;
use crate::tracker::search::SearchOutcome;
use crate::tracker::state::{Growing, State};
use crate::tracker::workspace::Workspace;

/// Trial steps with which an outcome is brought to the tracker's own covariances: it was found from other
/// frames, averaged, with the map's error in the noise.
const N_TRIALS: usize = 24;

/// A contact found within this of one that was there has its name, m: places may be
/// wrong where a search is wanted, so this is wide beside their usual error of tenths of a millimetre.
const SAME_M: f64 = 0.015;

/// Of a contact whose name is still to be found.
const NAMELESS: ContactId = ContactId(u64::MAX);

/// Takes the contacts of `outcome` if they explain the latest frames better than the best hypothesis;
/// the state then, if so. Contacts near those that were there keep their names.
pub(super) fn adopt(
    work: &mut Workspace,
    recent: &Recent,
    outcome: &SearchOutcome,
) -> Option<State> {
    work.steps_left = work.params.steps_per_frame.max(2 * N_TRIALS * MAX_CONTACTS);
    work.gathered.copy_from(&recent.gathered);
    work.hypotheses.best_mut().set_lag(0.0);
    work.hypotheses.begin();
    let stay = work.hypotheses.copy(0)?;
    let Workspace { hypotheses, trusted, model, .. } = &mut *work;
    hypotheses.candidates[stay].doubt(model, trusted);
    work.settle(HypothesisRef::Candidate(stay), 0);
    let first_id = work.next_id;
    propose_found(work, outcome);
    propose_exchanged(work, outcome);
    let least = work.hypotheses.fits[stay].cost - work.params.birth_margin;
    let is_better = |&c: &usize| work.hypotheses.fits[c].cost < least;
    let better = work.hypotheses.winner().filter(is_better);
    work.pair_birth.stop();
    let Some(better) = better else {
        work.next_id = first_id;
        work.gathered.clear();
        work.refresh();
        return None;
    };
    work.hypotheses.take(&work.model, better, 0.0);
    work.set_before();
    work.refresh();
    if work.hypotheses.best().n_mobile() == 0 {
        work.gathered.clear();
        return Some(State::HOLDING);
    }
    Some(State::Growing(Growing::new(work, work.gathered.n_frames, true)))
}

/// A candidate with the contacts of the search from scratch, if as many can be held.
fn propose_found(work: &mut Workspace, outcome: &SearchOutcome) {
    let found = &outcome.estimate.contacts;
    let c = if found.len() > work.most_contacts() { None } else { work.hypotheses.copy(0) };
    let Some(c) = c else {
        return;
    };
    work.hypotheses.candidates[c].n = 0;
    for contact in found {
        let id = name_at(work, c, contact.position_m);
        let mut track = Track::new(id, contact.point, work.frame.index);
        track.force_n = contact.force_n;
        work.hypotheses.candidates[c].push(&work.model, track);
    }
    refine(work, c);
}

/// A candidate with what was believed when the search began, contacts exchanged.
fn propose_exchanged(work: &mut Workspace, outcome: &SearchOutcome) {
    let exchanged = outcome.exchanged.as_ref().map(Belief::hypothesis);
    let fits = exchanged.filter(|hypothesis| hypothesis.n <= work.most_contacts());
    let Some(c) = fits.and_then(|hypothesis| work.hypotheses.add(hypothesis)) else {
        return;
    };
    let (best, n_best) = (work.hypotheses.best().tracks, work.hypotheses.best().n);
    let best = &best[..n_best];
    let candidate = &mut work.hypotheses.candidates[c];
    let n = candidate.n;
    let is_gone = |track: &Track| best.iter().all(|other| other.id != track.id);
    for track in &mut candidate.tracks[..n] {
        if track.is_mobile() || is_gone(track) {
            track.id = NAMELESS;
        }
    }
    for i in 0..n {
        let track = work.hypotheses.candidates[c].tracks[i];
        if track.id == NAMELESS {
            let x = work.model.skin().position(&track.point);
            work.hypotheses.candidates[c].tracks[i].id = name_at(work, c, x);
        }
    }
    refine(work, c);
}

/// Brings candidate `c` to the frames gathered; it is none if contacts of it come too near to each other.
fn refine(work: &mut Workspace, c: usize) {
    work.settle(HypothesisRef::Candidate(c), N_TRIALS);
    if !are_apart(work, c) {
        work.hypotheses.fits[c].cost = f64::INFINITY;
    }
}

/// The name of the contact that is nearest to `x` and has not given its name to candidate `new`
/// yet, or a new one.
fn name_at(work: &mut Workspace, new: usize, x: Point3<f64>) -> ContactId {
    let skin = work.model.skin();
    let taken = work.hypotheses.candidates[new].tracks();
    let nearest = work
        .hypotheses
        .best()
        .tracks()
        .iter()
        .filter(|track| taken.iter().all(|other| other.id != track.id))
        .map(|track| (track.id, (skin.position(&track.point) - x).norm()))
        .filter(|(_, gap)| *gap <= SAME_M)
        .min_by(|a, b| a.1.total_cmp(&b.1));
    nearest.map_or_else(
        || {
            work.next_id += 1;
            ContactId(work.next_id - 1)
        },
        |(id, _)| id,
    )
}
