//! `hapdef-verify stability`: the solver at its extremes.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::ValueEnum;
use hapdef_mesh::atomic_write;
use hapdef_report::{MetricContext, MetricLog, StabilityCase, log_stability};
use hapdef_verify::{
    STABILITY_DOCUMENT, StabilityRow, stability_line, stability_page, stability_rows,
};

use super::context::{FiguresArgs, write_page};

/// Arguments of `stability`.
#[derive(clap::Args)]
pub(crate) struct StabilityArgs {
    /// What is tried.
    #[arg(value_enum)]
    part: Part,
    /// Write the table to this file.
    #[arg(long)]
    write: Option<PathBuf>,
    /// Compare what was said and the verdicts with this file; fail where they differ.
    #[arg(long, conflicts_with = "write")]
    check: Option<PathBuf>,
    /// Print the rows as one JSON array instead of text.
    #[arg(long)]
    json: bool,
    /// Draws which elements are stiff where they are scattered at random.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    figures: FiguresArgs,
}

/// What is tried at its extremes.
#[derive(Clone, Copy, ValueEnum)]
enum Part {
    /// The elasticity solver.
    Fe,
}

/// Solves, prints and judges; false where a row is silently wrong or not what it should be.
pub(crate) fn run(args: &StabilityArgs) -> Result<bool> {
    let Part::Fe = args.part;
    let rows = stability_rows(args.seed, |row| {
        if !args.json {
            println!("{}", stability_line(row));
        }
    })?;
    let data: serde_json::Value = rows.iter().map(json).collect();
    if args.json {
        println!("{data}");
    }
    if let Some(path) = &args.write {
        let text = STABILITY_DOCUMENT.markdown(&rows);
        atomic_write(path, |file| file.write_all(text.as_bytes()))
            .with_context(|| format!("writing {}", path.display()))?;
    }
    let mut log = MetricLog::new(std::io::stdout(), MetricContext::here(args.seed));
    log_stability(&rows, &mut log)?;
    log.append_to(&args.figures.metrics)?;
    write_page(stability_page(&rows, data), &log, &args.figures.metrics, "stability-fe")?;
    Ok(agrees(args, &rows)? && !rows.iter().any(StabilityCase::is_failed))
}

fn agrees(args: &StabilityArgs, rows: &[StabilityRow]) -> Result<bool> {
    let Some(path) = &args.check else {
        return Ok(true);
    };
    let committed =
        std::fs::read_to_string(path).with_context(|| format!("reading {}", path.display()))?;
    let faults = STABILITY_DOCUMENT.differences(&STABILITY_DOCUMENT.markdown(rows), &committed);
    for fault in &faults {
        eprintln!("{}: {fault}", path.display());
    }
    Ok(faults.is_empty())
}

fn json(row: &StabilityRow) -> serde_json::Value {
    let figures = row.outcome.as_ref().ok();
    serde_json::json!({
        "case": row.case,
        "extreme": row.extreme,
        "path": row.path,
        "equations": figures.map(|f| f.n_equations),
        "error": figures.map(|f| f.error),
        "relative_residual": figures.map(|f| f.info.worst_relative_residual),
        "backward_error": figures.map(|f| f.info.worst_backward_error),
        "condition": figures.and_then(|f| f.info.condition),
        "bound": figures.map(|f| f.bound()),
        "said": row.said(),
        "text": row.outcome.as_ref().err().map(|refusal| &refusal.text),
        "verdict": row.verdict().word(),
        "failed": row.is_failed(),
    })
}
