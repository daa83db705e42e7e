//! What becomes of the outcome of a full search.

use nalgebra::Point3;

use crate::tracker::frame::ContactId;
use crate::tracker::hypotheses::HypothesisRef;
use crate::tracker::hypothesis::Track;
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

/// Takes the contacts of `outcome` if they explain the latest frames better than the best hypothesis;
/// the state then, if so. Contacts near those that were there keep their names.
pub(super) fn adopt(
    work: &mut Workspace,
    recent: &Recent,
    outcome: &SearchOutcome,
) -> Option<State> {
    let found = &outcome.estimate.contacts;
    work.steps_left = work.params.steps_per_frame.max(2 * N_TRIALS);
    work.gathered.copy_from(&recent.gathered);
    work.hypotheses.begin();
    let (Some(stay), Some(new)) = (work.hypotheses.copy(0), work.hypotheses.copy(0)) else {
        return None;
    };
    work.settle(HypothesisRef::Candidate(stay), 0);
    work.hypotheses.candidates[new].n = 0;
    work.before.copy_from(&work.hypotheses.candidates[new]);
    let first_id = work.next_id;
    for contact in found {
        let id = name_at(work, new, contact.position_m);
        let mut track = Track::new(id, contact.point, work.frame.index);
        track.force_n = contact.force_n;
        work.hypotheses.candidates[new].push(&work.model, track);
    }
    work.settle(HypothesisRef::Candidate(new), N_TRIALS);
    let fits = &work.hypotheses.fits;
    let is_better = fits[new].cost < fits[stay].cost - work.params.birth_margin;
    work.pair_birth.stop();
    if !is_better {
        work.next_id = first_id;
        work.gathered.clear();
        work.refresh();
        return None;
    }
    work.hypotheses.fits[stay].cost = f64::INFINITY;
    work.hypotheses.take(&work.model, new, 0.0);
    work.refresh();
    Some(State::Growing(Growing::new(work, work.gathered.n_frames, true)))
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
