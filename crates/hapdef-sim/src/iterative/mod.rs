//! The iterative path: conjugate gradients preconditioned by one multigrid V-cycle.
//!
//! Ten-node tetrahedra are first restricted to their corner nodes (`CornerInterpolation`), where
//! the Galerkin matrix is that of linear tetrahedra; below that, smoothed aggregation with the six
//! rigid modes of each aggregate. Eight right-hand sides share each pass over the matrices. Memory
//! is linear in the number of equations. Nothing here knows of meshes but the interpolation.

mod aggregate;
mod bottom;
mod bsr;
mod choice;
mod hierarchy;
mod interpolation;
mod multigrid;
mod near_null;
mod pcg;
mod plan;
mod ritz;
mod smoother;
mod solver;
#[cfg(test)]
mod tests;
mod vectors;

pub use choice::{ChoiceReason, SolverChoice, SolverInfo, SolverKind};
pub use hierarchy::MultigridParams;
use interpolation::CornerInterpolation;
pub use multigrid::MultigridInfo;
use multigrid::{Multigrid, NearNull};
use near_null::rigid_modes;
pub use pcg::IterativeParams;
pub(crate) use pcg::{Measure, Reached, WIDEST};
pub(crate) use plan::SolverPlan;
pub(crate) use solver::{Iterative, Solver};
