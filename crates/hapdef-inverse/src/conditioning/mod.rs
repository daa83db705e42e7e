//! Conditioning: from raw readings to those of the contacts alone.
//!
//! What drifts is tracked only while nothing touches; a compensator that runs during a contact eats
//! it. Gauges that can't be believed are masked.

mod conditioner;
mod detector;
mod faults;
mod params;
mod tracker;

pub use conditioner::{Conditioned, Conditioner};
pub use params::ConditionerParams;
