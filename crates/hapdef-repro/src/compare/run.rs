//! The comparison, row by row.

use anyhow::Result;
use hapdef::Limb;

use super::arrivals;
use super::cases::{CASES, CASES_OF_MORE_GAUGES};
use super::diagnose::diagnose;
use super::figures::Measured;
use super::loads::{load_scene, loads};
use super::paper::{PaperPipeline, VirtualGauges};
use super::rig::Layout;
use super::score::Row;
use super::setup::{Bench, CompareArgs, N_FEW};
use super::tables;

/// Measures, prints and writes the comparison.
pub(crate) fn run(args: &CompareArgs) -> Result<()> {
    let mut run = args.training.prepare(&args.scene)?;
    if args.loads {
        load_scene(&mut run)?;
    }
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let mut bench = Bench::build(&run, &limb, args)?;
    if args.loads {
        return loads(&mut bench);
    }
    let mut measured = Measured::default();
    for case in &CASES {
        measured.rows.push(bench.found(case, |_, _, _, _| Ok(()))?.row(case.name));
    }
    let few = bench.map(Layout::Scene, N_FEW)?.calibrated.info.relative_error;
    let (params, singles) = (bench.params(), bench.drawn().singles(args.frames)?);
    let many = bench.map(Layout::Scene, args.presses)?;
    let info = &many.calibrated.info;
    measured.map_errors = [info.relative_error, few, info.relative_error_before];
    let estimator = many.estimator(params)?;
    measured.bound_ratio = many.bound_ratio(&estimator, &singles)?;
    arrivals::add(&bench, &estimator, &mut measured)?;
    let (palms, rows) = bench.palms()?;
    measured.palms = Some(palms);
    measured.rows.extend(rows);
    for case in bench.possible(&CASES_OF_MORE_GAUGES) {
        measured.rows.push(bench.found(case, |_, _, _, _| Ok(()))?.row(case.name));
    }
    if !args.without_paper {
        measured.rows.extend(by_the_paper(&bench)?);
    }
    tables::publish(&bench, &measured)?;
    if args.diagnose {
        diagnose(&mut bench)?;
    }
    Ok(())
}

/// The paper's pipeline on the single contacts and on the doubles; of each the better ranking first.
fn by_the_paper(bench: &Bench<'_>) -> Result<Vec<Row>> {
    let mut paper = PaperPipeline::train(bench.run, bench.limb)?;
    let (drawn, n) = (bench.drawn(), bench.args.frames);
    let mut all = Vec::new();
    for (what, frames) in [("single", drawn.singles(n)?), ("double", drawn.doubles(n)?)] {
        for of in [VirtualGauges::Transferred, VirtualGauges::Exact] {
            let mut rows = bench.paper_rows(&mut paper, &frames, of)?;
            for row in &mut rows {
                row.name.push_str(&format!(", {what}"));
            }
            rows.sort_by(|a, b| a.errors.mean_mm.total_cmp(&b.errors.mean_mm));
            all.extend(rows);
        }
    }
    Ok(all)
}
