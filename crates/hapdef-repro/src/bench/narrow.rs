//! F_R with fewer neurons, trained like the scene's own.

use anyhow::Result;
use hapdef::stages::Datasets;
use hapdef::{Run, Stage};
use hapdef_nets::{Activation, MlpSpec, Net, TrainParams};
use serde_json::json;

use crate::run::dataset::Rows;
use crate::run::fit::{Training, fit};

/// A narrow net does less work a step; after a brief schedule it gets more of them, up to
/// [`MOST_STEPS`].
const MORE_STEPS: usize = 4;
const MOST_STEPS: usize = 24_000;

/// The net of these hidden layers, from the cache or trained.
pub(super) fn narrow(
    run: &Run,
    data: &Datasets,
    rows: &Rows,
    hidden: &[usize],
) -> Result<(Net, Stage)> {
    let keys: Vec<&str> = data.simulated.iter().map(|s| s.key.as_str()).collect();
    let schedule = run.profile.reconstruction;
    let params = TrainParams {
        steps: (MORE_STEPS * schedule.steps).min(MOST_STEPS.max(schedule.steps)) as u64,
        batch: schedule.batch,
        warmup_steps: schedule.warmup_steps as u64,
        loss: schedule.loss,
        learning_rate: schedule.learning_rate,
        final_learning_rate: Some(schedule.final_learning_rate),
        l2: schedule.l2,
        checkpoint_every: 0,
        validate_every: 0,
        ..TrainParams::paper(run.scene.seed)
    };
    let training = Training { params, scale: run.profile.output_scale, modes: 0 };
    let spec = |inputs, outputs| MlpSpec {
        inputs,
        hidden: hidden.to_vec(),
        outputs,
        activation: Activation::Relu,
    };
    let (name, of) = (format!("F_R of {hidden:?} neurons"), json!({ "datasets": keys }));
    fit(run, &name, &of, &training, spec, || Ok(rows.samples()))
}
