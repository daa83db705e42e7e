//! Linear-elastic statics of a limb: a mesh of ten-node tetrahedra, clamped nodes and a material
//! become one factored [`ElasticModel`]; everything else is a right-hand side.
//!
//! - [`NodalLoad`]: point forces, tips pressing on the skin, tractions, pressures, body forces.
//! - [`ElasticModel::solve`] and [`ElasticModel::compliance`]: displacements for one load, or at
//!   wanted nodes for thousands.
//! - [`ShellMesh`] and [`ElasticModel::build_shell`]: thin walls as triangles with rotations, with
//!   tips and [`ShellGaugeStrain`] on them.
//! - [`LinearFunctional`] and [`ElasticModel::response`]: what a sensor (a [`GaugeStrain`], say)
//!   reads for a force anywhere, by one adjoint solve each.
//!
//! A bar held at one end, pulled at the other, and the strain of a gauge on its top:
//!
//! ```
//! use hapdef_mesh::Tet10Mesh;
//! use hapdef_sim::{ElasticModel, ElasticParams, IsotropicMaterial, NodalLoad};
//! use hapdef_sim::{GaugeSite, GaugeStrain};
//! use nalgebra::{Point3, Vector3};
//!
//! let mesh = Tet10Mesh::block([0.1, 0.02, 0.01], [10, 2, 1])?;
//! let clamped = mesh.nodes_where(|p| p.x == 0.0);
//! let aluminium = IsotropicMaterial::new(70e9, 0.33, 2700.0)?;
//! let model = ElasticModel::build(&mesh, &ElasticParams::new(aluminium, clamped))?;
//! let load = NodalLoad::pressure(&mesh, &mesh.faces_where(|p| p.x == 0.1), -7e6)?;
//! let (displacement, _) = model.solve(&load)?;
//! let site = GaugeSite {
//!     position: Point3::new(0.06, 0.01, 0.01),
//!     axis: Vector3::x(),
//!     length_m: 0.008,
//!     width_m: 0.005,
//! };
//! let gauge = GaugeStrain::new(&mesh, &mesh.boundary().faces, &site)?;
//! let strain_ue = gauge.strain(&displacement) * 1e6;
//! assert!((strain_ue - 100.0).abs() < 0.5, "{strain_ue} µε");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
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
    tet_rule,
};
pub use error::SimError;
pub use factor::Ordering;
pub use gauges::{
    GaugeParams, GaugeResponse, GaugeSite, GaugeStrain, LinearFunctional, NodeWeight,
};
pub use hapdef_contact::LimbLoad;
pub use iterative::{
    ChoiceReason, IterativeParams, MultigridInfo, MultigridParams, SolverChoice, SolverInfo,
    SolverKind,
};
pub use loads::{LoadedLimb, NodalLoad, PressedSkin};
pub use model::{
    Compliance, ComplianceParams, ElasticModel, ElasticParams, FactorInfo, Motion, Residuals,
    SolveInfo, SolveParams, StiffnessMatrix,
};
pub use shell::{
    ShellElementMatrix, ShellElementProblem, ShellGaugeStrain, ShellKind, ShellMesh,
    ShellMeshParams, ShellParams, ShellResultants, ShellStrain, shell_pressure_load,
    shell_stiffness, shell_traction_load,
};
pub use supports::{
    FloatingBody, Foundation, FoundationFaces, HeldMotion, Hold, RigidBody, RigidMotion, Supports,
    SymmetryPlane,
};
pub use system::StiffnessExtremes;
