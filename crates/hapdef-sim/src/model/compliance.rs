//! Displacements at wanted nodes for many loads.

use std::sync::{Mutex, PoisonError};

use hapdef_mesh::FeNodeId;
use nalgebra::Vector3;

use crate::iterative::{Iterative, Solver};
use crate::loads::nodal::check_node;
use crate::model::solve::{BLOCK, Extent, solve_all};
use crate::model::solved_block::SolvedBlock;
use crate::{ElasticModel, NodalLoad, SimError, SolveInfo, SolveParams};

/// Limits of a compliance computation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComplianceParams {
    /// Refinement and refusal.
    pub solve: SolveParams,
    /// Which loads are solved in full and have their residual taken.
    pub residuals: Residuals,
    /// Bytes that results and workspace may take together, beside the factor.
    pub max_bytes: usize,
}

impl Default for ComplianceParams {
    /// 4 GiB, enough for 3,255 loads on 66,228 equations ten times over.
    fn default() -> Self {
        Self { solve: SolveParams::default(), residuals: Residuals::Every, max_bytes: 4 << 30 }
    }
}

/// Which residuals a compliance computation takes. A residual needs all rows of a solution, so that
/// taking it costs the rows that are not wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Residuals {
    /// The residual of every load.
    #[default]
    Every,
    /// Those of at least so many loads, and never none, in whole blocks evenly spread over the
    /// limb. The others are solved at the wanted nodes alone.
    ///
    /// What a residual can reach is a property of the factor: L Lᵀ = K + ΔK with one ΔK for all
    /// loads, and the substitutions' rounding has one bound for all (N. J. Higham, Accuracy and
    /// Stability of Numerical Algorithms, 2nd ed., theorem 10.4). The sample shows its size. Beside it
    /// each load that is solved in part is checked by reciprocity: for a w of signs on the wanted
    /// rows and its solution z = K⁻¹ w, whose residual is taken, wᵀ x = zᵀ f. The reciprocity error
    /// |wᵀ x − zᵀ f| / (‖ŵ‖₁ ‖x̂‖∞ + ‖f̂‖₁ ‖ẑ‖∞) of the Jacobi-scaled system is at most the bound of
    /// [`SolveInfo::forward_error_bound`]; a block of loads above it is solved again in full, its
    /// residuals taken. It sees a wrong value only if that is large beside the wanted rows' own
    /// rounding: a weaker promise than [`Self::Every`].
    ///
    /// All loads are solved in full, as with [`Self::Every`], where a sampled one asks for
    /// refinement or the condition number does, and on the iterative path.
    /// [`SolveInfo::n_residuals`] says how many were.
    Sampled {
        /// Loads solved in full, at least.
        n_loads: usize,
    },
}

/// Displacements at wanted nodes, m, one row of three-vectors per load.
#[derive(Clone, Debug, PartialEq)]
pub struct Compliance {
    n_loads: usize,
    n_wanted: usize,
    data: Vec<f64>,
}

impl Compliance {
    /// Loads (rows).
    #[must_use]
    pub fn n_loads(&self) -> usize {
        self.n_loads
    }

    /// Wanted nodes (columns).
    #[must_use]
    pub fn n_wanted(&self) -> usize {
        self.n_wanted
    }

    /// All displacements `[n_loads, n_wanted, 3]`, row-major, m.
    #[must_use]
    pub fn data(&self) -> &[f64] {
        &self.data
    }

    /// The displacements under `load` `[n_wanted, 3]`, m.
    ///
    /// # Panics
    /// If `load` is not below [`Self::n_loads`].
    #[must_use]
    pub fn row(&self, load: usize) -> &[f64] {
        &self.data[3 * load * self.n_wanted..3 * (load + 1) * self.n_wanted]
    }

