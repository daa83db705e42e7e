//! What is known of contacts after a frame of gauge readings.
//!
//! An estimator fills a [`Touch`]: its [`Contact`]s with their [`Uncertainty`], the [`Quality`] of the
//! explanation, the [`Alternative`]s. The runtime, the live page, ROS messages and Python take the same
//! types from there, so that a contact is converted only where it leaves for a file, a wire or an array.
//! A [`Wrench`] is the force and moment that contacts have together. A [`DrawnContact`] is what a sample or a probing
//! robot presses. The words of [`Phase`], [`WhyNot`], [`TouchPhase`], [`UnknownReason`] and [`GaugeHealth`] are those
//! of every JSON line.
//!
//! A [`LimbLoad`] is what loads the limb as a whole and is no contact.
//!
//! [`printable()`] is how text from outside is shown, whoever shows it.
//!
//! This crate knows nothing of skins, estimators, files or ports.

mod contact;
mod limb_load;
mod printable;
mod state;
mod touch;
mod uncertainty;
mod wrench;

pub use contact::{Contact, ContactRadius, DrawnContact};
pub use limb_load::LimbLoad;
pub use printable::{printable, printable_lines};
pub use state::{GaugeHealth, Phase, TouchPhase, UnknownReason, Verdict, WhyNot};
pub use touch::{Alternative, Quality, Touch};
pub use uncertainty::Uncertainty;
pub use wrench::{JointTorques, Wrench};

/// Contacts that an explanation may have at most.
pub const MAX_CONTACTS: usize = 6;
