//! F_R with fewer neurons, trained like the scene's own.

use std::ops::ControlFlow;

use anyhow::{Context, Result};
use hapdef::stages::{Datasets, fit_scales};
use hapdef::{HapdefError, Run, Stage};
use hapdef_nets::train::{MemorySource, train};
use hapdef_nets::{Activation, Mlp, MlpSpec, Net, TrainParams, load};
use serde_json::{Value, json};

use crate::run::dataset::{Dataset, blocks};

const VERSION: u32 = 1;
const CHECKPOINT_FILE: &str = "net.json";

/// Rows read together.
const BLOCK: usize = 512;

/// A narrow net does less work a step; after a brief schedule it gets more of them, up to
/// [`MOST_STEPS`].
const MORE_STEPS: usize = 4;
const MOST_STEPS: usize = 24_000;

/// Training samples of F_R on every simulated set, in memory.
pub(super) struct TrainingRows {
    /// `[n, n_virtual]`, µm.
    pub(super) x: Vec<f32>,
    /// `[n, n_surface]`, µm.
    pub(super) y: Vec<f32>,
    pub(super) n_virtual: usize,
    pub(super) n_surface: usize,
}

impl TrainingRows {
    /// Reads them all.
    pub(super) fn read(data: &Datasets) -> Result<Self> {
        let mut sets = Dataset::open_all(data)?;
        let (n_virtual, n_surface) = (sets[0].n_virtual, sets[0].n_surface);
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for set in &mut sets {
            for rows in blocks(set.split()?.train, BLOCK) {
                x.extend(set.inputs(rows.clone())?);
                y.extend(set.maps(rows)?);
            }
        }
        Ok(Self { x, y, n_virtual, n_surface })
    }

    /// Inputs of at most `most` samples, evenly apart.
    pub(super) fn some_inputs(&self, most: usize) -> Vec<f32> {
        let n = self.x.len() / self.n_virtual;
        let step = n.div_ceil(most).max(1);
        let rows = self.x.chunks_exact(self.n_virtual).step_by(step);
        rows.flatten().copied().collect()
    }
}

/// The net of these hidden layers, from the cache or trained.
pub(super) fn narrow(
    run: &Run,
    data: &Datasets,
    rows: &TrainingRows,
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
    let inputs = json!({
        "version": VERSION, "hidden": hidden, "datasets": keys, "params": params,
        "output_scale": run.profile.output_scale,
    });
    let stage = run.cache.stage("net-narrow", &inputs, |dir| {
        run.say(&format!("training F_R of {hidden:?} neurons"));
        fit(run, rows, hidden, &params, &dir.join(CHECKPOINT_FILE))
    })?;
    let (net, _) = load(&stage.dir.join(CHECKPOINT_FILE)).context("a narrow net")?;
    Ok((net, stage))
}

fn fit(
    run: &Run,
    rows: &TrainingRows,
    hidden: &[usize],
    params: &TrainParams,
    path: &std::path::Path,
) -> Result<Value, HapdefError> {
    let spec = MlpSpec {
        inputs: rows.n_virtual,
        hidden: hidden.to_vec(),
        outputs: rows.n_surface,
        activation: Activation::Relu,
    };
    let (x, y) = (rows.x.clone(), rows.y.clone());
    let mut samples = MemorySource::new(rows.n_virtual, rows.n_surface, x, y)?;
    let [input, output] = fit_scales(&mut samples, run.profile.output_scale)?;
    let mut net = Net::new(Mlp::random(&spec, params.seed)?, input, output)?;
    let info = train(&mut net, &mut samples, None, params, Some(path), &mut |_| {
        if run.stopping() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    run.check_stop("training a narrow net")?;
    Ok(json!({ "train_loss": info.train_loss, "steps": info.step }))
}
