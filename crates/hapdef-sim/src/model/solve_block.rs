//! One block of right-hand sides through the factor, refined until its residuals are small.

use hapdef_mesh::FeNodeId;

use crate::factor::cholesky::Factor;
use crate::factor::panel::Columns;
use crate::model::solved_block::unknown_forces;
use crate::model::wanted::{Wanted, weights};
use crate::supports::unknowns::Unknowns;
use crate::system::product::{Entry, Norms, Residual};
use crate::{ElasticModel, NodalLoad, SimError, SolveParams};

/// The worst residuals so far, and what was read for them.
#[derive(Default)]
pub(crate) struct Reached {
    pub(crate) relative_residual: f64,
    pub(crate) backward_error: f64,
    pub(crate) load: usize,
    pub(crate) n_refinements: usize,
    /// Right-hand sides whose residual was taken.
    pub(crate) n_residuals: usize,
    /// The worst of those whose residual was not.
    pub(crate) reciprocity_error: f64,
    /// Entries of L that substitutions read, forward and backward, times right-hand sides;
    /// refinement apart.
    pub(crate) n_read: [usize; 2],
}

impl Reached {
    pub(crate) fn take(&mut self, other: &Self) {
        self.n_refinements = self.n_refinements.max(other.n_refinements);
        self.n_residuals += other.n_residuals;
        self.reciprocity_error = self.reciprocity_error.max(other.reciprocity_error);
        self.n_read[0] += other.n_read[0];
        self.n_read[1] += other.n_read[1];
        if other.relative_residual.total_cmp(&self.relative_residual).is_gt() {
            self.relative_residual = other.relative_residual;
        }
        if other.backward_error.total_cmp(&self.backward_error).is_gt() {
            (self.backward_error, self.load) = (other.backward_error, other.load);
        }
    }

    pub(crate) fn check(&self, params: &SolveParams) -> Result<(), SimError> {
        if self.backward_error <= params.fail_above {
            return Ok(());
        }
        Err(SimError::Residual {
            load: self.load,
            backward_error: self.backward_error,
            n_refinements: self.n_refinements,
            limit: params.fail_above,
        })
    }
}

/// A model with its factor, and how residuals are taken.
pub(crate) struct System<'a> {
    pub(crate) model: &'a ElasticModel,
    pub(crate) factor: &'a Factor,
    /// Whether residuals are taken in twice the precision.
    pub(crate) extended: bool,
}

impl System<'_> {
    /// The rows of `nodes`, in doubt above the given reciprocity error; none where the system asks
    /// for refinement, which takes all rows.
    pub(crate) fn wanted(
        &self,
        nodes: &[FeNodeId],
        doubt_above: f64,
        params: &SolveParams,
    ) -> Option<Wanted> {
        if self.extended {
            return None;
        }
        let scale = self.factor.scale();
        let weights = weights(nodes, &self.model.structure.unknowns, scale);
        let mut workspace = Workspace::default();
        let reached = workspace.solve_one(self, &weights, params);
        if reached.n_refinements > 0 || reached.check(params).is_err() {
            return None;
        }
        let adjoint = (0..scale.len()).map(|i| workspace.x.row(i)[0]).collect();
        Some(Wanted::new(weights, adjoint, self.factor, doubt_above))
    }
}

/// The arrays of one block, reused from block to block.
#[derive(Default)]
pub(crate) struct Workspace {
    pub(crate) x: Columns,
    correction: Columns,
    entries: Vec<Entry>,
}

impl Workspace {
    /// Solves for the `block` of `loads`; where rows are `wanted`, for those alone, unless their
    /// check leaves a doubt.
    pub(crate) fn solve(
        &mut self,
        system: &System<'_>,
        loads: &[NodalLoad],
        block: &[usize],
        params: &SolveParams,
        wanted: Option<&Wanted>,
    ) -> Reached {
        self.collect(loads, block, &system.model.structure.unknowns);
        if let Some(wanted) = wanted {
            let n_read = self.substitute(system, block.len(), &wanted.supernodes);
            let (entries, x) = (&self.entries, &self.x);
            let error = wanted.reciprocity_error(system.factor.scale(), entries, x, block.len());
            // a value that is not a number is in doubt
            if error <= wanted.doubt_above {
                return Reached { reciprocity_error: error, n_read, ..Reached::default() };
            }
        }
        self.solve_full(system, block, params)
    }

