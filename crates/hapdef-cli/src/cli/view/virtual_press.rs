//! The virtual rig within the program: pressed from the page, by itself while nobody does.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use anyhow::Result;
use hapdef::{Limb, Run, VirtualRigParams, live_limb, virtual_device};
use hapdef_daq::source::{StreamParams, StreamSource, memory_link};
use hapdef_rig::live::{
    LiveLimb, Play, PressHandle, Pressed, RandomScriptParams, RunParams, RunningRig, TrueContact,
    TruthFrame, random_script, spawn_rig,
};
use nalgebra::Point3;

use crate::cli::sim::{Simulated, truth_line};

/// Contacts of the presses by itself, at most.
const MOST_CONTACTS: usize = 2;
/// Forces of the presses by itself, as shares of the scene's largest.
const SHARES: (f64, f64) = (0.15, 0.6);
/// From a release until it presses by itself again.
const REST: Duration = Duration::from_secs(4);
/// From the click of a press until it begins: what pressed before lets go, no contact jumps.
const LIFT: Duration = Duration::from_millis(150);
/// Number of the contact that the page's first finger presses.
const BY_HAND: u32 = 1000;
/// Frames of ground truth that the page can look back for: a quarter of a second at 1 kHz.
const N_TRUTHS: usize = 256;

/// The scene's virtual rig, running.
pub(crate) struct Sim {
    limb: Arc<LiveLimb>,
    play: Play,
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
        let contact = &run.scene.contact;
        let largest_n = contact.force_range_n[1];
        let range_n = (SHARES.0 * largest_n, SHARES.1 * largest_n);
        let n = contact.max_contacts.min(MOST_CONTACTS);
        let params = RandomScriptParams::new(n, contact.min_spacing_m, range_n, seed);
        let play = Play::new(&random_script(&real, &params), &real)?;
        let (link, port) = memory_link();
        let (mut tell, truth) = truth_line();
        let truths = Truths::default();
        let kept = truths.clone();
        let tell = move |frame: &TruthFrame| {
            kept.keep(frame);
            tell(frame);
        };
        let rig = spawn_rig(device, port, RunParams::default(), tell)?;
        let sim = Self { limb: real, play, rig, truths };
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
    /// What each finger on the page presses.
    by_hand: Vec<Pressed>,
    clicked: Instant,
    /// It presses by itself while nobody does.
    is_random: bool,
    rests_since: Option<Instant>,
    start: Option<Instant>,
    contacts: Vec<TrueContact>,
}

impl VirtualPress {
    pub(super) fn new(sim: Sim) -> Self {
        Self {
            press: sim.rig.press_handle(),
            sim,
            by_hand: Vec::new(),
            clicked: Instant::now(),
            is_random: true,
            rests_since: None,
            start: None,
            contacts: Vec::new(),
        }
    }

    /// A finger presses there until it is lifted.
    pub(super) fn press(&mut self, finger: u32, point_m: [f64; 3], force_n: f64) {
        if self.by_hand.is_empty() {
            self.clicked = Instant::now();
        }
        let pressed = Pressed::normal(BY_HAND + finger, Point3::from(point_m), force_n);
        match self.by_hand.iter_mut().find(|before| before.id == pressed.id) {
            Some(before) => *before = pressed,
            None => self.by_hand.push(pressed),
        }
    }

    pub(super) fn lift(&mut self, finger: u32) {
        self.by_hand.retain(|pressed| pressed.id != BY_HAND + finger);
        self.rests_since = Some(Instant::now());
    }

    pub(super) fn release(&mut self) {
        self.by_hand.clear();
        self.rests_since = Some(Instant::now());
    }

    /// Whether it presses by itself while nobody does.
    pub(super) fn set_random(&mut self, is_random: bool) {
        self.is_random = is_random;
        self.rests_since = None;
    }

    /// What pressed in the rig's frame of that number.
    pub(super) fn truth(&self, seq: u32) -> Vec<TrueContact> {
        self.sim.truths.of(seq)
    }

    /// What presses now; nothing while it tares.
    pub(super) fn step(&mut self, is_tared: bool) {
        let rests = self.rests_since.is_some_and(|since| since.elapsed() < REST);
        let pressed = match self.by_hand.as_slice() {
            _ if !is_tared => Vec::new(),
            [] if rests || !self.is_random => Vec::new(),
            [] => self.by_itself(),
            _ if self.clicked.elapsed() < LIFT => Vec::new(),
            by_hand => by_hand.to_vec(),
        };
        self.press.set(pressed);
    }

    fn by_itself(&mut self) -> Vec<Pressed> {
        let t_s = self.start.get_or_insert_with(Instant::now).elapsed().as_secs_f64();
        self.contacts.clear();
        self.sim.play.at(t_s, &self.sim.limb, &mut self.contacts);
        let pressed = |contact: &TrueContact| Pressed {
            id: contact.id,
            position_m: contact.position_m,
            force_n: contact.force_n,
            shear_n: contact.shear_n,
        };
        self.contacts.iter().map(pressed).collect()
    }
}

#[cfg(test)]
mod tests {
    use hapdef_rig::live::SurfacePoint;
    use nalgebra::Vector3;

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
