//! Loads as forces and moments on FE nodes.

pub(crate) mod nodal;
pub(crate) mod patch;
mod thermal;
mod whole_limb;

pub use nodal::NodalLoad;
pub use patch::PressedSkin;
pub use whole_limb::LoadedLimb;
