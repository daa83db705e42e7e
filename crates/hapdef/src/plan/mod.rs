//! What a scene will take before anything is solved: its stages, what is left out and why, sizes,
//! operations, bytes, expected time.
//!
//! The stages and their places in the cache come from the very functions that run them, on a cache
//! that only looks ([`crate::Cache::looking`]): the run follows the plan.

mod calibration;
mod chain;
mod elastic;
mod frames;
mod measured;
mod rates;
mod shell;
mod skip;
mod superposition;

use std::collections::BTreeMap;

use hapdef_live::estimator::EstimatorKind;
use serde::Serialize;

pub use measured::MeasuredStep;
pub use rates::Rates;
pub use skip::Skip;

use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::scene::EstimatorSpec;
use crate::work::Work;

/// The plan of a scene's estimator.
#[derive(Clone, Debug, Serialize)]
pub struct Plan {
    /// Name of the scene.
    pub scene: String,
    /// What finds contacts.
    pub estimator: EstimatorKind,
    /// Name of the profile.
    pub profile: String,
    /// The steps, those of the design time first, then those of one frame.
    pub steps: Vec<PlanStep>,
}

/// One step of a plan.
#[derive(Clone, Debug, Serialize)]
pub struct PlanStep {
    /// Its name.
    pub name: String,
    /// Once at design time, or for every frame.
    pub when: When,
    /// Whether it runs.
    pub state: StepState,
    /// What is left out with it; none of a step that is not skipped.
    pub skip: Option<Skip>,
    /// Why it runs, is answered by the cache, or is left out.
    pub why: String,
    /// Numbers of nodes, equations, right-hand sides, samples, parameters.
    pub sizes: BTreeMap<&'static str, u64>,
    /// Floating-point operations; 0 where it does not run.
    pub flops: f64,
    /// Bytes of what it leaves, or reads in each frame; 0 where it does not run.
    pub bytes: f64,
    /// Expected time, s; none where no rule is known.
    pub predicted_s: Option<f64>,
    /// Time that the cached stage took when it was made, s.
    pub recorded_s: Option<f64>,
    /// What its time is expected by.
    #[serde(skip)]
    work: Option<Work>,
}

/// When a step runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum When {
    /// Once, before the first frame.
    Design,
    /// For every frame that something touches.
    Frame,
}

/// Whether a step runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StepState {
    /// It runs.
    Runs,
    /// The cache has its result.
    Cached,
    /// The scene does not need it.
    Skipped,
    /// It would take the place of others, and change the result; the scene does not choose it.
    Alternative,
}

/// Plans what the scene's estimator needs, as [`crate::touch::touch_estimator`] makes it. The limb
/// is ordered where a factorisation is ahead; nothing is solved.
///
/// # Errors
/// [`HapdefError::Sim`] when the limb floats; [`HapdefError::Stale`] for a damaged record or a
/// calibration of another limb; [`HapdefError::File`] where that is missing.
pub fn plan(run: &Run, limb: &Limb, rates: &Rates) -> Result<Plan, HapdefError> {
    let (estimator, steps) = match &run.scene.estimator {
        EstimatorSpec::Hapdefx(_) => (EstimatorKind::Hapdefx, chain::steps(run, limb, rates)?),
        EstimatorSpec::Superposition(spec) => {
            (EstimatorKind::Superposition, superposition::steps(run, limb, spec, rates)?)
        }
    };
    Ok(Plan { scene: run.scene.name.clone(), estimator, profile: run.profile.name.clone(), steps })
}

/// Expected time of the parts of [`crate::Pipeline`] that are not in the cache, s: compliance, rig,
/// datasets, nets.
///
/// # Errors
/// As [`plan`].
pub fn pipeline_parts_s(run: &Run, limb: &Limb, rates: &Rates) -> Result<[f64; 4], HapdefError> {
    chain::parts_s(run, limb, rates)
}

impl Plan {
    /// The step of a name, if the plan has it.
    #[must_use]
    pub fn step(&self, name: &str) -> Option<&PlanStep> {
        self.steps.iter().find(|step| step.name == name)
    }

    /// Expected time of all design steps that run, s.
    #[must_use]
    pub fn predicted_s(&self) -> f64 {
        let design = self.steps.iter().filter(|step| step.when == When::Design);
        design.filter_map(|step| step.predicted_s).sum()
    }
}

impl PlanStep {
    fn runs(name: &str, why: impl Into<String>, sizes: &[(&'static str, usize)]) -> Self {
        let sizes = sizes.iter().map(|&(name, n)| (name, n as u64));
        Self {
            name: name.into(),
            when: When::Design,
            state: StepState::Runs,
            skip: None,
            why: why.into(),
            sizes: sizes.collect(),
            flops: 0.0,
            bytes: 0.0,
            predicted_s: None,
            recorded_s: None,
            work: None,
        }
    }

    fn skipped(
        skip: Skip,
        name: &str,
        why: impl Into<String>,
        sizes: &[(&'static str, usize)],
    ) -> Self {
        Self { state: StepState::Skipped, skip: Some(skip), ..Self::runs(name, why, sizes) }
    }

    fn alternative(name: &str, why: impl Into<String>, sizes: &[(&'static str, usize)]) -> Self {
        Self { state: StepState::Alternative, ..Self::runs(name, why, sizes) }
    }

    fn costing(self, work: Work, rates: &Rates) -> Self {
        let (flops, bytes, predicted_s) = (work.flops, work.bytes, rates.seconds(&work));
        Self { flops, bytes, predicted_s, work: Some(work), ..self }
    }

    fn each_frame(self) -> Self {
        Self { when: When::Frame, ..self }
    }
}
