//! Loads as forces and moments on FE nodes.

pub(crate) mod nodal;
pub(crate) mod patch;
mod thermal;

pub use nodal::NodalLoad;
pub use patch::PressedSkin;
