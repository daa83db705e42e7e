//! The paper's tables and figures, with everything they need.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Result, bail};

use crate::pipeline::{PipelineArgs, common, finish};
use crate::tool::{release_binary, root, run};

/// Arguments of `repro`.
#[derive(clap::Args, Clone)]
pub(crate) struct ReproArgs {
    #[command(flatten)]
    pipeline: PipelineArgs,
    /// The paper's amounts of data; so without `--quick`, too.
    #[arg(long, conflicts_with = "quick")]
    full: bool,
    /// Also writes docs/results.md, and docs/results.json in a full run.
    #[arg(long)]
    write: bool,
}

const RESULTS: &str = "docs/results.md";
const METRICS: &str = "docs/results.json";
const GOLDEN: &str = "crates/hapdef-repro/golden/quick.json";

/// `cargo xtask repro`: the report with every table and figure.
pub(crate) fn repro(args: &ReproArgs) -> Result<()> {
    let is_quick = args.pipeline.quick && !args.full;
    let mut command = Command::new(release_binary("hapdef-repro")?);
    command.arg("repro").args(common(&args.pipeline));
    if args.write {
        for option in written(is_quick, root().join(METRICS).exists())? {
            command.args(option);
        }
    }
    finish(&mut command)
}

/// What `--write` adds to the command line.
fn written(is_quick: bool, has_full_run: bool) -> Result<Vec<[PathBuf; 2]>> {
    let option = |flag: &str, file: &str| [PathBuf::from(flag), root().join(file)];
    if is_quick && has_full_run {
        bail!("{RESULTS} is from a full run and {METRICS} with it; write with --full");
    }
    let mut options = vec![option("--results", RESULTS)];
    if !is_quick {
        options.push(option("--metrics", METRICS));
    }
    Ok(options)
}

/// Compares the report of a quick run of the bundled limb with the golden values.
pub(crate) fn check_golden(report: &Path) -> Result<()> {
    let program = release_binary("hapdef-repro")?;
    run(Command::new(program)
        .arg("golden")
        .arg(report)
        .arg(root().join(GOLDEN)))
}

#[cfg(test)]
mod tests {
    use super::written;

    #[test]
    fn a_quick_run_never_replaces_a_full_one() {
        assert_eq!(written(true, false).unwrap().len(), 1);
        assert_eq!(written(false, true).unwrap().len(), 2);
        assert!(written(true, true).is_err());
    }
}
