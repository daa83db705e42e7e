//! The search for pairs, as far as each frame's budget lets it go.

use crate::tracker::frame::ContactId;
use crate::tracker::hypotheses::HypothesisRef;
use crate::tracker::hypothesis::Track;
use crate::tracker::locate::{Refiner, Target};
use crate::tracker::pair_birth::N_FINALISTS;
use crate::tracker::workspace::Workspace;

/// Pairs that are refined: with their trial steps ten frames' budget. A search from scratch refines 150,
/// but does not know the contacts that were there.
const N_PAIRS: usize = 64;

/// Trial steps of each.
const N_TRIALS: usize = 8;

/// Trial steps of each finalist at the end.
const N_FINAL_TRIALS: usize = 10;

/// Goes on with the search for pairs as far as the frame's budget lets it;
/// whether a pair replaces what there was.
pub(super) fn search_pairs(work: &mut Workspace) -> bool {
    let n_left = work.pair_birth.job.n_left();
    if n_left > 0 {
        let n_rows = work.spend(n_left);
        work.frame.info.n_pair_rows += n_rows;
        if work.pair_birth.job.go_on(n_rows) {
            work.pair_birth.job.rank(&work.model, N_PAIRS);
        }
        return false;
    }
    while work.pair_birth.next < work.pair_birth.job.pairs.len() {
        if work.steps_left < 2 * N_TRIALS {
            return false;
        }
        refine_pair(work);
    }
    // In a frame with room for all finalists at once. Each alarmed frame spends part of its budget before,
    // so a pair beside held contacts would wait for ever if no refinement made room for it: of two and
    // then two more at once 46 instead of 77.5 % were right (`PairBirth::is_ready`;
    // `a_pair_that_comes_beside_held_contacts_is_found`).
    if work.steps_left >= 2 * (N_TRIALS + N_FINALISTS * N_FINAL_TRIALS)
        || work.steps_left == work.params.steps_per_frame
    {
        let is_taken = finish_pairs(work);
        work.pair_birth.stop();
        return is_taken;
    }
    false
}

fn refine_pair(work: &mut Workspace) {
    let Workspace { pair_birth, model, .. } = work;
    let pair = pair_birth.job.pairs[pair_birth.next];
    pair_birth.next += 1;
    pair_birth.trial.copy_from(&pair_birth.base);
    for site in pair.sites {
        let point = model.sites.points()[site];
        let track = Track::new(ContactId(0), point, work.frame.index);
        pair_birth.trial.push(model, track);
    }
    let target = Target { z: &pair_birth.z, scale: pair_birth.scale };
    let mut refiner = Refiner {
        model,
        params: &work.settings,
        filter: &mut work.buffers.filter,
        metric: &mut work.buffers.metric,
        locator: &mut work.buffers.locator,
        n_trials: 0,
    };
    let fit = refiner.settle(&mut pair_birth.trial, &target, 2 * N_TRIALS);
    let n_trials = refiner.n_trials;
    pair_birth.rank(fit);
    work.frame.info.n_trials += n_trials;
    work.spend(n_trials);
}

/// The best pairs against what there is, on all frames so far; whether one of them is better.
fn finish_pairs(work: &mut Workspace) -> bool {
    let best = work.hypotheses.best();
    let Some(&first) = best.tracks().iter().find(|track| track.is_mobile()) else {
        return false;
    };
    let second = best.tracks().iter().filter(|track| track.is_mobile()).nth(1);
    let second = second.map_or(ContactId(work.next_id), |track| track.id);
    work.hypotheses.begin();
    let Some(stay) = work.hypotheses.copy(0) else {
        return false;
    };
    work.settle(HypothesisRef::Candidate(stay), N_TRIALS);
    for k in 0..N_FINALISTS {
        if !work.pair_birth.fits[k].cost.is_finite() {
            break;
        }
        let Some(c) = work.hypotheses.add(&work.pair_birth.finalists[k]) else {
            break;
        };
        let candidate = &mut work.hypotheses.candidates[c];
        let n = candidate.n;
        for (track, id) in candidate.tracks[n - 2..n].iter_mut().zip([first.id, second]) {
            (track.id, track.born) = (id, first.born);
        }
        work.settle(HypothesisRef::Candidate(c), N_FINAL_TRIALS);
    }
    let stay = work.hypotheses.fits[stay].cost;
    let n_mobile = work.hypotheses.best().n_mobile();
    let margin = if n_mobile == 1 { work.params.birth_margin } else { 0.0 };
    let better = |&c: &usize| c > 0 && work.hypotheses.fits[c].cost < stay - margin;
    let Some(winner) = work.hypotheses.winner().filter(better) else {
        return false;
    };
    let delta = work.params.hypothesis_delta;
    work.hypotheses.take(&work.model, winner, delta);
    work.next_id += u64::from(second.0 == work.next_id);
    work.frame.info.n_born += usize::from(n_mobile == 1);
    work.refresh();
    true
}
