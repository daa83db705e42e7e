//! Inference: one frame, one core.

use anyhow::Result;
use hapdef_repro::MetricLog;

use super::BenchNetsArgs;

/// Times every path.
pub(super) fn run(args: &BenchNetsArgs, log: &mut MetricLog<std::io::Stdout>) -> Result<()> {
    let _ = (args, log);
    Ok(())
}
