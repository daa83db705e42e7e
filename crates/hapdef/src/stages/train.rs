//! Stage: the networks, each trained on its own and resumable.

use std::cell::OnceCell;
use std::path::PathBuf;

use hapdef_nets::train::{BatchSource, TrainInfo};
use hapdef_nets::{Net, TrainParams, load};
use nalgebra::Point3;
use serde_json::{Value, json};

use super::dataset::Datasets;
use super::drawn::DrawnSamples;
use super::keys;
use super::nets::{CHECKPOINT_FILE, NetKind};
use super::simulate::COMPLIANCE_FILE;
use super::training::Training;
use crate::cache::Stage;
use crate::compliance::ComplianceTable;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::profile::{OutputScale, Samples, Schedule};
use crate::run::Run;
use crate::work::Work;

const VERSION: u32 = 2;

/// Steps between checkpoints.
const CHECKPOINT_EVERY: u64 = 1000;

/// Looks at the validation set during a training.
const N_VALIDATIONS: u64 = 20;

/// Set into the seed of a net's training to get the seed of the samples that are drawn for it.
const DRAWN_SEED: u64 = 0x6472_6177;

/// A trained net's stage.
#[derive(Clone, Debug)]
pub struct TrainedNet {
    /// Which net.
    pub kind: NetKind,
    /// Its stage.
    pub stage: Stage,
}

/// All trained nets of a scene.
#[derive(Clone, Debug)]
pub struct TrainedNets {
    /// The nets in the order in which they were trained.
    pub nets: Vec<TrainedNet>,
}

impl TrainedNet {
    /// Path of the checkpoint.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        self.stage.dir.join(CHECKPOINT_FILE)
    }
}

impl TrainedNets {
    /// Reads a net.
    ///
    /// # Errors
    /// [`HapdefError::Net`] when its checkpoint is damaged, [`HapdefError::Stale`] when the net was
    /// not trained.
    pub fn load(&self, kind: NetKind) -> Result<Net, HapdefError> {
        let trained = self.nets.iter().find(|net| net.kind == kind).ok_or_else(|| {
            HapdefError::Stale { path: kind.name().into(), what: "the net is not trained".into() }
        })?;
        Ok(load(&trained.path())?.0)
    }
}

/// Trains every net: F_R on each union of sets of Table 1, then F_T, F_S and the direct net.
///
/// # Errors
/// [`HapdefError::Stopped`] when the person stopped it (a checkpoint is kept),
/// [`HapdefError::Net`] when a loss is no number or a net has learned nothing.
pub fn train(
    run: &Run,
    limb: &Limb,
    compliance: &Stage,
    data: &Datasets,
) -> Result<TrainedNets, HapdefError> {
    let unions = (1..=data.simulated.len()).map(|n_sets| NetKind::Reconstruction { n_sets });
    let others = [NetKind::Transfer, NetKind::Sensitivity, NetKind::Direct];
    let kinds: Vec<NetKind> = unions.chain(others).collect();
    train_kinds(run, limb, compliance, data, &kinds)
}

/// Trains the nets `kinds` only, in this order.
///
/// # Errors
/// As [`train`].
pub fn train_kinds(
    run: &Run,
    limb: &Limb,
    compliance: &Stage,
    data: &Datasets,
    kinds: &[NetKind],
) -> Result<TrainedNets, HapdefError> {
    let trainer =
        Trainer { run, data, compliance, points: limb.surface_points(), table: OnceCell::new() };
    let nets = kinds.iter().map(|&kind| {
        let stage = trainer.stage(kind)?;
        Ok(TrainedNet { kind, stage })
    });
    Ok(TrainedNets { nets: nets.collect::<Result<_, HapdefError>>()? })
}

/// Trains nets; the compliance table is read when the first net wants samples drawn.
struct Trainer<'a> {
    run: &'a Run,
    data: &'a Datasets,
    compliance: &'a Stage,
    points: Vec<Point3<f64>>,
    table: OnceCell<ComplianceTable>,
}

