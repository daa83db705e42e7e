//! Linear-elastic statics of a limb: a mesh of ten-node tetrahedra, clamped nodes and a material
//! become one factored [`ElasticModel`]; everything else is a right-hand side.
//!
//! - [`NodalLoad`]: point forces, tips pressing on the skin, tractions, pressures, body forces.
//! - [`ElasticModel::solve`] and [`ElasticModel::compliance`]: displacements for one load, or at
//!   wanted nodes for thousands.
//! - [`GaugeStrain`] and [`ElasticModel::gauge_response`]: what a strain gauge reads for a force
//!   anywhere, by one adjoint solve per gauge.
//!
//! Knows nothing of networks, ports or scenes. SI units throughout, f64 throughout. Results are the
//! same bit for bit on any number of threads, and every solution comes with its residual.

mod assembly;
mod compliance;
mod elastic_model;
mod element;
mod elements;
mod error;
mod factor;
mod gauge;
mod gauge_response;
mod load;
mod mass;
mod material;
mod null_space;
mod ordering;
mod parts;
mod patch_load;
mod patch_stress;
mod quadrature;
mod rigid_modes;
mod rigidity;
mod solve;
mod stress;
mod supports;
mod thermal_load;
mod unknowns;
mod wall;

pub use assembly::StiffnessExtremes;
pub use compliance::{Compliance, ComplianceParams};
pub use elastic_model::{ElasticModel, ElasticParams, FactorInfo, Motion};
pub use element::{ElementMatrix, InvertedPoint, space_gradients, stiffness, strain};
pub use error::SimError;
pub use gauge::{GaugeParams, GaugeSite, GaugeStrain};
pub use gauge_response::GaugeResponse;
pub use load::NodalLoad;
pub use mass::{MassProperties, element_mass_kg};
pub use material::IsotropicMaterial;
pub use patch_stress::patch_stress;
pub use rigid_modes::{FloatingBody, RigidMotion};
pub use solve::{SolveInfo, SolveParams};
pub use stress::{nodal_stress, stress};
pub use supports::{
    Foundation, FoundationFaces, HeldMotion, Hold, MaterialRegion, RigidInsert, Supports,
    SymmetryPlane,
};
