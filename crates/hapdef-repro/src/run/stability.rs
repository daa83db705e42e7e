//! The program's part of the stability tables.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use hapdef::touch::response_map;
use hapdef::{Limb, SceneArgs};
use hapdef_report::MetricLog;
use hapdef_repro::{
    InverseWorld, StabilityRow, StabilityVerdict, inverse_markdown, inverse_rows, nets_markdown,
    nets_rows, stability_differences, stability_line,
};

use super::facts;

/// Arguments of `stability`.
#[derive(clap::Args)]
pub(crate) struct StabilityArgs {
    #[command(flatten)]
    table: TableArgs,
}

/// Arguments of `stability-inverse`.
#[derive(clap::Args)]
pub(crate) struct InverseArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    table: TableArgs,
}

#[derive(clap::Args)]
struct TableArgs {
    /// Write the table to this file.
    #[arg(long)]
    write: Option<PathBuf>,
    /// Fail where this file says something else.
    #[arg(long)]
    check: Option<PathBuf>,
    /// The metrics' file.
    #[arg(long, default_value = "target/hapdef/metrics.json")]
    metrics: PathBuf,
}

impl TableArgs {
    /// Prints a row as it is done; a check tells only what differs.
    fn show(&self, row: &StabilityRow) {
        if self.check.is_none() {
            println!("{}", stability_line(row));
        }
    }
}

/// Runs the rows of nets and baselines.
pub(crate) fn run(args: &StabilityArgs) -> Result<()> {
    let rows = nets_rows(|row| args.table.show(row));
    finish(&args.table, &rows, &nets_markdown(&rows))
}

/// Runs the rows of superposition on a scene's limb.
pub(crate) fn run_inverse(args: &InverseArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let map = response_map(&limb, run.scene.contact.tip_radius_m, run.threads)?;
    let held = limb.clamped.iter().map(|node| limb.mesh.position(*node));
    let world = Arc::new(InverseWorld::new(map, held.collect())?);
    let rows = inverse_rows(&world, |row| args.table.show(row));
    finish(&args.table, &rows, &inverse_markdown(&rows))
}

fn finish(args: &TableArgs, rows: &[StabilityRow], text: &str) -> Result<()> {
    let failed = rows.iter().filter(|row| row.is_failed()).count();
    let wrong = rows
        .iter()
        .filter(|row| row.verdict() == StabilityVerdict::SilentlyWrong);
    let mut log = MetricLog::new(std::io::stdout(), facts::metric_context_of(0));
    log.value("stability.rows", rows.len() as f64, "1")?;
    log.value("stability.failed", failed as f64, "1")?;
    log.value("stability.silently_wrong", wrong.count() as f64, "1")?;
    log.append_to(&args.metrics)?;
    if let Some(path) = &args.write {
        super::search::write(path, text)?;
    }
    if let Some(path) = &args.check {
        let committed =
            std::fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))?;
        let faults = stability_differences(text, &committed);
        if !faults.is_empty() {
            bail!("{} is stale:\n  {}", path.display(), faults.join("\n  "));
        }
    }
    // what the committed file owns to be silently wrong is known; anything else that fails is not
    let is_known = |row: &&StabilityRow| {
        args.check.is_some() && row.verdict() == StabilityVerdict::SilentlyWrong
    };
    let failing = rows.iter().filter(|row| row.is_failed());
    let unknown = failing.filter(|row| !is_known(row)).count();
    if unknown > 0 {
        bail!("{unknown} of {} rows failed", rows.len());
    }
    Ok(())
}
