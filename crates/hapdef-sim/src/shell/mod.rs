//! The triangular shell with six degrees of freedom a node: displacement and rotation.
//!
//! Both kinds share the frame (`facet`) and the membrane (`membrane`); they differ in bending.
//!
//! | kind | bending | transverse shear | holds for |
//! |---|---|---|---|
//! | [`ShellKind::Thick`] | MITC3+ | first order, factor 5/6, stabilised | tested to walls of a seventh of the radius and half the width; the default |
//! | [`ShellKind::Thin`] | DKT | none | walls thinner than a twentieth of span, width and radius |
//!
//! The default is the thick kind: on thin shells it is as good as the thin one mesh by mesh, and
//! where a wall is as wide as a few thicknesses only it holds (torsion of strips, the Raasch hook:
//! the thin kind is 4 to 28 % too stiff there). Prefer the thin kind under point forces, whose own
//! displacement grows with refinement in the thick one.
//!
//! Known limits: a bending-dominated shell of t/L = 1e-5 needs about 64 cells a side for 5 % in
//! energy (t/L ≥ 1e-4: 32 cells for 1 %); beams in their own plane need four cells of height; one
//! facet should turn by less than 60° from the surface's normal at its corners.

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
mod problem;
mod quadrature;
mod recovery;

pub use element::{ShellElementMatrix, ShellKind, shell_stiffness};
pub use gauge::ShellGaugeStrain;
pub use load::{shell_pressure_load, shell_traction_load};
pub use mesh::{ShellMesh, ShellMeshParams};
pub use model::ShellParams;
pub use problem::ShellElementProblem;
pub use recovery::{ShellResultants, ShellStrain};
