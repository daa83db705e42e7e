//! All contacts are held: frames add up, and their mean updates the hypotheses.

use crate::tracker::detection;
use crate::tracker::state::{DetectionWindow, Holding, State};
use crate::tracker::workspace::Workspace;

pub(super) fn step(now: Holding, work: &mut Workspace, is_alarm: bool) -> State {
    let held = State::Holding(Holding { holdoff: now.holdoff.saturating_sub(1) });
    if is_alarm {
        if now.holdoff > 0 {
            return held;
        }
        return detection::begin(work);
    }
    work.gathered.add(&work.z, 1.0);
    if work.gathered.n_frames < work.params.block_frames {
        return held;
    }
    if now.holdoff == 0 && is_block_odd(work) {
        // weak contacts and slow slides, which single frames don't show
        let age = work.params.detection_frames.saturating_sub(1);
        return State::Detecting(DetectionWindow { age });
    }
    work.learn();
    work.gathered.clear();
    held
}

fn is_block_odd(work: &mut Workspace) -> bool {
    let buffers = &mut work.buffers;
    let scale = work.gathered.frame(&mut buffers.z);
    let best = work.hypotheses.best();
    let forces = best.forces().map(|a| a * scale);
    buffers.filter.weigh(best, &forces, scale, &mut buffers.metric);
    let solved = buffers.metric.solve(&buffers.z);
    let n = best.n;
    work.is_odd(solved.chi2, n)
}
