//! The rig, the responses and the frames of the comparison.

use anyhow::Result;
use clap::Args;
use hapdef::touch::estimator_params;
use hapdef::{Limb, Run};
use hapdef_cli::{SceneArgs, TrainingArgs};
use hapdef_inverse::EstimatorParams;

use super::cells::{Drawn, Map};
use super::paper::{PaperPipeline, VirtualGauges};
use super::rig::{Layout, Rig};
use super::score::Row;
use super::world::Frame;
use crate::run::chain::Choice;

/// Presses of the calibration by few.
pub(super) const N_FEW: usize = 300;

/// Arguments of `compare`.
#[derive(Args, Clone, Debug)]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    #[command(flatten)]
    pub(super) training: TrainingArgs,
    /// Frames of each row.
    #[arg(long, default_value_t = 400)]
    pub(super) frames: usize,
    /// Seed of the presses and frames; nothing was tuned on the default.
    #[arg(long, default_value_t = 7000)]
    pub(super) test_seed: u64,
    /// Scripts of each row of contacts that are followed.
    #[arg(long, default_value_t = 200)]
    pub(super) scripts: usize,
    /// Presses that the map is calibrated with where nothing else is said, 300 at least.
    #[arg(long, default_value_t = 3000, value_parser = at_least_few)]
    pub(super) presses: usize,
    /// Leave the paper's pipeline out: no compliance, no datasets, no nets.
    #[arg(long)]
    pub(super) without_paper: bool,
    /// Take apart, too, why frames are not clean: by the search, by a tie or by the map.
    #[arg(long)]
    pub(super) diagnose: bool,
    /// Nothing but contacts beside loads that are no contacts: a wrench on the free end, weight, acceleration.
    #[arg(long, conflicts_with = "diagnose")]
    pub(super) loads: bool,
    /// Rows of the scene's own gauges alone, none of the sixteen: half the time.
    #[arg(long)]
    pub(super) own_gauges: bool,
}

fn at_least_few(word: &str) -> Result<usize, String> {
    let n: usize = word.parse().map_err(|_| "expected a number".to_owned())?;
    if n < N_FEW {
        return Err(format!("expected {N_FEW} at least"));
    }
    Ok(n)
}

/// The layouts of the rows: the scene's, and that of the static triple.
pub(super) const MORE: Layout = Layout::Greedy(16);

/// Least distance of its gauges from the edges of the wall, m; nearer ones may lie beyond it on the rig.
const MARGIN_M: f64 = 1e-3;

/// The rig and its presses.
pub(super) struct Bench<'a> {
    pub(super) run: &'a Run,
    pub(super) limb: &'a Limb,
    pub(super) args: &'a CompareArgs,
    pub(super) rig: Rig<'a>,
    presses: Vec<Frame>,
}

impl<'a> Bench<'a> {
    pub(super) fn build(run: &'a Run, limb: &'a Limb, args: &'a CompareArgs) -> Result<Self> {
        let layouts = [Layout::Scene, MORE];
        let n_layouts = if args.own_gauges { 1 } else { layouts.len() };
        let rig = Rig::build(run, limb, &layouts[..n_layouts], MARGIN_M)?;
        let mut bench = Self { run, limb, args, rig, presses: Vec::new() };
        bench.presses = bench.drawn().presses(args.presses)?;
        Ok(bench)
    }

    pub(super) fn params(&self) -> EstimatorParams {
        estimator_params(&self.run.scene)
    }

    /// Whether there are the gauges of [`MORE`].
    pub(super) fn has_more(&self) -> bool {
        !self.args.own_gauges
    }

    /// What is pressed.
    pub(super) fn drawn(&self) -> Drawn<'_> {
        Drawn { world: &self.rig.world, scene: &self.run.scene, seed: self.args.test_seed }
    }

    /// A layout's map, calibrated with the first `n` presses.
    pub(super) fn map(&mut self, layout: Layout, n: usize) -> Result<&Map> {
        let mesh = Some(self.run.scene.estimator.map_refinements());
        Ok(&self.rig.map(mesh, layout, &self.presses[..n])?.0)
    }

    /// The paper's pipeline on frames, a row for each ranking.
    pub(super) fn paper_rows(
        &self,
        paper: &mut PaperPipeline,
        frames: &[Frame],
        of: VirtualGauges,
    ) -> Result<Vec<Row>> {
        let (skin, n_gauges) = (&self.rig.world.skin, self.limb.gauges.len());
        let row = |(choice, by)| {
            let score = paper.score(skin, frames, n_gauges, of, choice)?;
            Ok(score.row(&format!("{}, by {by}", of.name())))
        };
        let choices = [(Choice::Force, "force"), (Choice::Displacement, "displacement")];
        choices.into_iter().map(row).collect()
    }

    /// `k` contacts of 5 N to the strongest, 20 mm apart.
    pub(super) fn apart(&self, k: usize, row: u64) -> Result<Vec<Frame>> {
        self.drawn().apart(self.args.frames, k, 0.02, row)
    }
}
