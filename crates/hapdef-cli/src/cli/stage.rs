//! `hapdef simulate|dataset|train|eval`: the pipeline up to a stage.

use anyhow::Result;
use hapdef::plan::{Rates, pipeline_parts_s};
use hapdef::{Limb, Pipeline, Run, Stage, Until};
use hapdef_cli::print_json;

use super::figure::figure;

/// Runs every stage up to `until` and prints their records.
pub(crate) fn run_until(run: &Run, until: Until, json: bool) -> Result<()> {
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let rates = Rates::recorded(&run.cache, run.threads);
    let parts_s = pipeline_parts_s(run, &limb, &rates)?;
    let done = Pipeline::run_timed(run, &limb, until, &parts_s)?;
    for stage in done.stages() {
        show(stage, json)?;
    }
    Ok(())
}

fn show(stage: &Stage, json: bool) -> Result<()> {
    if json {
        return Ok(print_json(&stage.record, false)?);
    }
    let origin = if stage.cached { "cached" } else { "new" };
    println!("{:10} {origin:6} {:8.1} s", stage.record.stage, stage.record.elapsed_s);
    for (name, value) in stage.record.info.as_object().into_iter().flatten() {
        if !value.is_object() {
            let (name, value) = figure(name, value);
            println!("    {name}: {value}");
        }
    }
    Ok(())
}
