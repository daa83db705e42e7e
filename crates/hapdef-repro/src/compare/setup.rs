//! The rig, the responses and the frames of the comparison.

use anyhow::Result;
use clap::Args;
use hapdef::touch::{
    LayoutCandidates, LayoutParams, PlacedGauge, UncertainParams, UncertainResponse,
    estimator_params,
};
use hapdef::{HapdefError, Limb, Run};
use hapdef_cli::SceneArgs;
use hapdef_inverse::EstimatorParams;
use hapdef_sim::{GaugeSite, GaugeStrain};

use super::cells::{Drawn, Map};
use super::paper::{PaperPipeline, VirtualGauges};
use super::score::Row;
use super::world::{Frame, World};
use crate::run::chain::Choice;

/// Gauges of the layout for the static triple.
pub(super) const N_MORE: usize = 16;

/// Their least distance from the edges of the wall, m; nearer ones may lie beyond it on the rig.
const MARGIN_M: f64 = 1e-3;

/// Presses of the calibration by few.
pub(super) const N_FEW: usize = 300;

/// Stiffness modes of a calibration.
pub(crate) const N_STIFFNESS: usize = 32;

/// Arguments of `compare`.
#[derive(Args, Clone, Debug)]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
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
}

fn at_least_few(word: &str) -> Result<usize, String> {
    let n: usize = word.parse().map_err(|_| "expected a number".to_owned())?;
    if n < N_FEW {
        return Err(format!("expected {N_FEW} at least"));
    }
    Ok(n)
}

/// The rig, the training side's responses, the frames.
pub(super) struct Bench<'a> {
    pub(super) run: &'a Run,
    pub(super) limb: &'a Limb,
    pub(super) args: &'a CompareArgs,
    pub(super) world: World,
    pub(super) ten: UncertainResponse,
    pub(super) more: UncertainResponse,
}

impl<'a> Bench<'a> {
    pub(super) fn build(run: &'a Run, limb: &'a Limb, args: &'a CompareArgs) -> Result<Self> {
        let params = UncertainParams {
            tip_radius_m: run.scene.contact.tip_radius_m,
            refinements: run.scene.estimator.map_refinements(),
            n_stiffness: N_STIFFNESS,
            n_threads: run.threads,
        };
        run.say("solving the response and what may change it");
        let ten = UncertainResponse::solve(limb, &limb.sites, &limb.gauges, &params)?;
        let places = gauge_places(run, limb, N_MORE, MARGIN_M)?;
        let (sites, gauges) = placed_gauges(run, limb, &places, N_MORE)?;
        let more = UncertainResponse::solve(limb, &sites, &gauges, &params)?;
        run.say("solving the simulated real limb");
        let world = World::build(run, limb, ten.map.skin(), &sites)?;
        Ok(Self { run, limb, args, world, ten, more })
    }

    pub(super) fn params(&self) -> EstimatorParams {
        estimator_params(&self.run.scene)
    }

    /// What is pressed.
    pub(super) fn drawn(&self) -> Drawn<'_> {
        Drawn { world: &self.world, scene: &self.run.scene, seed: self.args.test_seed }
    }

    pub(super) fn presses(&self) -> Result<Vec<Frame>> {
        self.drawn().presses(self.args.presses)
    }

    pub(super) fn calibrate(
        &self,
        response: &UncertainResponse,
        presses: &[Frame],
        channels: std::ops::Range<usize>,
    ) -> Result<Map> {
        self.run.say(&format!("calibrating with {} presses", presses.len()));
        let noise = self.world.noise(&channels)?;
        Map::calibrate(response, presses, channels, noise, self.run.threads)
    }

    /// The paper's pipeline on frames, a row for each ranking.
    pub(super) fn paper_rows(
        &self,
        paper: &mut PaperPipeline,
        frames: &[Frame],
        of: VirtualGauges,
    ) -> Result<Vec<Row>> {
        let (skin, n_gauges) = (self.ten.map.skin(), self.limb.gauges.len());
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

/// Places for up to `n_gauges` gauges, no nearer than `margin_m` to the edges of the wall.
pub(crate) fn gauge_places(
    run: &Run,
    limb: &Limb,
    n_gauges: usize,
    margin_m: f64,
) -> Result<LayoutCandidates, HapdefError> {
    let params = LayoutParams {
        n_gauges,
        margin_m,
        noise_ue: run.scene.rig.electronics.noise_ue,
        seed: run.scene.seed,
        ..LayoutParams::default()
    };
    LayoutCandidates::solve(run, limb, &params)
}

/// `n_gauges` gauges where log-det puts them.
pub(crate) fn placed_gauges(
    run: &Run,
    limb: &Limb,
    places: &LayoutCandidates,
    n_gauges: usize,
) -> Result<(Vec<GaugeSite>, Vec<GaugeStrain>)> {
    let glued = |placed: PlacedGauge| {
        let site = run.scene.gauges.site(placed.position_m, placed.axis);
        let faces = &limb.boundary.faces;
        let gauge = GaugeStrain::with_params(&limb.mesh, faces, &site, &limb.gauge_params)?;
        Ok((site, gauge))
    };
    places.recommended(n_gauges)?.into_iter().map(glued).collect()
}
