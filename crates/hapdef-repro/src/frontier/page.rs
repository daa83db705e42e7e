//! The frontier as METRIC lines, tables, plots and a page.

use anyhow::Result;
use hapdef::Run;
use hapdef_report::{NamedText, Report, SkippedStage};

use super::figures::STUDY;
use super::plots::figures;
use super::point::Family;
use super::tables::tables;
use super::{ChainFrontierArgs, Measured, limits};
use crate::run::facts::{self, named};

/// Prints the figures and writes `frontier/` under the scene's folder.
pub(super) fn write(args: &ChainFrontierArgs, run: &Run, measured: &Measured) -> Result<()> {
    let mut log = facts::log(args.test_seed);
    for growth in &measured.growths {
        log.value(&format!("frontier.{}", growth.metric), growth.exponent, "1")?;
    }
    let study = facts::study(run, "error against run time", args.test_seed)?;
    let report = Report {
        profile: run.profile.name.clone(),
        facts: [study.facts, facts_of(args, measured)].concat(),
        tables: tables(run, measured)?,
        figures: figures(measured)?,
        skipped: skipped(args, measured),
        ..study
    };
    let report = STUDY.publish(measured, report, &mut log, &args.scene.results)?;
    match &args.write {
        Some(path) => limits::write(path, args, run, &report, &measured.points),
        None => Ok(()),
    }
}

fn facts_of(args: &ChainFrontierArgs, measured: &Measured) -> Vec<NamedText> {
    let frames = format!(
        "{} of one contact and as many of two are scored, searched and followed, and at least 1,000 of \
         two timed; seed {}, on which nothing was tuned",
        args.frames, args.test_seed
    );
    let budget = format!(
        "{} minutes: {} configurations by superposition of {}; points that an earlier run of this program on this \
         machine measured: {}",
        args.minutes,
        n_superposed(measured),
        measured.n_configurations,
        measured.n_kept
    );
    vec![named("frames", frames), named("budget", budget)]
}

fn skipped(args: &ChainFrontierArgs, measured: &Measured) -> Vec<SkippedStage> {
    let mut skipped = Vec::new();
    let mut skip = |name: &str, reason: String| {
        skipped.push(SkippedStage { name: name.into(), reason });
    };
    if args.without_nets {
        skip("the paper's chain, plan", "--without-nets".into());
    }
    if let Some(reason) = &measured.no_shell {
        skip("configurations on a shell of the skin", reason.clone());
    }
    for refused in &measured.refused {
        skip(&refused.configuration, format!("refused: {}", refused.why));
    }
    let n_left = measured.n_configurations - n_superposed(measured) - measured.refused.len();
    if n_left > 0 {
        let reason = format!("{} minutes are over; more go on from here", args.minutes);
        skip(&format!("{n_left} further configurations"), reason);
    }
    skipped
}

/// Configurations by superposition that were measured.
fn n_superposed(measured: &Measured) -> usize {
    let points = measured.points.iter();
    points.filter(|p| p.family != Family::Chain).count()
}
