//! Conditioning: from raw readings to those of the contacts alone.
//!
//! What drifts is tracked only while nothing touches; a compensator that runs during a contact eats
//! it. Gauges that can't be believed are masked.

mod conditioned;
mod conditioner;
mod detector;
mod drift;
mod faults;
mod held;
mod limits;
mod line;
mod load_fit;
mod params;
mod tare;
mod tracker;

pub use conditioned::{Conditioned, DriftState, MoveKind, TareEnd, TareMove};
pub use conditioner::Conditioner;
pub use params::ConditionerParams;
