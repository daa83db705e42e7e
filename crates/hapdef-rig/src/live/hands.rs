//! Who presses a virtual limb that people see: their fingers, and by itself while nobody does.

use nalgebra::Point3;

use super::limb::LiveLimb;
use super::play::Play;
use super::press::{Pressed, TrueContact};
use super::random::{RandomScriptParams, random_script};
use crate::error::RigError;

/// Contacts of the presses by itself, at most.
const MOST_CONTACTS: usize = 2;
/// Forces of the presses by itself, as shares of the largest.
const SHARES: (f64, f64) = (0.15, 0.6);
/// From a release until it presses by itself again, s.
const REST_S: f64 = 4.0;
/// From the click of a press until it begins: what pressed before lets go, no contact jumps, s.
const LIFT_S: f64 = 0.15;
/// Number of the contact that the first finger presses.
const BY_HAND: u32 = 1000;

/// How a limb is pressed by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandsParams {
    /// Contacts at a time at most, of which it makes no more than two.
    pub max_contacts: usize,
    /// Least distance of two contacts, m.
    pub spacing_m: f64,
    /// Largest force, N; it presses with 15 % to 60 % of that.
    pub largest_n: f64,
    /// Seed.
    pub seed: u64,
}

/// Fingers on a limb, and random presses while there are none. Times are s from any origin and never go back.
#[derive(Clone, Debug)]
pub struct Hands {
    play: Play,
    fingers: Vec<Pressed>,
    clicked_s: f64,
    is_random: bool,
    rests_since_s: Option<f64>,
    start_s: Option<f64>,
    contacts: Vec<TrueContact>,
}

impl Hands {
    /// No finger; it presses by itself.
    ///
    /// # Errors
    /// [`RigError::Script`] where the random presses have no place on the limb.
    pub fn new(limb: &LiveLimb, params: &HandsParams) -> Result<Self, RigError> {
        let range_n = (SHARES.0 * params.largest_n, SHARES.1 * params.largest_n);
        let n = params.max_contacts.min(MOST_CONTACTS);
        let script = RandomScriptParams::new(n, params.spacing_m, range_n, params.seed);
        Ok(Self {
            play: Play::new(&random_script(limb, &script), limb)?,
            fingers: Vec::new(),
            clicked_s: 0.0,
            is_random: true,
            rests_since_s: None,
            start_s: None,
            contacts: Vec::new(),
        })
    }

    /// A finger presses there until it is lifted.
    pub fn press(&mut self, finger: u32, point_m: [f64; 3], force_n: f64, now_s: f64) {
        if self.fingers.is_empty() {
            self.clicked_s = now_s;
        }
        let id = BY_HAND.saturating_add(finger);
        let pressed = Pressed::normal(id, Point3::from(point_m), force_n);
        match self.fingers.iter_mut().find(|before| before.id == id) {
            Some(before) => *before = pressed,
            None => self.fingers.push(pressed),
        }
    }

    /// A finger lets go.
    pub fn lift(&mut self, finger: u32, now_s: f64) {
        self.fingers.retain(|pressed| pressed.id != BY_HAND.saturating_add(finger));
        self.rests_since_s = Some(now_s);
    }

    /// All fingers let go.
    pub fn release(&mut self, now_s: f64) {
        self.fingers.clear();
        self.rests_since_s = Some(now_s);
    }

    /// Whether it presses by itself while nobody does.
    pub fn set_random(&mut self, is_random: bool) {
        self.is_random = is_random;
        self.rests_since_s = None;
    }

    /// What presses now; nothing while it tares.
    pub fn pressed(&mut self, limb: &LiveLimb, is_tared: bool, now_s: f64) -> Vec<Pressed> {
        let rests = self.rests_since_s.is_some_and(|since_s| now_s - since_s < REST_S);
        match self.fingers.as_slice() {
            _ if !is_tared => Vec::new(),
            [] if rests || !self.is_random => Vec::new(),
            [] => self.by_itself(limb, now_s),
            _ if now_s - self.clicked_s < LIFT_S => Vec::new(),
            fingers => fingers.to_vec(),
        }
    }

    fn by_itself(&mut self, limb: &LiveLimb, now_s: f64) -> Vec<Pressed> {
        let start_s = *self.start_s.get_or_insert(now_s);
        self.contacts.clear();
        self.play.at(now_s - start_s, limb, &mut self.contacts);
        let pressed = |contact: &TrueContact| Pressed {
            id: contact.id,
            position_m: contact.position_m,
            force_n: contact.force_n,
            shear_n: contact.shear_n,
        };
        self.contacts.iter().map(pressed).collect()
    }
}