    /// Solves for one right-hand side.
    pub(crate) fn solve_one(
        &mut self,
        system: &System<'_>,
        entries: &[Entry],
        params: &SolveParams,
    ) -> Reached {
        self.entries = entries.to_vec();
        self.solve_full(system, &[0], params)
    }

    fn solve_full(
        &mut self,
        system: &System<'_>,
        block: &[usize],
        params: &SolveParams,
    ) -> Reached {
        let everywhere = vec![true; system.factor.analysis.n_supernodes()];
        let n_read = self.substitute(system, block.len(), &everywhere);
        let mut worst = self.worst(system, block, false);
        while (system.extended || worst.backward_error > params.refine_above)
            && worst.n_refinements < params.max_refinements
        {
            self.refine(system, block);
            worst = Reached {
                n_refinements: worst.n_refinements + 1,
                ..self.worst(system, block, false)
            };
        }
        Reached { n_residuals: block.len(), n_read, ..worst }
    }

    /// The entries' solution, in the rows of the `wanted` supernodes; returns the entries of L
    /// read, forward and backward, times columns.
    fn substitute(&mut self, system: &System<'_>, n_columns: usize, wanted: &[bool]) -> [usize; 2] {
        let factor = system.factor;
        let reached = factor.reached(self.entries.iter().map(Entry::place));
        self.x.reshape(3 * system.model.structure.unknowns.n_places(), n_columns);
        factor.clear(&mut self.x, &reached);
        for entry in &self.entries {
            let place = entry.place();
            let stride = self.x.stride();
            let rows = self.x.rows_mut(3 * place..3 * place + 3);
            for c in 0..3 {
                rows[c * stride + entry.column as usize] += entry.force[c];
            }
        }
        factor.solve_in_place(&mut self.x, &reached, wanted);
        [&reached, wanted].map(|read| n_columns * factor.n_entries(read))
    }

    /// The entries and their solution.
    #[cfg(test)]
    pub(crate) fn parts(self) -> (Vec<Entry>, Columns) {
        (self.entries, self.x)
    }

    /// The block's forces, ascending by place.
    fn collect(&mut self, loads: &[NodalLoad], block: &[usize], unknowns: &Unknowns) {
        self.entries.clear();
        for (column, &load) in block.iter().enumerate() {
            let forces = unknown_forces(&loads[load], unknowns);
            self.entries.extend(forces.map(|(place, force)| Entry {
                place: place as u32,
                column: column as u32,
                force: force.into(),
            }));
        }
        self.entries.sort_by_key(|entry| entry.place);
    }

    /// x ← x + K⁻¹ (b − K x).
    fn refine(&mut self, system: &System<'_>, block: &[usize]) {
        self.worst(system, block, true);
        let everywhere = vec![true; system.factor.analysis.n_supernodes()];
        system.factor.solve_in_place(&mut self.correction, &everywhere, &everywhere);
        let correction = self.correction.values();
        for (x, c) in self.x.values_mut().iter_mut().zip(correction) {
            *x += *c;
        }
    }

    /// The block's worst residuals; the residual itself becomes the correction if it is to be kept.
    fn worst(&mut self, system: &System<'_>, block: &[usize], keep: bool) -> Reached {
        let residual = Residual {
            matrix: &system.model.stiffness,
            analysis: &system.factor.analysis,
            scale: system.factor.scale(),
            entries: &self.entries,
            x: &self.x,
        };
        let norms = residual.norms(if keep {
            let n = 3 * system.factor.analysis.n_nodes();
            self.correction.reshape(n, block.len());
            Some(&mut self.correction)
        } else {
            None
        });
        if keep && system.extended {
            residual.extended(&mut self.correction, block.len());
        }
        let mut worst = Reached::default();
        for (column, &load) in block.iter().enumerate() {
            worst.take(&Reached::of(&norms, column, system.model.scaled_norm, load));
        }
        worst
    }
}

impl Reached {
    fn of(norms: &Norms, column: usize, scaled_norm: f64, load: usize) -> Self {
        let size = scaled_norm * norms.moved_scaled[column] + norms.loaded_scaled[column];
        let left = norms.left_squares[column].sqrt();
        let backward_error =
            if left.is_nan() { f64::NAN } else { ratio(norms.left_scaled[column], size) };
        Self {
            relative_residual: ratio(left, norms.loaded_squares[column].sqrt()),
            backward_error,
            load,
            ..Self::default()
        }
    }
}

/// Zero for nothing left of nothing loaded.
fn ratio(left: f64, of: f64) -> f64 {
    if left == 0.0 { 0.0 } else { left / of }
}
