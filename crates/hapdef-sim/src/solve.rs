//! Many right-hand sides at once, in fixed blocks, each with its residual.

use std::time::Instant;

use hapdef_mesh::FeNodeId;
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::elastic_model::Motion;
use crate::factor::Factor;
use crate::iterative::{Solver, solve_loads};
use crate::panel::Columns;
use crate::product::{Entry, Norms, Residual};
use crate::unknowns::{Link, Unknowns};
use crate::{ElasticModel, NodalLoad, SimError};

/// When a solution is refined, and when it is refused.
///
/// The measure is the backward error of the Jacobi-scaled system K̂ û = b̂,
/// η = ‖b̂ − K̂ û‖∞ / (‖K̂‖∞ ‖û‖∞ + ‖b̂‖∞): the size of the change to K̂ and b̂ that would make û exact
/// (Rigal and Gaches, J. ACM 14, 1967). The plain residual ‖b − K u‖ / ‖b‖ can't fall below
/// ‖K‖ ‖u‖ / ‖b‖ roundings, which on a soft limb is 1e-9, however good the solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveParams {
    /// A backward error above this asks for a refinement step.
    pub refine_above: f64,
    /// Refinement steps at most.
    pub max_refinements: usize,
    /// A backward error above this after refinement is an error.
    pub fail_above: f64,
    /// Above this condition number residuals are taken in twice the precision, and every solution
    /// is refined.
    pub extend_above_condition: f64,
    /// A bound on the forward error ([`SolveInfo::forward_error_bound`]) above this is an error. The
    /// bound is a pessimist: slender shells are right to many more digits than it promises.
    pub max_forward_error: f64,
}

impl Default for SolveParams {
    fn default() -> Self {
        Self {
            refine_above: 1e-14,
            max_refinements: 2,
            fail_above: 1e-11,
            extend_above_condition: 1e9,
            max_forward_error: 0.1,
        }
    }
}

/// What a solve took and reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveInfo {
    /// Right-hand sides solved.
    pub n_loads: usize,
    /// The largest relative residual ‖b − K u‖₂ / ‖b‖₂ over all of them, after refinement.
    pub worst_relative_residual: f64,
    /// The largest backward error (see [`SolveParams`]) over all of them, after refinement.
    pub worst_backward_error: f64,
    /// The load with the largest backward error.
    pub worst_load: usize,
    /// The estimated condition number of the Jacobi-scaled stiffness; none without loads.
    pub condition: Option<f64>,
    /// The most refinement steps that a block of right-hand sides asked for.
    pub n_refinements: usize,
    /// The most iterations that a right-hand side took; 0 on the direct path.
    pub n_iterations: usize,
    /// The largest estimated relative error in energy (see [`crate::IterativeParams`]); 0 on the
    /// direct path, which makes no estimate.
    pub worst_energy_error: f64,
    /// Seconds.
    pub elapsed_s: f64,
}

impl SolveInfo {
    /// A bound on the relative error of any displacement field, in the norm of the Jacobi-scaled
    /// system: κ (η + ε), with the condition number κ, the backward error η, and the rounding ε of
    /// the assembled stiffness itself (N. J. Higham, Accuracy and Stability of Numerical
    /// Algorithms, 2nd ed., section 7.1). 0 without loads.
    #[must_use]
    pub fn forward_error_bound(&self) -> f64 {
        self.condition.map_or(0.0, |condition| {
            condition * (self.worst_backward_error + f64::EPSILON)
        })
    }

    /// Nothing reached yet.
    pub(crate) fn new(n_loads: usize) -> Self {
        Self {
            n_loads,
            worst_relative_residual: 0.0,
            worst_backward_error: 0.0,
            worst_load: 0,
            condition: None,
            n_refinements: 0,
            n_iterations: 0,
            worst_energy_error: 0.0,
            elapsed_s: 0.0,
        }
    }
}

/// Right-hand sides solved together. Fixed, so that results do not depend on the thread count.
pub(crate) const BLOCK: usize = 64;

/// Blocks per thread between two hand-overs of results.
const BLOCKS_PER_WAVE: usize = 4;

/// The solutions of one block of loads.
pub(crate) struct SolvedBlock<'a> {
    unknowns: &'a Unknowns,
    /// Load numbers, one per column.
    pub(crate) loads: &'a [usize],
    /// `[n_equations, n_columns]`, m and rad.
    x: &'a Columns,
}

impl<'a> SolvedBlock<'a> {
    pub(crate) fn new(unknowns: &'a Unknowns, loads: &'a [usize], x: &'a Columns) -> Self {
        Self { unknowns, loads, x }
    }

    /// The displacement of `node` in `column`, m; zero where clamped.
    pub(crate) fn displacement(&self, column: usize, node: FeNodeId) -> Vector3<f64> {
        self.value(column, self.unknowns.translation(node))
    }

    /// The displacements of `node`, m: a row per direction, a value per column; nothing where they
    /// are no unknowns of their own.
    pub(crate) fn rows(&self, node: FeNodeId) -> Option<[&[f64]; 3]> {
        match self.unknowns.translation(node) {
            &Link::Free(place) => Some([0, 1, 2].map(|c| self.x.row(3 * place as usize + c))),
            _ => None,
        }
    }

    /// All displacements of `column` `[n_fe_nodes]`, m.
    pub(crate) fn field(&self, column: usize) -> Vec<Vector3<f64>> {
        self.nodes()
            .map(|node| self.displacement(column, node))
            .collect()
    }

