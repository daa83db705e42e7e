//! Many right-hand sides at once, in fixed blocks, each with its residual.

use std::time::Instant;

use hapdef_mesh::FeNodeId;
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::iterative::Solver;
use crate::model::iterative_loads::solve_loads;
use crate::model::solve_block::{Reached, System, Workspace};
use crate::model::solve_info::{SolveInfo, SolveParams, check_forward_error};
use crate::model::solved_block::{Motion, SolvedBlock, unknown_forces};
use crate::model::wanted::Wanted;
use crate::supports::unknowns::Unknowns;
use crate::{ElasticModel, NodalLoad, SimError};

/// Right-hand sides solved together. Fixed, so that results do not depend on the thread count.
pub(crate) const BLOCK: usize = 64;

/// Blocks per thread between two hand-overs of results.
const BLOCKS_PER_WAVE: usize = 4;

/// Which rows of the solutions are solved for, and which residuals are taken.
#[derive(Clone, Copy)]
pub(crate) enum Extent<'a> {
    /// All rows, all residuals.
    Full,
    /// The rows of `nodes`; all rows and residuals of at least `n_sampled` loads, and of all where
    /// the system asks for refinement.
    Wanted { nodes: &'a [FeNodeId], n_sampled: usize },
}

impl ElasticModel {
    /// The displacements `[n_fe_nodes]`, m, under `load`; clamped nodes have zero.
    ///
    /// # Errors
    /// [`SimError::NodeOutOfRange`], [`SimError::LoadNotFinite`], [`SimError::NoRotations`],
    /// [`SimError::Residual`], [`SimError::IllConditioned`]; on the iterative
    /// path [`SimError::NotConverged`].
    pub fn solve(&self, load: &NodalLoad) -> Result<(Vec<Vector3<f64>>, SolveInfo), SimError> {
        let (motion, info) = self.solve_motion(load)?;
        Ok((motion.displacement, info))
    }

    /// The displacements and, for shells, rotations under `load`.
    ///
    /// # Errors
    /// As [`Self::solve`].
    pub fn solve_motion(&self, load: &NodalLoad) -> Result<(Motion, SolveInfo), SimError> {
        let mut motion = Motion::default();
        let loads = std::slice::from_ref(load);
        let info = solve_all(
            self,
            loads,
            &SolveParams::default(),
            Extent::Full,
            |block| block.motion(0),
            |_, field| motion = field,
        )?;
        Ok((motion, info))
    }
}

/// Solves all `loads` as far as `extent` asks; `harvest` takes what is wanted of each block, `sink`
/// receives it with the block's load numbers, block after block in a fixed order.
pub(crate) fn solve_all<T: Send>(
    model: &ElasticModel,
    loads: &[NodalLoad],
    params: &SolveParams,
    extent: Extent<'_>,
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
    let system = System { model, factor, extended: condition > params.extend_above_condition };
    let sequence = by_place(loads, unknowns);
    let (full, rest) = split(sequence.chunks(block_size(loads.len())).collect(), extent);
    let mut reached = Reached::default();
    let mut run = |blocks: &[&[usize]], wanted: Option<&Wanted>, reached: &mut Reached| {
        for wave in blocks.chunks(BLOCKS_PER_WAVE * model.pool.current_num_threads()) {
            let solved: Vec<(T, Reached)> = model.pool.install(|| {
                wave.par_iter()
                    .map_init(Workspace::default, |workspace, &block| {
                        let reached = workspace.solve(&system, loads, block, params, wanted);
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
        Ok::<(), SimError>(())
    };
    run(&full, None, &mut reached)?;
    let wanted = match extent {
        Extent::Wanted { nodes, .. } if !rest.is_empty() && reached.n_refinements == 0 => {
            let bound = condition * (reached.backward_error + model.rounding);
            system.wanted(nodes, bound, params)
        }
        _ => None,
    };
    run(&rest, wanted.as_ref(), &mut reached)?;
    let info = info(&system, &reached, condition, loads.len(), started);
    check_forward_error(&info, params)?;
    Ok(info)
}

fn info(
    system: &System<'_>,
    reached: &Reached,
    condition: f64,
    n_loads: usize,
    started: Instant,
) -> SolveInfo {
    let all = system.factor.analysis.n_values() * n_loads;
    let share = |n_read: usize| n_read as f64 / all.max(1) as f64;
    SolveInfo {
        n_residuals: reached.n_residuals,
        condition: Some(condition),
        stiffness_rounding: system.model.rounding,
        worst_relative_residual: reached.relative_residual,
        worst_backward_error: reached.backward_error,
        worst_load: reached.load,
        n_refinements: reached.n_refinements,
        worst_reciprocity_error: reached.reciprocity_error,
        forward_factor_share: share(reached.n_read[0]),
        backward_factor_share: share(reached.n_read[1]),
        elapsed_s: started.elapsed().as_secs_f64(),
        ..SolveInfo::new(n_loads)
    }
}

/// The blocks to be solved in full, evenly spread, and the others.
fn split<'a>(blocks: Vec<&'a [usize]>, extent: Extent<'_>) -> (Vec<&'a [usize]>, Vec<&'a [usize]>) {
    let Extent::Wanted { n_sampled, .. } = extent else {
        return (blocks, Vec::new());
    };
    let size = blocks.first().map_or(1, |block| block.len());
    let n = blocks.len();
    let n_full = n_sampled.div_ceil(size).clamp(1, n.max(1));
    let mut numbered: Vec<(bool, &[usize])> =
        blocks.into_iter().map(|block| (false, block)).collect();
    for i in 0..n_full.min(n) {
        // in the middle of as many equal runs of blocks
        numbered[(2 * i + 1) * n / (2 * n_full)].0 = true;
    }
    let (full, rest): (Vec<_>, Vec<_>) = numbered.into_iter().partition(|(is_full, _)| *is_full);
    let plain = |part: Vec<(bool, &'a [usize])>| part.into_iter().map(|(_, block)| block).collect();
    (plain(full), plain(rest))
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
