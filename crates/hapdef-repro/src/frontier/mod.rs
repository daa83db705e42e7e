//! `frontier`: the whole chain's error against its run time, over meshes, layouts, presses, efforts
//! and precisions; how times grow; what leaving things out is worth; what was planned.

mod chain;
mod configuration;
mod configurations_table;
mod figures;
mod frames;
mod growth;
mod kept;
mod lab;
mod limits;
mod measure;
mod page;
mod planned;
mod plots;
mod point;
mod scaling;
mod skips;
mod tables;
mod times;
mod tube;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use clap::Args;
use hapdef::{Cache, HapdefError, Limb, Run};
use hapdef_cli::{SceneArgs, TrainingArgs};
use hapdef_sim::SimError;
use serde::Serialize;
use serde_json::json;

use self::configuration::{Configuration, Mesh};
use self::growth::Growth;
use self::kept::Origin;
use self::lab::Lab;
use self::planned::Planned;
use self::point::Point;
use self::skips::Skips;

/// Changes with what is measured: points of another version are measured again.
const VERSION: u32 = 3;

/// Configurations that are measured whatever the time: the usual one, searched and followed.
const N_ALWAYS: usize = 2;

/// Largest tubes of the scaling, nodes, below and from so many minutes.
const SOME_NODES: usize = 31_000;
const MANY_NODES: usize = 310_000;
const MINUTES_FOR_MANY: f64 = 15.0;

/// Arguments of `frontier`.
#[derive(Args, Clone, Debug)]
#[command(
    after_help = "Example:\n  hapdef-repro frontier fixtures/shin/placed_anew.json --minutes 20\n\n\
    Points that were measured are kept: the same program on the same machine goes on from them."
)]
pub(crate) struct ChainFrontierArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    training: TrainingArgs,
    /// No new point is begun after so many minutes; the usual configuration, searched and followed, and
    /// everything that is measured once always is.
    #[arg(long, default_value_t = 20.0)]
    minutes: f64,
    /// Scored frames of one and of two contacts; at least 1,000 of two are timed.
    #[arg(long, default_value = "200")]
    frames: NonZeroUsize,
    /// Seed of presses and frames; nothing was tuned on the default.
    #[arg(long, default_value_t = 9400)]
    test_seed: u64,
    /// Leave the paper's chain out: no datasets, no nets.
    #[arg(long)]
    without_nets: bool,
    /// Also writes the tables to this Markdown file, with what the tables of extremes beside it come to,
    /// and what `--check` needs to a JSON file beside it.
    #[arg(long)]
    write: Option<PathBuf>,
    /// Measures the usual configuration alone and fails where this file's JSON says something else.
    #[arg(long, conflicts_with = "write")]
    check: Option<PathBuf>,
}

/// Everything that was measured.
#[derive(Clone, Debug, Serialize)]
struct Measured {
    points: Vec<Point>,
    /// Why this limb has no shell of its skin, where it has none; its configurations are left out.
    no_shell: Option<String>,
    /// Configurations that were refused, as where a gauge does not read what the response tells, and why.
    refused: Vec<Refused>,
    /// Points that an earlier run of this program on this machine measured.
    n_kept: usize,
    /// Configurations by superposition that this limb allows, measured or not.
    n_configurations: usize,
    growths: Vec<Growth>,
    skips: Skips,
    planned: Vec<Planned>,
}

/// A configuration that could not be measured.
#[derive(Clone, Debug, Serialize)]
struct Refused {
    configuration: String,
    why: String,
}

