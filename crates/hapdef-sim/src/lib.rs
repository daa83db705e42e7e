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

pub mod elements;

pub mod shell;

pub mod loads;

pub mod supports;

pub mod gauges;

pub mod system;

pub mod factor;

pub mod iterative;

pub mod model;

mod error;

pub use elements::{
    ElementMatrix, InvertedPoint, IsotropicMaterial, MassProperties, MaterialRegion,
    element_mass_kg, nodal_stress, patch_stress, space_gradients, stiffness, strain, stress,
};
pub use error::SimError;
pub use factor::Ordering;
pub use gauges::{GaugeParams, GaugeResponse, GaugeSite, GaugeStrain};
pub use iterative::{
    ChoiceReason, IterativeParams, MultigridInfo, MultigridParams, SolverChoice, SolverInfo,
    SolverKind,
};
pub use loads::{NodalLoad, PressedSkin};
pub use model::{
    Compliance, ComplianceParams, ElasticModel, ElasticParams, FactorEstimate, FactorInfo, Motion,
    Residuals, SolveInfo, SolveParams, StiffnessMatrix,
};
pub use shell::{
    ShellElementMatrix, ShellElementProblem, ShellGaugeStrain, ShellKind, ShellMesh,
    ShellMeshParams, ShellParams, ShellResultants, ShellStrain, shell_pressure_load,
    shell_stiffness, shell_traction_load,
};
pub use supports::{
    FloatingBody, Foundation, FoundationFaces, HeldMotion, Hold, RigidInsert, RigidMotion,
    Supports, SymmetryPlane,
};
pub use system::StiffnessExtremes;
