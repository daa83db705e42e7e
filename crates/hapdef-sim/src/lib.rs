//! Linear-elastic statics of a limb: a mesh of ten-node tetrahedra, clamped nodes and a material
//! become one factored [`ElasticModel`]; everything else is a right-hand side.
//!
//! - [`NodalLoad`]: point forces, tips pressing on the skin, tractions, pressures, body forces.
//! - [`ElasticModel::solve`] and [`ElasticModel::compliance`]: displacements for one load, or at
//!   wanted nodes for thousands.
//! - [`ShellMesh`] and [`ElasticModel::build_shell`]: thin walls as triangles with rotations, with
//!   tips and [`ShellGaugeStrain`] on them.
//! - [`GaugeStrain`] and [`ElasticModel::gauge_response`]: what a strain gauge reads for a force
//!   anywhere, by one adjoint solve per gauge.
//!
//! Knows nothing of networks, ports or scenes. SI units throughout, f64 throughout. Results are the
//! same bit for bit on any number of threads, and every solution comes with its residual.

mod analysis;
mod assembly;
mod compliance;
mod condition;
mod dissection;
mod elastic_model;
mod element;
mod element_rounding;
mod elements;
mod error;
mod export;
mod extended;
mod factor;
mod factor_estimate;
mod front;
mod gauge;
mod gauge_response;
mod iterative;
mod load;
mod mass;
mod material;
mod null_space;
mod ordering;
mod panel;
mod parts;
mod patch_load;
mod patch_stress;
mod product;
mod quadrature;
mod rigid_modes;
mod rigidity;
mod shell;
mod solve;
mod solve_block;
mod solve_info;
mod stress;
mod structure;
mod supports;
mod thermal_load;
mod triangular;
mod unknowns;
mod wall;
mod wanted;

pub use assembly::StiffnessExtremes;
pub use compliance::{Compliance, ComplianceParams, Residuals};
pub use dissection::Ordering;
pub use elastic_model::{ElasticModel, ElasticParams, FactorInfo, Motion};
pub use element::{ElementMatrix, InvertedPoint, space_gradients, stiffness, strain};
pub use error::SimError;
pub use export::StiffnessMatrix;
pub use factor_estimate::FactorEstimate;
pub use gauge::{GaugeParams, GaugeSite, GaugeStrain};
pub use gauge_response::GaugeResponse;
pub use iterative::{
    ChoiceReason, IterativeParams, MultigridInfo, MultigridParams, SolverChoice, SolverInfo,
    SolverKind,
};
pub use load::NodalLoad;
pub use mass::{MassProperties, element_mass_kg};
pub use material::IsotropicMaterial;
pub use patch_load::PressedSkin;
pub use patch_stress::patch_stress;
pub use rigid_modes::{FloatingBody, RigidMotion};
pub use shell::{
    ShellElementMatrix, ShellElementProblem, ShellGaugeStrain, ShellKind, ShellMesh,
    ShellMeshParams, ShellParams, ShellResultants, ShellStrain, shell_pressure_load,
    shell_stiffness, shell_traction_load,
};
pub use solve_info::{SolveInfo, SolveParams};
pub use stress::{nodal_stress, stress};
pub use supports::{
    Foundation, FoundationFaces, HeldMotion, Hold, MaterialRegion, RigidInsert, Supports,
    SymmetryPlane,
};
