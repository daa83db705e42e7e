//! The virtual rig within the program: pressed from the page, by itself while nobody does.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use anyhow::Result;
use hapdef::{Limb, Run, VirtualRigParams, live_limb, virtual_device, virtual_hands};
use hapdef_daq::source::{StreamParams, StreamSource, memory_link};
use hapdef_rig::live::{
    Hands, LiveLimb, PressHandle, RunParams, RunningRig, TrueContact, TruthFrame, spawn_rig,
};

use crate::cli::sim::{Simulated, truth_line};

/// Frames of ground truth that the page can look back for: a quarter of a second at 1 kHz.
const N_TRUTHS: usize = 256;

/// The scene's virtual rig, running.
pub(crate) struct Sim {
    limb: Arc<LiveLimb>,
    hands: Hands,
    rig: RunningRig,
    truths: Truths,
}

/// What pressed the rig in its newest frames, shared with the rig's thread.
#[derive(Clone, Default)]
struct Truths(Arc<Mutex<VecDeque<TruthFrame>>>);

impl Sim {
    /// Solves the virtual rig, or reads it where it was solved, and starts it untouched; with the
    /// source of its frames and what presses it.
    pub(crate) fn start(run: &Run, limb: &Limb, seed: u64) -> Result<(Simulated, Self)> {
        let real = Arc::new(live_limb(run, limb)?);
        let device = virtual_device(&run.scene, Arc::clone(&real), &VirtualRigParams::default())?;
        let hands = Hands::new(&real, &virtual_hands(&run.scene, seed))?;
        let (link, port) = memory_link();
        let (mut tell, truth) = truth_line();
        let truths = Truths::default();
        let kept = truths.clone();
        let tell = move |frame: &TruthFrame| {
            kept.keep(frame);
            tell(frame);
        };
        let rig = spawn_rig(device, port, RunParams::default(), tell)?;
        let sim = Self { limb: real, hands, rig, truths };
        let source = StreamSource::new(link, StreamParams::default());
        Ok(((Box::new(source), truth), sim))
    }
}

impl Truths {
    fn keep(&self, frame: &TruthFrame) {
        let mut frames = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut place = if frames.len() == N_TRUTHS { frames.pop_front() } else { None };
        place.get_or_insert_default().clone_from(frame);
        frames.extend(place);
    }

    /// What pressed in the frame of that number; nothing where the frame is too old.
    fn of(&self, seq: u32) -> Vec<TrueContact> {
        let frames = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = frames.iter().rev().find(|frame| frame.seq == seq);
        found.map_or_else(Vec::new, |frame| frame.contacts.clone())
    }
}

/// What presses the virtual rig.
pub(super) struct VirtualPress {
    sim: Sim,
    press: PressHandle,
    start: Instant,
}

impl VirtualPress {
    pub(super) fn new(sim: Sim) -> Self {
        Self { press: sim.rig.press_handle(), sim, start: Instant::now() }
    }

    /// A finger presses there until it is lifted.
    pub(super) fn press(&mut self, finger: u32, point_m: [f64; 3], force_n: f64) {
        let now_s = self.now_s();
        self.sim.hands.press(finger, point_m, force_n, now_s);
    }

    pub(super) fn lift(&mut self, finger: u32) {
        let now_s = self.now_s();
        self.sim.hands.lift(finger, now_s);
    }

    pub(super) fn release(&mut self) {
        let now_s = self.now_s();
        self.sim.hands.release(now_s);
    }

    /// Whether it presses by itself while nobody does.
    pub(super) fn set_random(&mut self, is_random: bool) {
        self.sim.hands.set_random(is_random);
    }

    /// What pressed in the rig's frame of that number.
    pub(super) fn truth(&self, seq: u32) -> Vec<TrueContact> {
        self.sim.truths.of(seq)
    }

    /// What presses now; nothing while it tares.
    pub(super) fn step(&mut self, is_tared: bool) {
        let now_s = self.now_s();
        self.press.set(self.sim.hands.pressed(&self.sim.limb, is_tared, now_s));
    }

    fn now_s(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }
}

#[cfg(test)]
mod tests {
    use hapdef_rig::live::SurfacePoint;
    use nalgebra::{Point3, Vector3};

    use super::*;

    #[test]
    fn the_newest_truths_are_found_by_the_number_of_their_frame() {
        let truths = Truths::default();
        let contact = TrueContact {
            id: 0,
            point: SurfacePoint { face: 0, bary: [1.0, 0.0, 0.0] },
            position_m: Point3::origin(),
            normal: Vector3::z(),
            force_n: 1.0,
            shear_n: Vector3::zeros(),
        };
        let n = 2 * N_TRUTHS as u32;
        for seq in 0..n {
            let contacts = vec![TrueContact { id: seq, ..contact }];
            truths.keep(&TruthFrame { seq, contacts, ..TruthFrame::default() });
        }
        let id_of = |seq| truths.of(seq).first().map(|contact| contact.id);
        assert_eq!([0, N_TRUTHS as u32 - 1, n].map(id_of), [None; 3]);
        assert_eq!([N_TRUTHS as u32, n - 1].map(id_of), [Some(N_TRUTHS as u32), Some(n - 1)]);
    }
}
