//! Everything that the report is made of.

use anyhow::{Context, Result};
use hapdef::convergence::{Convergence, ConvergenceParams};
use hapdef::stages::{self, EvalReport};
use hapdef::{Hapdefx, Limb, Pipeline, Run, Stage};

use super::ablation::ablations;
use super::ablation_table::{Ablations, ablation_table};
use super::chain::chain;
use super::frames::{Frames, frames};
use super::patches::{SizePoint, sweep};
use super::ridge::{RidgeRows, ridge};
use super::scores::Scores;
use super::singles::{Singles, singles};
use super::svr::{SvrScore, svr};
use super::table1::table1;
use crate::tables::Table1;

/// What was measured, before it is judged and drawn.
pub(crate) struct Made<'a> {
    pub(crate) run: &'a Run,
    pub(crate) limb: &'a Limb,
    pub(crate) done: &'a Pipeline,
    pub(crate) chain: Hapdefx,
    /// Scores of the chain and its maps.
    pub(crate) scores: &'a EvalReport,
    /// By each metric, mean absolute error first.
    pub(crate) table1: Vec<Table1>,
    pub(crate) svr: SvrScore,
    pub(crate) mesh_check: Convergence,
    /// Single presses by every method.
    pub(crate) singles: Singles,
    /// Presses of several contacts.
    pub(crate) frames: Frames,
    /// Their contacts scored both ways.
    pub(crate) both: Scores,
    /// Figure 5A, if it was made.
    pub(crate) sizes: Option<Vec<SizePoint>>,
    /// Rows that only the whole reproduction has.
    pub(crate) ablations: Option<Ablations>,
    pub(crate) ridge: Option<RidgeRows>,
    /// What this crate made.
    pub(crate) stages: Vec<Stage>,
}

impl<'a> Made<'a> {
    /// Runs every stage of this crate that is not in the cache; what needs nets of its own only `with_nets`.
    pub(crate) fn of(
        run: &'a Run,
        limb: &'a Limb,
        done: &'a Pipeline,
        with_nets: bool,
    ) -> Result<Self> {
        let (_, scores) = done.eval.as_ref().context("the scene was not scored")?;
        let (table1, table1_stage) = table1(run, done)?;
        let (svr, svr_stage) = svr(run, done)?;
        let (mesh_stage, mesh_check) =
            stages::mesh_check(run, limb, &ConvergenceParams::default())?;
        let (singles, singles_stage) = singles(run, limb, done, &svr)?;
        let (frames, frames_stage) = frames(run, limb, done)?;
        let chain = chain(run, limb, done)?;
        let mut made = Self {
            run,
            limb,
            done,
            both: Scores::of(&chain, &frames)?,
            chain,
            scores,
            table1,
            svr,
            mesh_check,
            singles,
            frames,
            sizes: None,
            ablations: None,
            ridge: None,
            stages: vec![table1_stage, svr_stage, mesh_stage, singles_stage, frames_stage],
        };
        if with_nets {
            made.add_reproduction()?;
        }
        Ok(made)
    }

    fn add_reproduction(&mut self) -> Result<()> {
        let (run, limb, done) = (self.run, self.limb, self.done);
        let (answers, stages) = ablations(run, limb, done)?;
        self.singles.ablations.extend(answers);
        self.stages.extend(stages);
        let (rows, stages) = ablation_table(run, limb, done)?;
        self.ablations = Some(rows);
        self.stages.extend(stages);
        let (rows, stage) = ridge(run, done)?;
        self.ridge = Some(rows);
        self.stages.push(stage);
        if !self.frames.rig_double.is_empty() {
            let (points, stages) = sweep(run, done)?;
            self.sizes = Some(points);
            self.stages.extend(stages);
        }
        Ok(())
    }

    /// Largest force of a contact, N.
    pub(crate) fn strongest_n(&self) -> f64 {
        self.run.scene.contact.force_range_n[1]
    }
}
