//! Calibration: a response map corrected by presses of known place and force.
//!
//! Model, per newton: y/A = g(p) + Σ θ h(p) + r(p) + n. Linear modes h say how the response changes
//! with what is known to be uncertain (gain, gauge shift and turn, stiffness); their coefficients θ
//! have Gaussian priors. r is a Gaussian process on the skin for each gauge. θ and r are found
//! together (universal kriging; Rasmussen & Williams, Gaussian Processes for Machine Learning, 2006,
//! section 2.7).

mod corrected;
mod evidence;
mod factor;
mod fit;
mod held_out;
mod kernel;
mod mode_fit;
mod next;
mod output;
mod params;
mod press;
mod regions;
mod reject;
mod residual;
mod samples;
mod solution;
mod spread;

pub use output::{
    BeyondPrior, Calibrated, CalibrationInfo, CurvePoint, HeldOutError, NextPress, RejectReason,
    RejectedPress,
};
pub use params::{CalibrationParams, ModeMap, ModeScope};
pub use press::Press;
pub use samples::LEAST_PRESSES;
