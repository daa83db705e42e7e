//! What `hapdef plan` expected beside what was measured.

use anyhow::{Context, Result};
use hapdef::plan::{Plan, Rates, StepState, When, plan};
use hapdef::scene::EstimatorSpec;
use hapdef::stages::NetKind;
use hapdef::touch::{ChainStages, chain_stages};
use hapdef::{Limb, Profile, Run, Stage};
use hapdef_bench::{Column, or_dash, page_table};
use hapdef_report::ReportTable;
use serde::Serialize;
use std::path::Path;

use super::made_anew;

/// Stages below this time, s, are not judged: a plan is for what one waits for.
const JUDGED_S: f64 = 0.5;

/// Presses of the calibration that is planned.
const N_PRESSES: usize = 300;

/// A stage as it was expected and as it went.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Planned {
    pub(super) stage: String,
    pub(super) predicted_s: f64,
    pub(super) measured_s: f64,
    /// Whether it is a part of a frame: a mean over many, judged however short it is.
    pub(super) is_of_frames: bool,
}

impl Planned {
    /// The larger of both over the smaller.
    fn ratio(&self) -> f64 {
        let ratio = self.predicted_s / self.measured_s;
        ratio.max(ratio.recip())
    }

    fn is_judged(&self) -> bool {
        self.is_of_frames || self.measured_s >= JUDGED_S
    }
}

/// Plans contacts by superposition with a calibration, and the paper's chain in a cache of its own,
/// `folder`, which is emptied; runs both, and lays one beside the other. Rates are those that the run's
/// own cache has.
pub(super) fn measure(run: &Run, limb: &Limb, folder: &Path) -> Result<Vec<Planned>> {
    run.say("a plan, and what it comes to");
    let mut scene = Run { profile: Profile::quick(), ..made_anew(run, folder)? };
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let rates = Rates::recorded(&run.cache, run.threads);
    scene.scene.estimator = EstimatorSpec::Superposition(run.scene.estimator.superposition());
    let mut rows = superposed(&scene, limb, &rates)?;
    scene.scene.estimator = EstimatorSpec::Hapdefx(run.scene.estimator.hapdefx());
    let planned = plan(&scene, limb, &rates)?;
    let stages = chain_stages(&scene, limb)?;
    rows.extend(chained(&planned, &stages)?);
    std::fs::remove_dir_all(folder).with_context(|| folder.display().to_string())?;
    Ok(rows)
}

fn superposed(run: &Run, limb: &Limb, rates: &Rates) -> Result<Vec<Planned>> {
    let planned = plan(run, limb, rates)?.with_calibration(run, limb, rates, N_PRESSES)?;
    let of_frames = |name: &str| {
        let step = planned.steps.iter().find(|step| step.name == name);
        step.is_some_and(|step| step.when == When::Frame)
    };
    let measured = planned.measured(run, limb, N_PRESSES)?;
    let rows = measured.iter().map(|step| Planned {
        stage: step.step.to_owned(),
        predicted_s: step.predicted_s,
        measured_s: step.measured_s,
        is_of_frames: of_frames(step.step),
    });
    Ok(rows.collect())
}

fn chained(planned: &Plan, stages: &ChainStages) -> Result<Vec<Planned>> {
    let mut rows = Vec::new();
    for step in &planned.steps {
        if step.when != When::Design || step.state != StepState::Runs {
            continue;
        }
        let stage = stage_of(&step.name, stages)
            .with_context(|| format!("the plan's step {} is no stage", step.name))?;
        rows.push(Planned {
            stage: step.name.clone(),
            predicted_s: step.predicted_s.context("a step without expected time")?,
            measured_s: stage.record.elapsed_s,
            is_of_frames: false,
        });
    }
    Ok(rows)
}

fn stage_of<'a>(name: &str, stages: &'a ChainStages) -> Option<&'a Stage> {
    let ChainStages { compliance, rig, data, nets } = stages;
    let set = |i: usize| data.simulated.get(i);
    match name {
        "compliance" => Some(compliance),
        "rig" => Some(rig),
        "set I" => set(0),
        "set II" => set(1),
        "set III" => set(2),
        "set IV" => set(3),
        "rig's single presses" => Some(&data.rig_single),
        "rig's double presses" => data.rig_double.as_ref(),
        _ => {
            let is_named = |kind: NetKind| kind.name() == name;
            let net = nets.nets.iter().find(|net| is_named(net.kind));
            net.map(|net| &net.stage)
        }
    }
}

fn seconds(value_s: f64) -> String {
    if value_s < 0.01 {
        return format!("{value_s:.1e}");
    }
    format!("{value_s:.2}")
}

/// The worst ratio of the judged stages; none if none is.
pub(super) fn worst_ratio(rows: &[Planned]) -> Option<f64> {
    let judged = rows.iter().filter(|row| row.is_judged());
    judged.map(Planned::ratio).reduce(f64::max)
}

const COLUMNS: [Column<Planned>; 4] = [
    Column::new("stage", |p| p.stage.clone()),
    Column::new("expected, s", |p| seconds(p.predicted_s)),
    Column::new("measured, s", |p| seconds(p.measured_s)),
    Column::new("ratio", |p| or_dash(p.is_judged().then(|| format!("{:.2}", p.ratio())))),
];

pub(super) fn table(rows: &[Planned]) -> Result<ReportTable> {
    let note = format!(
        "Contacts by superposition, {N_PRESSES} presses; then the paper's chain in quick amounts, \
         nothing in the cache. Stages of less than {JUDGED_S} s have no ratio, parts of a frame have \
         one."
    );
    let text = hapdef_bench::table(&COLUMNS, rows);
    Ok(page_table("What `hapdef plan` expected", note, text, rows)?)
}
