//! The triangular shell with six degrees of freedom a node: displacement and rotation.
//!
//! Both kinds share the frame ([`facet`]) and the membrane ([`membrane`]); they differ in bending.
//!
//! | kind | bending | transverse shear | holds for |
//! |---|---|---|---|
//! | [`ShellKind::Thick`] | MITC3+ | first order, factor 5/6 | any wall thinner than its radius; the default |
//! | [`ShellKind::Thin`] | DKT | none | walls thinner than a twentieth of span and radius; converges on coarser meshes |

mod bending_thick;
mod bending_thin;
mod element;
mod facet;
mod gauge;
mod load;
mod membrane;
mod mesh;
mod mesh_load;
mod model;
mod patch;
mod quadrature;
mod recovery;

pub use element::{ShellElementMatrix, ShellElementProblem, ShellKind, shell_stiffness};
pub use gauge::ShellGaugeStrain;
pub use load::{shell_pressure_load, shell_traction_load};
pub use mesh::{ShellMesh, ShellMeshParams};
pub use model::ShellParams;
pub use recovery::{ShellResultants, ShellStrain};