    /// The motion of all nodes in `column`.
    pub(crate) fn motion(&self, column: usize) -> Motion {
        let rotation = |node| {
            let link = self.unknowns.rotation(node)?;
            Some(self.value(column, link))
        };
        Motion {
            displacement: self.field(column),
            rotation: self.nodes().filter_map(rotation).collect(),
        }
    }

    fn value(&self, column: usize, link: &Link) -> Vector3<f64> {
        link.motion(|place| [0, 1, 2].map(|c| self.x.row(3 * place + c)[column]).into())
    }

    fn nodes(&self) -> impl Iterator<Item = FeNodeId> + use<> {
        (0..self.unknowns.n_fe_nodes()).map(FeNodeId::from_index)
    }
}

/// Solves all `loads`; `harvest` takes what is wanted of each block, `sink` receives it with the
/// block's load numbers, block after block in a fixed order.
pub(crate) fn solve_all<T: Send>(
    model: &ElasticModel,
    loads: &[NodalLoad],
    params: &SolveParams,
    harvest: impl Fn(&SolvedBlock<'_>) -> T + Sync,
    mut sink: impl FnMut(&[usize], T),
) -> Result<SolveInfo, SimError> {
    let started = Instant::now();
    let unknowns = &model.structure.unknowns;
    for load in loads {
        load.check(unknowns.n_fe_nodes(), unknowns.motions_per_node() == 2)?;
    }
    let factor = match &model.solver {
        Solver::Direct(factor) => factor,
        Solver::Iterative(iterative) => {
            return solve_loads(model, iterative, loads, params, harvest, sink);
        }
    };
    let condition = model.condition();
    let system = System {
        model,
        factor,
        extended: condition > params.extend_above_condition,
    };
    let sequence = by_place(loads, unknowns);
    let blocks: Vec<&[usize]> = sequence.chunks(block_size(loads.len())).collect();
    let mut reached = Reached::default();
    for wave in blocks.chunks(BLOCKS_PER_WAVE * model.pool.current_num_threads()) {
        let solved: Vec<(T, Reached)> = model.pool.install(|| {
            wave.par_iter()
                .map_init(Workspace::default, |workspace, &block| {
                    let reached = workspace.solve(&system, loads, block, params);
                    let solved = SolvedBlock::new(unknowns, block, &workspace.x);
                    (harvest(&solved), reached)
                })
                .collect()
        });
        for (block, (harvested, block_reached)) in wave.iter().zip(solved) {
            reached.take(&block_reached);
            sink(block, harvested);
        }
        reached.check(params)?;
    }
    let info = SolveInfo {
        condition: Some(condition),
        worst_relative_residual: reached.relative_residual,
        worst_backward_error: reached.backward_error,
        worst_load: reached.load,
        n_refinements: reached.n_refinements,
        elapsed_s: started.elapsed().as_secs_f64(),
        ..SolveInfo::new(loads.len())
    };
    check_forward_error(&info, params)?;
    Ok(info)
}

pub(crate) fn check_forward_error(info: &SolveInfo, params: &SolveParams) -> Result<(), SimError> {
    let (bound, condition) = (info.forward_error_bound(), info.condition);
    if info.n_loads == 0 || bound <= params.max_forward_error {
        return Ok(());
    }
    Err(SimError::IllConditioned {
        condition: condition.unwrap_or(f64::NAN),
        backward_error: info.worst_backward_error,
        bound,
        limit: params.max_forward_error,
    })
}

/// Few loads are split in two halves, so that a second thread has work.
fn block_size(n_loads: usize) -> usize {
    n_loads.div_ceil(2).clamp(8, BLOCK)
}

/// Load numbers sorted by the first equation they touch: neighbours share paths in the
/// elimination tree, and a block of them skips the rest on the way down.
fn by_place(loads: &[NodalLoad], unknowns: &Unknowns) -> Vec<usize> {
    let first: Vec<usize> = loads
        .iter()
        .map(|load| {
            let places = unknown_forces(load, unknowns).map(|(place, _)| place);
            places.min().unwrap_or(usize::MAX)
        })
        .collect();
    let mut sequence: Vec<usize> = (0..loads.len()).collect();
    sequence.sort_by_key(|&load| (first[load], load));
    sequence
}

/// What a load is on the unknowns: places and three-vectors, which add.
pub(crate) fn unknown_forces(
    load: &NodalLoad,
    unknowns: &Unknowns,
) -> impl Iterator<Item = (usize, Vector3<f64>)> {
    let forces = load
        .forces_n
        .iter()
        .flat_map(|(node, force)| unknowns.translation(*node).forces(*force));
    let moments = load
        .moments_nm
        .iter()
        .filter_map(|(node, moment)| Some((unknowns.rotation(*node)?, moment)))
        .flat_map(|(link, moment)| link.forces(*moment));
    forces.chain(moments)
}

/// The worst residuals so far.
#[derive(Default)]
struct Reached {
    relative_residual: f64,
    backward_error: f64,
    load: usize,
    n_refinements: usize,
}

impl Reached {
    fn take(&mut self, other: &Self) {
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

    fn check(&self, params: &SolveParams) -> Result<(), SimError> {
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
struct System<'a> {
    model: &'a ElasticModel,
    factor: &'a Factor,
    extended: bool,
}

/// The arrays of one block, reused from block to block.
#[derive(Default)]
struct Workspace {
    x: Columns,
    correction: Columns,
    entries: Vec<Entry>,
}

impl Workspace {
    fn solve(
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