    /// The displacement of the `wanted`-th node under `load`, m.
    ///
    /// # Panics
    /// If an index is out of range.
    #[must_use]
    pub fn displacement(&self, load: usize, wanted: usize) -> Vector3<f64> {
        let row = self.row(load);
        Vector3::new(row[3 * wanted], row[3 * wanted + 1], row[3 * wanted + 2])
    }
}

impl ElasticModel {
    /// The displacements at `wanted` nodes for each of `loads`; unit loads give compliance, m/N.
    ///
    /// Full solutions live only in blocks of right-hand sides, each checked by its residual, or as
    /// [`Residuals`] says; what was read and checked is in the [`SolveInfo`]. Where a load is solved
    /// in part, its wanted displacements are the same bit for bit.
    ///
    /// # Errors
    /// [`SimError::OverBudget`] before any work if the result would not fit; else as
    /// [`ElasticModel::solve`].
    pub fn compliance(
        &self,
        loads: &[NodalLoad],
        wanted: &[FeNodeId],
        params: &ComplianceParams,
    ) -> Result<(Compliance, SolveInfo), SimError> {
        for &node in wanted {
            check_node("the list of wanted nodes", node, self.info().n_fe_nodes)?;
        }
        self.check_budget(loads.len(), wanted.len(), params.max_bytes)?;
        let row = 3 * wanted.len();
        let mut data = vec![0.0; loads.len() * row];
        let rows: Vec<Mutex<&mut [f64]>> =
            data.chunks_exact_mut(row.max(1)).map(Mutex::new).collect();
        let harvest = |block: &SolvedBlock<'_>| take_wanted(block, wanted, &rows);
        let extent = match params.residuals {
            Residuals::Every => Extent::Full,
            Residuals::Sampled { n_loads: n_sampled } => {
                Extent::Wanted { nodes: wanted, n_sampled }
            }
        };
        let info = solve_all(self, loads, &params.solve, extent, harvest, |_, ()| {})?;
        drop(rows);
        Ok((Compliance { n_loads: loads.len(), n_wanted: wanted.len(), data }, info))
    }

    fn check_budget(
        &self,
        n_loads: usize,
        n_wanted: usize,
        allowed_bytes: usize,
    ) -> Result<(), SimError> {
        let result = n_loads.saturating_mul(3 * n_wanted);
        let workspace = match self.solver {
            Solver::Direct(_) => 2 * BLOCK * self.pool.current_num_threads(),
            Solver::Iterative(_) => Iterative::working_set(),
        };
        let workspace = workspace * self.info().n_equations;
        let needed_bytes = result.saturating_add(workspace).saturating_mul(8);
        if needed_bytes <= allowed_bytes {
            Ok(())
        } else {
            Err(SimError::OverBudget { n_loads, n_wanted, needed_bytes, allowed_bytes })
        }
    }
}

/// Wanted nodes turned together: their rows fit the first cache.
const TURNED: usize = 8;

/// Copies the displacements of `wanted` to the rows of the block's loads, `[n_wanted, 3]` each, m.
fn take_wanted(block: &SolvedBlock<'_>, wanted: &[FeNodeId], rows: &[Mutex<&mut [f64]>]) {
    if wanted.is_empty() {
        return;
    }
    // each load is in one block only: no thread ever waits for another
    let mut rows: Vec<_> = block
        .loads
        .iter()
        .map(|&load| rows[load].lock().unwrap_or_else(PoisonError::into_inner))
        .collect();
    for (chunk, nodes) in wanted.chunks(TURNED).enumerate() {
        let known: Vec<_> = nodes.iter().map(|&node| block.rows(node)).collect();
        for (column, row) in rows.iter_mut().enumerate() {
            let targets = row[3 * TURNED * chunk..].chunks_exact_mut(3);
            for ((target, known), &node) in targets.zip(&known).zip(nodes) {
                if let Some(known) = known {
                    for c in 0..3 {
                        target[c] = known[c][column];
                    }
                } else {
                    target.copy_from_slice(block.displacement(column, node).as_slice());
                }
            }
        }
    }
}
