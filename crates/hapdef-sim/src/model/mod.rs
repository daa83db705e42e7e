//! The elastic model of a limb, and what it answers: displacements for a load or for thousands.

mod compliance;
mod condition;
pub(crate) mod elastic_model;
mod estimate;
mod export;
mod iterative_loads;
mod rigidity;
pub(crate) mod solve;
mod solve_block;
pub(crate) mod solve_info;
pub(crate) mod solved_block;
pub(crate) mod structure;
mod wanted;

pub use compliance::{Compliance, ComplianceParams, Residuals};
pub use elastic_model::{ElasticModel, ElasticParams};
pub use export::StiffnessMatrix;
pub use solve_info::{SolveInfo, SolveParams};
pub use solved_block::Motion;
pub use structure::FactorInfo;
