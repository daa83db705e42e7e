//! Contacts that hardly press any more are let go.

use crate::tracker::state::State;
use crate::tracker::workspace::Workspace;

/// Lets go what is weak; the state after it.
pub(super) fn release(now: State, work: &mut Workspace) -> State {
    let (least_n, patience) = (work.params.release_force_n, work.params.release_frames);
    let best = work.hypotheses.best_mut();
    let mut n_released = 0;
    for i in (0..best.n).rev() {
        let track = &mut best.tracks[i];
        let sd = track.covariance[(2, 2)].sqrt();
        // with a deviation of 1 N and more a force that is not seen may still be one
        let is_weak = track.force_n < least_n || (track.force_n < 3.0 * sd && sd < 1.0);
        track.n_weak = if is_weak { track.n_weak + 1 } else { track.n_weak.saturating_sub(2) };
        if track.n_weak >= patience {
            work.frame.released.push(track.id);
            best.remove(i);
            n_released += 1;
        }
    }
    if n_released == 0 {
        return now;
    }
    work.frame.info.n_released += n_released;
    for id in &work.frame.released {
        work.hypotheses.drop_contact(*id);
    }
    work.pair_birth.stop();
    work.gathered.clear();
    work.refresh();
    let is_moving = matches!(now, State::Growing(_) | State::Sliding(_));
    let is_gone = is_moving && work.hypotheses.best().n_mobile() == 0;
    if is_gone { State::HOLDING } else { now }
}
