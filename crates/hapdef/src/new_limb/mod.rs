//! A limb from whatever file there is of it: what is not stated is guessed, each guess with its reason,
//! and a folder with skin and scene is written.

mod collada;
mod gauges;
mod given;
mod guess;
mod skin;
mod text;
mod urdf;
mod write;

use std::path::Path;

use hapdef_mesh::LengthUnit;

pub(crate) use guess::HELD_SHARE;
pub use skin::WallChoice;
pub(crate) use skin::{SKIN, Skin, SkinParams, WALL, is_fold};
pub use write::NewLimbFiles;

use crate::error::HapdefError;
use crate::scene::{Axis, LimbEnd, WallSolver};
use given::Given;

/// What is stated of a limb; what is not is guessed.
#[derive(Clone, Debug)]
pub struct NewLimbParams {
    /// The link of a URDF.
    pub link: Option<String>,
    /// Unit of the file's lengths.
    pub unit: Option<LengthUnit>,
    /// Direction of the long axis.
    pub axis: Option<[f64; 3]>,
    /// The end along the axis that is held.
    pub mount_end: Option<LimbEnd>,
    /// The joint of a URDF's link that holds it: the end nearer to it is held.
    pub mount_joint: Option<String>,
    /// How far from that end, m.
    pub mount_m: Option<f64>,
    /// Thickness of a skin's wall, m.
    pub wall_m: Option<f64>,
    /// What a skin's wall is solved as.
    pub solver: WallSolver,
    /// Edge length of the skin, m.
    pub edge_m: Option<f64>,
    /// Gauges; as many as see everywhere where no number is stated.
    pub n_gauges: Option<usize>,
    /// Whether the likeliest is taken where two answers are plausible.
    pub takes_likeliest: bool,
}

impl Default for NewLimbParams {
    /// All guessed, nothing taken that is not sure.
    fn default() -> Self {
        Self {
            link: None,
            unit: None,
            axis: None,
            mount_end: None,
            mount_joint: None,
            mount_m: None,
            wall_m: None,
            solver: WallSolver::Auto,
            edge_m: None,
            n_gauges: None,
            takes_likeliest: false,
        }
    }
}

/// Something that is known of a limb, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Guess {
    /// What it is: unit, axis, mount, …
    pub what: &'static str,
    /// The value in words.
    pub value: String,
    /// Why that one; which flag states another one.
    pub why: String,
}

/// A limb of which everything is known or guessed that its scene needs, but the gauges' places.
#[derive(Clone, Debug)]
pub struct NewLimb {
    given: Given,
    /// Everything guessed or stated, in the order it was found.
    pub guesses: Vec<Guess>,
    axis: Axis,
    mount: serde_json::Value,
    contact: serde_json::Value,
    wall_m: f64,
    params: NewLimbParams,
}

impl NewLimb {
    /// Reads `path` and guesses what is not stated.
    ///
    /// # Errors
    /// [`HapdefError::Unsure`] where two answers are plausible or none is, naming the flag that states
    /// it; [`HapdefError::NewLimb`] for what no limb can be made of; [`HapdefError::Mesh`] for a file
    /// that can't be read.
    pub fn guess(path: &Path, params: &NewLimbParams) -> Result<Self, HapdefError> {
        let mut guesses = Vec::new();
        let given = given::read(path, params, &mut guesses)?;
        let axis = guess::axis(&given, params, &mut guesses);
        let mount = guess::mount(&given, &axis, params, &mut guesses)?;
        let wall_m = guess::wall(&given, params, &mut guesses)?;
        let contact = guess::contact(wall_m, &mut guesses);
        guess::material(&given, &mut guesses);
        Ok(Self { given, guesses, axis, mount, contact, wall_m, params: params.clone() })
    }
}
