//! The program's part of the robustness tables.

use std::path::PathBuf;

use anyhow::{Result, bail};
use hapdef::Limb;
use hapdef::touch::response_map;
use hapdef_bench::robustness::{Inputs, Outputs, Table, publish_all};
use hapdef_cli::SceneArgs;
use hapdef_report::MetricContext;

use super::facts;
use crate::robustness::{
    INVERSE_TABLE, InverseWorld, NETS_TABLE, PARTS_TABLE, Trials, inverse_trials, nets_trials,
    parts_trials,
};

/// Arguments of `robustness` and `robustness-parts`.
#[derive(clap::Args)]
pub(crate) struct TableArgs {
    /// Write the table to this file.
    #[arg(long)]
    write: Option<PathBuf>,
    /// Fail where this file says something else.
    #[arg(long)]
    check: Option<PathBuf>,
    #[command(flatten)]
    all: AllArgs,
    /// Seed of what rows draw; that of the tables in docs/ is 0.
    #[arg(long, default_value_t = 0)]
    test_seed: u64,
}

/// Arguments of `robustness-inverse`.
#[derive(clap::Args)]
pub(crate) struct InverseArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    table: TableArgs,
}

/// Arguments of `robustness-all`.
#[derive(clap::Args)]
pub(crate) struct AllArgs {
    /// The metrics' file; the pages are in folders beside it.
    #[arg(long, env = "HAPDEF_METRICS", default_value = "target/hapdef/metrics.json")]
    metrics: PathBuf,
}

/// Runs the rows of nets and baselines.
pub(crate) fn run_nets(args: &TableArgs) -> Result<()> {
    args.run(&NETS_TABLE, Inputs::default(), nets_trials(args.test_seed))
}

/// Runs the rows of the parts around them.
pub(crate) fn run_parts(args: &TableArgs) -> Result<()> {
    args.run(&PARTS_TABLE, Inputs::default(), parts_trials(args.test_seed))
}

/// Runs the rows of superposition on a scene's limb.
pub(crate) fn run_inverse(args: &InverseArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let map = response_map(&limb, run.scene.contact.tip_radius_m, run.threads)?;
    let held = limb.clamped.iter().map(|node| limb.mesh.position(*node));
    let world = InverseWorld::new(map, held.collect(), args.table.test_seed)?;
    let inputs = Inputs { scene: run.scene.name.clone(), hashes: facts::input_hashes(&run)? };
    args.table.run(&INVERSE_TABLE, inputs, inverse_trials(&world))
}

/// Joins the rows of all parts, and says what they come to.
pub(crate) fn run_all(args: &AllArgs) -> Result<()> {
    let parts = ["stability-fe", NETS_TABLE.folder, INVERSE_TABLE.folder, PARTS_TABLE.folder];
    let published = publish_all(&parts, "stability", std::io::stdout(), &args.metrics)?;
    println!("page: {}", published.page.display());
    Ok(())
}

impl TableArgs {
    /// Prints a row as it is done; a check says only what differs.
    fn run<W>(&self, table: &Table, inputs: Inputs, trials: Trials<W>) -> Result<()> {
        let rows = table.rows(trials, |row| {
            if self.check.is_none() {
                println!("{}", row.line());
            }
        });
        let outputs = Outputs {
            metrics: &self.all.metrics,
            write: self.write.as_deref(),
            check: self.check.as_deref(),
        };
        let log = (std::io::stdout(), MetricContext::here(self.test_seed));
        let published = table.publish(&rows, inputs, log, outputs)?;
        println!("page: {}", published.page.display());
        if let (Some(path), false) = (&self.check, published.differences.is_empty()) {
            bail!("{} is stale:\n  {}", path.display(), published.differences.join("\n  "));
        }
        if published.n_failed > 0 {
            bail!("{} of {} rows failed", published.n_failed, rows.len());
        }
        Ok(())
    }
}