impl Trainer<'_> {
    fn stage(&self, kind: NetKind) -> Result<Stage, HapdefError> {
        let (run, params) = (self.run, params(self.run, kind));
        run.cache.stage("net", &self.inputs(kind, &params), |dir| {
            let [mut fixed, mut validation] = kind.samples(self.data)?;
            let mut drawn = self.drawn(kind, &params, fixed.n_samples())?;
            let n_samples = match drawn {
                Some(_) => params.steps as usize * params.batch,
                None => fixed.n_samples(),
            };
            run.say(&format!(
                "training {}: {n_samples} samples{}, {} steps of {}",
                kind.name(),
                if drawn.is_some() { " drawn" } else { "" },
                params.steps,
                params.batch,
            ));
            let modes = self.output_modes(kind, fixed.n_outputs());
            let spec = kind.spec(fixed.n_inputs(), modes.unwrap_or(fixed.n_outputs()));
            let training = Training {
                run,
                name: &kind.name(),
                spec: &|n_inputs, n_outputs| kind.spec(n_inputs, n_outputs),
                params: &params,
                dir,
                output_modes: modes.unwrap_or(0),
                output_scale: self.output_scale(kind),
            };
            let drawn = drawn.as_mut().map(|drawn| drawn as &mut dyn BatchSource);
            let (info, net) = training.run(fixed.as_mut(), drawn, Some(validation.as_mut()))?;
            if info.stopped_early {
                return Err(HapdefError::Stopped { stage: format!("training {}", kind.name()) });
            }
            let n_trained = info.step as usize * params.batch;
            let mut work = Work::training(kind.into(), &spec, n_trained);
            if let (NetKind::Reconstruction { n_sets }, true) = (kind, self.is_drawn(kind)) {
                let n_nodes = spec.inputs + self.points.len();
                work = work.drawing(n_trained, n_sets.div_ceil(2), n_nodes, modes.unwrap_or(0));
            }
            let mut record = record(kind, n_samples, &info, &net);
            record["work"] = json!(work.done(run.threads));
            Ok(record)
        })
    }

    /// The modes that F_R is trained in, where its outputs are more.
    fn output_modes(&self, kind: NetKind, n_outputs: usize) -> Option<usize> {
        let rank = self.run.profile.output_modes;
        let is_map = matches!(kind, NetKind::Reconstruction { .. });
        (is_map && rank > 0 && rank < n_outputs).then_some(rank)
    }

    fn output_scale(&self, kind: NetKind) -> OutputScale {
        match kind {
            NetKind::Reconstruction { .. } => self.run.profile.output_scale,
            _ => OutputScale::Each,
        }
    }

    fn is_drawn(&self, kind: NetKind) -> bool {
        let is_map = matches!(kind, NetKind::Reconstruction { .. });
        is_map && self.run.profile.samples == Samples::Drawn
    }

    fn inputs(&self, kind: NetKind, params: &TrainParams) -> Value {
        let sets = kind.datasets(self.data);
        let datasets: Vec<&str> = sets.iter().map(|stage| stage.key.as_str()).collect();
        let draws = self.is_drawn(kind).then(|| keys::draws(&self.run.scene.contact));
        json!({
            "version": VERSION,
            "kind": kind,
            "limb": self.compliance.key,
            "datasets": datasets,
            "params": params,
            "draws": draws,
            "output_modes": self.output_modes(kind, self.points.len()),
            "output_scale": self.output_scale(kind),
        })
    }

    /// The samples that a net's training draws, if it does; `n_pass` count as a pass.
    fn drawn(
        &self,
        kind: NetKind,
        params: &TrainParams,
        n_pass: usize,
    ) -> Result<Option<DrawnSamples<'_>>, HapdefError> {
        let NetKind::Reconstruction { n_sets } = kind else {
            return Ok(None);
        };
        if !self.is_drawn(kind) {
            return Ok(None);
        }
        let (contact, seed) = (&self.run.scene.contact, params.seed ^ DRAWN_SEED);
        let (table, points) = (self.table()?, &self.points);
        let samples = DrawnSamples::new(table, points, contact, n_sets, seed, n_pass);
        Ok(Some(samples))
    }

    fn table(&self) -> Result<&ComplianceTable, HapdefError> {
        if let Some(table) = self.table.get() {
            return Ok(table);
        }
        let path = self.compliance.dir.join(COMPLIANCE_FILE);
        let table = ComplianceTable::read(&path, self.points.len())?;
        Ok(self.table.get_or_init(|| table))
    }
}

fn params(run: &Run, kind: NetKind) -> TrainParams {
    let profile = &run.profile;
    let (schedule, stream) = match kind {
        NetKind::Transfer => (profile.transfer, 1),
        NetKind::Sensitivity => (profile.sensitivity, 2),
        NetKind::Direct => (profile.direct, 3),
        NetKind::Reconstruction { n_sets } => (profile.reconstruction, 10 + n_sets as u64),
    };
    let Schedule {
        steps,
        batch,
        warmup_steps,
        learning_rate,
        final_learning_rate,
        loss,
        l2,
        patience,
    } = schedule;
    TrainParams {
        steps: steps as u64,
        batch,
        learning_rate,
        final_learning_rate: Some(final_learning_rate),
        warmup_steps: warmup_steps as u64,
        loss,
        l2,
        backend: profile.backend,
        seed: run.scene.seed.wrapping_mul(1000).wrapping_add(stream),
        checkpoint_every: CHECKPOINT_EVERY,
        validate_every: (steps as u64 / N_VALIDATIONS).max(1),
        keep_best: true,
        patience,
    }
}

fn record(kind: NetKind, n_samples: usize, info: &TrainInfo, net: &Net) -> Value {
    let looks = || info.looks.iter();
    json!({
        "net": kind.name(),
        "n_samples": n_samples,
        "steps": info.step,
        "kept_step": info.kept_step,
        "train_loss": info.train_loss,
        "validation_loss": info.validation_loss,
        "constant_inputs": net.input_scale().constant_columns().collect::<Vec<_>>(),
        "constant_outputs": net.output_scale().constant_columns().collect::<Vec<_>>(),
        "samples_per_s": info.samples_per_s,
        "history": {
            "step": looks().map(|look| look.step).collect::<Vec<_>>(),
            "train_loss": looks().map(|look| look.train_loss).collect::<Vec<_>>(),
            "validation_loss": looks().map(|look| look.validation_loss).collect::<Vec<_>>(),
        },
    })
}
