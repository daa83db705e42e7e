//! What a solver needs of the mesh and its supports, whatever the stiffness.

use std::sync::Arc;

use super::aggregate::Modes;
use super::choice::choose;
use super::{
    ChoiceReason, CornerInterpolation, Iterative, IterativeParams, Solver, SolverChoice,
    SolverInfo, SolverKind, rigid_modes,
};
use crate::SimError;
use crate::elements::element_set::Elements;
use crate::factor::cholesky::{Analysis, Factor};
use crate::supports::unknowns::Unknowns;
use crate::system::assembly::{BlockMatrix, BlockPattern};

/// The solver chosen for a pattern, and what it takes from there.
#[derive(Debug)]
pub(crate) struct SolverPlan {
    reason: ChoiceReason,
    path: Path,
}

#[derive(Debug)]
enum Path {
    Direct(Arc<Analysis>),
    Iterative {
        corners: Option<CornerInterpolation>,
        modes: Vec<Modes<3>>,
        params: IterativeParams,
    },
}

impl SolverPlan {
    /// `pattern` is in elimination order.
    pub(crate) fn build(
        choice: SolverChoice,
        elements: &dyn Elements,
        unknowns: &Unknowns,
        pattern: &BlockPattern,
    ) -> Result<Self, SimError> {
        let (kind, reason, params) = choose(choice, pattern)?;
        let path = match kind {
            SolverKind::Direct => Path::Direct(Arc::new(Analysis::build(pattern)?)),
            SolverKind::Iterative => Path::Iterative {
                corners: CornerInterpolation::build(elements, unknowns),
                modes: rigid_modes(elements.positions(), unknowns),
                params,
            },
        };
        Ok(Self { reason, path })
    }

    /// The solver of `stiffness`; call inside the thread pool.
    pub(crate) fn solver(
        &self,
        stiffness: &BlockMatrix,
        unknowns: &Unknowns,
    ) -> Result<Solver, SimError> {
        let solver = match &self.path {
            Path::Direct(analysis) => {
                Factor::build(stiffness, Arc::clone(analysis)).map(Solver::Direct)
            }
            Path::Iterative { corners, modes, params } => {
                let iterative = Iterative::build(stiffness, modes, corners.as_ref(), *params);
                iterative.map(|iterative| Solver::Iterative(Box::new(iterative)))
            }
        };
        solver.map_err(|error| name_node(error, unknowns))
    }

    /// Operations of the factorisation; zero without one.
    pub(crate) fn factor_flops(&self) -> f64 {
        match &self.path {
            Path::Direct(analysis) => analysis.factor_flops(),
            Path::Iterative { .. } => 0.0,
        }
    }

    /// Non-zeros of the factor, and entries as stored; zero without one.
    pub(crate) fn fill(&self) -> (usize, usize) {
        match &self.path {
            Path::Direct(analysis) => (analysis.nnz_l, analysis.nnz_l_stored),
            Path::Iterative { .. } => (0, 0),
        }
    }

    pub(crate) fn info(&self, solver: &Solver) -> SolverInfo {
        let (kind, multigrid) = match solver {
            Solver::Direct(_) => (SolverKind::Direct, None),
            Solver::Iterative(i) => (SolverKind::Iterative, Some(i.multigrid.info().clone())),
        };
        SolverInfo { kind, reason: self.reason, multigrid }
    }
}

/// A failing pivot is found by its place in elimination order; the caller knows nodes.
fn name_node(error: SimError, unknowns: &Unknowns) -> SimError {
    let named = |place: usize, direction| {
        let owner = unknowns.owners()[place];
        let direction = direction + 3 * usize::from(owner.is_rotation);
        (owner.node.index(), direction)
    };
    match error {
        SimError::NotPositiveDefinite { node, direction } => {
            let (node, direction) = named(node, direction);
            SimError::NotPositiveDefinite { node, direction }
        }
        SimError::Singular { node, direction, pivot } => {
            let (node, direction) = named(node, direction);
            SimError::Singular { node, direction, pivot }
        }
        other => other,
    }
}
