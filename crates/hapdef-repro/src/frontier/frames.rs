//! What the rig is pressed with: for calibrations, for errors, for times, at once and one after the
//! other.

use anyhow::Result;
use hapdef::scene::Scene;

use super::configuration::MOST_PRESSES;
use crate::compare::cells::{Drawn, LEAST_N};
use crate::compare::sequence::Script;
use crate::compare::world::{Frame, World};

/// Frames of two contacts that are timed at least, and the rounds that share them.
const MIN_TIMED: usize = 1000;
const ROUNDS: usize = 5;

/// First noise seeds of the scripts of one contact and of two.
const SINGLE_STREAM: u64 = 100_000;
const DOUBLE_STREAM: u64 = 200_000;

/// Everything that is pressed, drawn once for all configurations.
pub(super) struct Frames {
    /// Single contacts of calibrations.
    pub(super) presses: Vec<Frame>,
    /// Frames of one contact.
    pub(super) singles: Vec<Frame>,
    /// Frames of two contacts; as many as of one are scored, all are timed.
    pairs: Vec<Frame>,
    /// The contact of every single frame as it comes.
    pub(super) single_scripts: Vec<Scripted>,
    /// The contacts of every scored pair as they come one after the other.
    pub(super) double_scripts: Vec<Scripted>,
}

/// Contacts that come one after another, and what is read until all have been there for a while.
pub(super) struct Scripted {
    pub(super) script: Script,
    /// `[n_frames][n_channels]`, µε.
    pub(super) readings_ue: Vec<Vec<f64>>,
}

impl Frames {
    /// `n` scored frames of one contact and of two, at least one.
    pub(super) fn draw(world: &World, scene: &Scene, seed: u64, n: usize) -> Result<Self> {
        let drawn = Drawn { world, scene, seed };
        let (singles, pairs) = (drawn.singles(n)?, drawn.doubles(n.max(MIN_TIMED))?);
        Ok(Self {
            presses: drawn.presses(MOST_PRESSES)?,
            single_scripts: scripted(world, &singles, SINGLE_STREAM)?,
            double_scripts: scripted(world, &pairs[..n], DOUBLE_STREAM)?,
            singles,
            pairs,
        })
    }

    /// The scored frames of two contacts.
    pub(super) fn doubles(&self) -> &[Frame] {
        &self.pairs[..self.singles.len()]
    }

    /// The timed frames of two contacts, round by round.
    pub(super) fn rounds(&self) -> impl Iterator<Item = &[Frame]> {
        self.pairs.chunks(self.pairs.len().div_ceil(ROUNDS))
    }

    /// The scripts of two contacts, round by round.
    pub(super) fn script_rounds(&self) -> impl Iterator<Item = &[Scripted]> {
        let n = self.double_scripts.len();
        self.double_scripts.chunks(n.div_ceil(ROUNDS))
    }
}

/// The contacts of frames one after another; `stream` seeds the noise of the first.
fn scripted(world: &World, frames: &[Frame], stream: u64) -> Result<Vec<Scripted>> {
    let scripted = |(i, frame): (usize, &Frame)| {
        let contacts = frame.contacts.clone();
        let (script, n_frames) = Script::new(contacts).first(frame.contacts.len());
        let mut readings_ue = script.readings(world, stream + i as u64)?;
        readings_ue.truncate(n_frames);
        Ok(Scripted { script, readings_ue })
    };
    frames.iter().enumerate().map(scripted).collect()
}

/// The contacts of the scored frames in words.
pub(super) fn contacts_in_words(scene: &Scene) -> String {
    let presses = &scene.rig.presses;
    let [weakest, strongest] = scene.contact.force_range_n;
    let [near, far] = presses.spacing_range_m.map(|m| m * 1e3);
    let held = presses.held_force_n;
    format!(
        "One contact: {LEAST_N} to {strongest} N; two: {held} N and {weakest} to {strongest} N, \
         {near:.0} to {far:.0} mm apart"
    )
}