/// Measures, prints and writes the frontier.
pub(crate) fn run(args: &ChainFrontierArgs) -> Result<()> {
    let start = Instant::now();
    let run = args.training.prepare(&args.scene)?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    if let Some(path) = &args.check {
        return limits::check(path, args, &run, &limb);
    }
    let mut lab = Lab::build(&run, &limb, args.test_seed, args.frames.get())?;
    let folder = args.scene.results.join(&run.scene.name);
    let skips = skips::measure(&mut lab, &folder.join("frontier-design"))?;
    let planned = match args.without_nets {
        true => Vec::new(),
        false => planned::measure(&run, &limb, &folder.join("frontier-plan"))?,
    };
    let most_nodes = if args.minutes < MINUTES_FOR_MANY { SOME_NODES } else { MANY_NODES };
    let mut measured = Measured {
        points: Vec::new(),
        no_shell: None,
        refused: Vec::new(),
        n_kept: 0,
        n_configurations: 0,
        growths: scaling::measure(&run, most_nodes, args.test_seed)?,
        skips,
        planned,
    };
    let deadline = start + Duration::from_secs_f64(60.0 * args.minutes);
    measured.add_points(args, &run, &mut lab, deadline)?;
    page::write(args, &run, &measured)
}

impl Measured {
    /// The usual configuration, the paper's chain, the usual configuration followed, and as many others as there
    /// is time for; why there is no shell where the limb's skin makes none.
    fn add_points(
        &mut self,
        args: &ChainFrontierArgs,
        run: &Run,
        lab: &mut Lab<'_>,
        deadline: Instant,
    ) -> Result<()> {
        let origin = Origin::here(args, run, &lab.limb.deck_hash)?;
        let configurations = Configuration::in_order(args.test_seed);
        for (i, configuration) in configurations.iter().enumerate() {
            if i >= N_ALWAYS && Instant::now() > deadline {
                break;
            }
            run.check_stop("the frontier")?;
            let is_shell = configuration.mesh == Mesh::Shell;
            if is_shell && self.no_shell.is_some() {
                continue;
            }
            let what = json!({ "configuration": configuration });
            match origin.kept(run, &what, || measure::superposed(lab, configuration)) {
                Ok((point, is_kept)) => {
                    self.points.push(point);
                    self.n_kept += usize::from(is_kept);
                }
                Err(error) if is_shell && is_mesh_fault(&error) => {
                    self.no_shell = Some(format!("{error:#}"));
                }
                Err(error) if i >= N_ALWAYS && is_refusal(&error) => {
                    let (configuration, why) = (configuration.name(), format!("{error:#}"));
                    self.refused.push(Refused { configuration, why });
                }
                Err(error) => return Err(error),
            }
            if i == 0 && !args.without_nets {
                let what = json!({ "chain": run.profile });
                let usual = lab.ready(configuration)?;
                let (chain, is_kept): (Vec<Point>, bool) =
                    origin.kept(run, &what, || chain::chain(lab, &usual))?;
                self.n_kept += if is_kept { chain.len() } else { 0 };
                self.points.extend(chain);
            }
        }
        self.points = point::on_one_footing(&self.points);
        let is_allowed = |c: &&Configuration| c.mesh != Mesh::Shell || self.no_shell.is_none();
        self.n_configurations = configurations.iter().filter(is_allowed).count();
        Ok(())
    }
}

/// Whether the estimator or its calibration refuses what it is given, or the mesh a gauge.
fn is_refusal(error: &anyhow::Error) -> bool {
    match error.downcast_ref::<HapdefError>() {
        Some(HapdefError::Inverse(_)) => true,
        Some(HapdefError::Sim(error)) => matches!(error, SimError::GaugeOverhang { .. }),
        _ => false,
    }
}

fn is_mesh_fault(error: &anyhow::Error) -> bool {
    let fault = error.downcast_ref::<HapdefError>();
    matches!(fault, Some(HapdefError::Mesh(_)))
}

/// The same run with a cache of its own in `folder`, which is emptied: everything is made anew.
fn made_anew(run: &Run, folder: &Path) -> Result<Run> {
    if folder.exists() {
        std::fs::remove_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    Ok(Run { cache: Cache::new(folder), ..run.clone() })
}
