//! One block of right-hand sides through the factor, refined until its residuals are small.

use crate::factor::Factor;
use crate::panel::Columns;
use crate::product::{Entry, Norms, Residual};
use crate::solve::unknown_forces;
use crate::unknowns::Unknowns;
use crate::{ElasticModel, NodalLoad, SimError, SolveParams};

/// The worst residuals so far.
#[derive(Default)]
pub(crate) struct Reached {
    pub(crate) relative_residual: f64,
    pub(crate) backward_error: f64,
    pub(crate) load: usize,
    pub(crate) n_refinements: usize,
}

impl Reached {
    pub(crate) fn take(&mut self, other: &Self) {
        self.n_refinements = self.n_refinements.max(other.n_refinements);
        if other
            .relative_residual
            .total_cmp(&self.relative_residual)
            .is_gt()
        {
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

/// The arrays of one block, reused from block to block.
#[derive(Default)]
pub(crate) struct Workspace {
    pub(crate) x: Columns,
    correction: Columns,
    entries: Vec<Entry>,
}

impl Workspace {
    pub(crate) fn solve(
        &mut self,
        system: &System<'_>,
        loads: &[NodalLoad],
        block: &[usize],
        params: &SolveParams,
    ) -> Reached {
        let (unknowns, factor) = (&system.model.structure.unknowns, system.factor);
        let n = 3 * unknowns.n_places();
        self.collect(loads, block, unknowns);
        let reached = factor.reached(self.entries.iter().map(|entry| entry.place as usize));
        self.x.reshape(n, block.len());
        factor.clear(&mut self.x, &reached);
        for entry in &self.entries {
            let place = entry.place as usize;
            let stride = self.x.stride();
            let rows = self.x.rows_mut(3 * place..3 * place + 3);
            for c in 0..3 {
                rows[c * stride + entry.column as usize] += entry.force[c];
            }
        }
        factor.solve_in_place(&mut self.x, &reached);
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
        worst
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
        system
            .factor
            .solve_in_place(&mut self.correction, &everywhere);
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
        let backward_error = if left.is_nan() {
            f64::NAN
        } else {
            ratio(norms.left_scaled[column], size)
        };
        Self {
            relative_residual: ratio(left, norms.loaded_squares[column].sqrt()),
            backward_error,
            load,
            n_refinements: 0,
        }
    }
}

/// Zero for nothing left of nothing loaded.
fn ratio(left: f64, of: f64) -> f64 {
    if left == 0.0 { 0.0 } else { left / of }
}
