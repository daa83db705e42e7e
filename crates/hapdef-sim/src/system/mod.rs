//! The linear system: its stiffness matrix, and the residual of its solutions.

pub(crate) mod assembly;
mod extended;
pub(crate) mod product;

pub use assembly::StiffnessExtremes;
