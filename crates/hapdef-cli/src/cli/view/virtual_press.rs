//! The virtual rig within the program: pressed from the page, by itself while nobody does.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Result;
use hapdef::{Limb, Run, VirtualRigParams, live_limb, virtual_device};
use hapdef_daq::source::{StreamParams, StreamSource, memory_link};
use hapdef_rig::live::{
    LiveLimb, Play, PressHandle, Pressed, RandomScriptParams, RunParams, RunningRig, TrueContact,
    random_script, spawn_rig,
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
/// Number of the contact that is pressed from the page.
const BY_HAND: u32 = 1000;

/// The scene's virtual rig, running.
pub(crate) struct Sim {
    limb: Arc<LiveLimb>,
    play: Play,
    rig: RunningRig,
}

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
        let (tell, truth) = truth_line();
        let rig = spawn_rig(device, port, RunParams::default(), tell)?;
        let sim = Self { limb: real, play, rig };
        let source = StreamSource::new(link, StreamParams::default());
        Ok(((Box::new(source), truth), sim))
    }
}

/// What presses the virtual rig.
pub(super) struct VirtualPress {
    sim: Sim,
    press: PressHandle,
    by_hand: Option<Pressed>,
    clicked: Instant,
    rests_since: Option<Instant>,
    start: Option<Instant>,
    contacts: Vec<TrueContact>,
}

impl VirtualPress {
    pub(super) fn new(sim: Sim) -> Self {
        Self {
            press: sim.rig.press_handle(),
            sim,
            by_hand: None,
            clicked: Instant::now(),
            rests_since: None,
            start: None,
            contacts: Vec::new(),
        }
    }

    /// Presses there until [`Self::release`].
    pub(super) fn press(&mut self, point_m: [f64; 3], force_n: f64) {
        if self.by_hand.is_none() {
            self.clicked = Instant::now();
        }
        self.by_hand = Some(Pressed::normal(BY_HAND, Point3::from(point_m), force_n));
    }

    pub(super) fn release(&mut self) {
        self.by_hand = None;
        self.rests_since = Some(Instant::now());
    }

    /// What presses now; nothing while it tares.
    pub(super) fn step(&mut self, is_tared: bool) {
        let rests = self.rests_since.is_some_and(|since| since.elapsed() < REST);
        let pressed = match self.by_hand {
            _ if !is_tared => Vec::new(),
            Some(_) if self.clicked.elapsed() < LIFT => Vec::new(),
            Some(by_hand) => vec![by_hand],
            None if rests => Vec::new(),
            None => self.by_itself(),
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
