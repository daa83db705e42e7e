//! Recalibration in use: known touches that come one by one let gains and zeros of the gauges follow what drifts.
//!
//! Model of a touch with the force F at p: y = (1 + γ) ∘ s(p, F) + o + |F| e(p) + n, with s what the calibrated map
//! says, γ the relative change of each gauge's gain since, o its zero, e(p) the map's error, per newton, and n noise
//! with the errors of the declared force and place. γ and o walk at random and are followed by a Kalman filter (Kalman,
//! A New Approach to Linear Filtering and Prediction Problems, 1960), which forgets by as much as they may have
//! drifted (Ljung & Gunnarsson, Adaptation and Tracking in System Identification, 1990). e(p) is the same
//! whenever the same place is touched, so those of the places touched are part of the state, as constant biases
//! (Friedland, Treatment of Bias in Recursive Filtering, 1969). So many touches of one place don't pass the map's
//! error there off as a gain, and yet show how the gains drift. A touch whose innovation is less probable than it
//! should be is refused (Bar-Shalom, Li & Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001,
//! section 5.4).

mod change;
mod filter;
mod output;
mod params;
mod places;
mod touch;

pub use change::GainChange;
pub use filter::Recalibration;
pub use output::TouchInfo;
pub use params::RecalibrationParams;
pub use touch::{KnownTouch, TouchZero};
