//! A simulated stand-in for the hardware: a limb that differs from the one the nets are trained
//! on, gauges that are not quite where the drawing has them, electronics, and a probing robot.
//!
//! Everything here is **simulated**. The limb is solved on another mesh than the training side's,
//! its stiffness and wall thickness vary smoothly, and every perturbation draws from a seed of its
//! own. Entry points: [`RealLimb::build`] for the mechanics, [`Electronics`] for the readings,
//! [`single_presses`] and [`double_presses`] for what the probing robot does.
//!
//! Feature `live`: the limb as a device that speaks HDP1, see the module `live`. Without the feature `solve`
//! nothing is solved: a [`live::LiveLimb`] is made of what was solved elsewhere, also in a browser.
//!
//! Knows nothing of estimators, networks or scenes.

mod electronics;
mod error;
#[cfg(feature = "solve")]
mod field;
#[cfg(feature = "live")]
pub mod live;
#[cfg(feature = "solve")]
mod misplace;
#[cfg(feature = "solve")]
mod nominal_limb;
mod params;
mod prober;
#[cfg(feature = "solve")]
mod real_limb;
#[cfg(feature = "solve")]
mod warp;

pub use electronics::Electronics;
pub use error::RigError;
#[cfg(feature = "solve")]
pub use field::SmoothField;
#[cfg(feature = "solve")]
pub use nominal_limb::{NominalLimb, NominalLoads};
pub use params::{ElectronicsParams, GainParams, MisplacementParams, RigParams, VariationParams};
pub use prober::{DoublePressParams, SinglePressParams, double_presses, single_presses};
#[cfg(feature = "solve")]
pub use real_limb::{RealLimb, RealLimbInfo};
