//! Many right-hand sides at once, in fixed blocks, each with its residual.

use std::time::Instant;

use hapdef_mesh::FeNodeId;
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::elastic_model::Motion;
use crate::factor::Factor;
use crate::iterative::{Solver, solve_loads};
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
}

impl Default for SolveParams {
    fn default() -> Self {
        Self {
            refine_above: 1e-14,
            max_refinements: 2,
            fail_above: 1e-11,
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
    /// Nothing reached yet.
    pub(crate) fn new(n_loads: usize) -> Self {
        Self {
            n_loads,
            worst_relative_residual: 0.0,
            worst_backward_error: 0.0,
            worst_load: 0,
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
pub(crate) const BLOCKS_PER_WAVE: usize = 4;

/// The solutions of one block of loads.
pub(crate) struct SolvedBlock<'a> {
    unknowns: &'a Unknowns,
    /// Load numbers, one per column.
    pub(crate) loads: &'a [usize],
    /// `[n_equations, n_columns]`, row-major, m and rad.
    x: &'a [f64],
}

impl<'a> SolvedBlock<'a> {
    pub(crate) fn new(unknowns: &'a Unknowns, loads: &'a [usize], x: &'a [f64]) -> Self {
        Self { unknowns, loads, x }
    }

    /// The displacement of `node` in `column`, m; zero where clamped.
    pub(crate) fn displacement(&self, column: usize, node: FeNodeId) -> Vector3<f64> {
        self.value(column, self.unknowns.translation(node))
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
        let k = self.loads.len();
        link.motion(|place| {
            let at = 3 * place * k + column;
            Vector3::new(self.x[at], self.x[at + k], self.x[at + 2 * k])
        })
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
    let sequence = by_place(loads, unknowns);
    let blocks: Vec<&[usize]> = sequence.chunks(block_size(loads.len())).collect();
    let mut reached = Reached::default();
    for wave in blocks.chunks(BLOCKS_PER_WAVE * model.pool.current_num_threads()) {
        let solved: Vec<(T, Reached)> = model.pool.install(|| {
            wave.par_iter()
                .map_init(Workspace::default, |workspace, &block| {
                    let reached = workspace.solve(model, factor, loads, block, params);
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
    Ok(SolveInfo {
        worst_relative_residual: reached.relative_residual,
        worst_backward_error: reached.backward_error,
        worst_load: reached.load,
        n_refinements: reached.n_refinements,
        elapsed_s: started.elapsed().as_secs_f64(),
        ..SolveInfo::new(loads.len())
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
fn unknown_forces(
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

/// The arrays of one block, reused from block to block.
#[derive(Default)]
struct Workspace {
    x: Vec<f64>,
    residual: Vec<f64>,
    gathered: Vec<f64>,
}

impl Workspace {
    fn solve(
        &mut self,
        model: &ElasticModel,
        factor: &Factor,
        loads: &[NodalLoad],
        block: &[usize],
        params: &SolveParams,
    ) -> Reached {
        let (unknowns, k) = (&model.structure.unknowns, block.len());
        let n = 3 * unknowns.n_places();
        for array in [&mut self.x, &mut self.residual] {
            array.clear();
            array.resize(n * k, 0.0);
        }
        add_loads(&mut self.x, loads, block, unknowns);
        let touched = block
            .iter()
            .flat_map(|&load| unknown_forces(&loads[load], unknowns))
            .map(|(place, _)| 3 * place);
        // the three equations of a motion may lie in two supernodes
        let touched = touched.flat_map(|equation| [equation, equation + 1, equation + 2]);
        factor.solve_in_place(&mut self.x, k, touched, &mut self.gathered);
        let mut reached = self.residual(model, loads, block);
        while reached.backward_error > params.refine_above
            && reached.n_refinements < params.max_refinements
        {
            let correction = &mut self.residual;
            factor.solve_in_place(correction, k, 0..n, &mut self.gathered);
            for (x, c) in self.x.iter_mut().zip(correction) {
                *x += *c;
            }
            let n_refinements = reached.n_refinements + 1;
            self.residual.fill(0.0);
            reached = Reached {
                n_refinements,
                ..self.residual(model, loads, block)
            };
        }
        reached
    }

    /// r ← b − K x, and the block's worst residuals; `residual` is zero on entry.
    fn residual(&mut self, model: &ElasticModel, loads: &[NodalLoad], block: &[usize]) -> Reached {
        let (unknowns, k) = (&model.structure.unknowns, block.len());
        let scale = model.solver.scale();
        add_loads(&mut self.residual, loads, block, unknowns);
        let loaded = ColumnNorms::of(&self.residual, k, |row| scale[row]);
        model
            .stiffness
            .multiply_add(-1.0, &self.x, k, &mut self.residual);
        let left = ColumnNorms::of(&self.residual, k, |row| scale[row]);
        let moved = ColumnNorms::of(&self.x, k, |row| 1.0 / scale[row]);
        let mut worst = Reached::default();
        for (column, &load) in block.iter().enumerate() {
            let size = model.scaled_norm * moved.scaled_max[column] + loaded.scaled_max[column];
            worst.take(&Reached {
                relative_residual: ratio(left.euclidean[column], loaded.euclidean[column]),
                backward_error: ratio(left.scaled_max[column], size),
                load,
                n_refinements: 0,
            });
        }
        worst
    }
}

/// Zero for nothing left of nothing loaded.
fn ratio(left: f64, of: f64) -> f64 {
    if left == 0.0 { 0.0 } else { left / of }
}

pub(crate) fn add_loads(x: &mut [f64], loads: &[NodalLoad], block: &[usize], unknowns: &Unknowns) {
    let k = block.len();
    for (column, &load) in block.iter().enumerate() {
        for (place, force) in unknown_forces(&loads[load], unknowns) {
            for (c, f) in force.iter().enumerate() {
                x[(3 * place + c) * k + column] += f;
            }
        }
    }
}

/// Norms of the columns of a row-major array.
struct ColumnNorms {
    euclidean: Vec<f64>,
    /// The largest |scale · value|.
    scaled_max: Vec<f64>,
}

impl ColumnNorms {
    fn of(rows: &[f64], k: usize, scale: impl Fn(usize) -> f64) -> Self {
        let (mut squares, mut scaled_max) = (vec![0.0; k], vec![0.0_f64; k]);
        for (row, values) in rows.chunks_exact(k).enumerate() {
            let scale = scale(row);
            for (column, value) in values.iter().enumerate() {
                squares[column] += value * value;
                let size = (scale * value).abs();
                // not max(): a NaN must survive
                scaled_max[column] = if size <= scaled_max[column] {
                    scaled_max[column]
                } else {
                    size
                };
            }
        }
        Self {
            euclidean: squares.into_iter().map(f64::sqrt).collect(),
            scaled_max,
        }
    }
}
