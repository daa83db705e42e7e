//! The steps of the paper's chain.

use hapdef_nets::MlpSpec;

use super::elastic::{left_out_loads, limb_estimate, rig_estimate};
use super::{PlanStep, Rates, Skip, StepState};
use crate::cache::Stage;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::pipeline::{Pipeline, Until};
use crate::profile::{Samples, Schedule};
use crate::run::Run;
use crate::stages::{self, Datasets, NetKind};
use crate::touch::{ChainStages, chain_stages};
use crate::work::{Work, WorkKind, table_bytes};

/// Most contacts of a sample: the paper's sets I to IV.
const MOST_CONTACTS: usize = 4;

pub(super) fn steps(run: &Run, limb: &Limb, rates: &Rates) -> Result<Vec<PlanStep>, HapdefError> {
    let stages = chain_stages(&looking(run), limb)?;
    let planner = Planner { run, limb, rates };
    let mut steps = planner.elastic(&stages)?;
    steps.extend(planner.datasets(&stages.data));
    steps.extend(planner.nets(&stages));
    steps.extend(planner.frame());
    Ok(steps)
}

/// The compliance of the skin on its own.
pub(super) fn compliance_step(
    run: &Run,
    limb: &Limb,
    rates: &Rates,
) -> Result<PlanStep, HapdefError> {
    let stage = stages::compliance(&looking(run), limb)?;
    Planner { run, limb, rates }.compliance(&stage)
}

/// Expected time of what a pipeline up to its nets has to run, s: compliance, rig, datasets, nets.
pub(super) fn parts_s(run: &Run, limb: &Limb, rates: &Rates) -> Result<[f64; 4], HapdefError> {
    let stages = Pipeline::run(&looking(run), limb, Until::Train)?;
    let planner = Planner { run, limb, rates };
    let sum_s = |steps: &[PlanStep]| steps.iter().filter_map(|step| step.predicted_s).sum();
    let data = stages.data.iter().flat_map(|data| planner.datasets(data));
    let nets = stages.nets.iter().flat_map(|nets| &nets.nets);
    let nets = nets.map(|net| planner.net(net.kind, &net.stage));
    Ok([
        sum_s(&[planner.compliance(&stages.compliance)?]),
        sum_s(&[planner.rig(&stages.rig)?]),
        sum_s(&data.collect::<Vec<_>>()),
        sum_s(&nets.collect::<Vec<_>>()),
    ])
}

/// The same run on a cache that only looks.
fn looking(run: &Run) -> Run {
    Run {
        cache: run.cache.looking(),
        scene: run.scene.clone(),
        scene_dir: run.scene_dir.clone(),
        scene_hash: run.scene_hash.clone(),
        profile: run.profile.clone(),
        progress: run.progress.clone(),
        stop: run.stop.clone(),
        threads: run.threads,
    }
}

struct Planner<'a> {
    run: &'a Run,
    limb: &'a Limb,
    rates: &'a Rates,
}

impl Planner<'_> {
    fn elastic(&self, stages: &ChainStages) -> Result<Vec<PlanStep>, HapdefError> {
        let mut steps = vec![self.compliance(&stages.compliance)?];
        steps.extend(left_out_loads(self.limb));
        steps.push(self.rig(&stages.rig)?);
        Ok(steps)
    }

    fn compliance(&self, stage: &Stage) -> Result<PlanStep, HapdefError> {
        let limb = self.limb;
        let (n_loads, n_wanted) = (limb.n_surface_nodes(), self.n_nodes());
        let why = "displacement at the skin and the virtual gauges per newton";
        if stage.cached {
            let n_fe_nodes = limb.mesh.nodes().len();
            let sizes = [("FE nodes", n_fe_nodes), ("wanted nodes", n_wanted)];
            return Ok(cached(PlanStep::runs("compliance", why, &sizes), stage));
        }
        let estimate = limb_estimate(self.run, limb)?;
        let sizes = [
            ("FE nodes", estimate.n_fe_nodes),
            ("equations", estimate.n_equations),
            ("non-zeros of L", estimate.nnz_l),
            ("right-hand sides", n_loads + limb.gauges.len()),
            ("wanted nodes", n_wanted),
        ];
        let work = Work::compliance(&estimate, n_loads, limb.gauges.len(), n_wanted);
        Ok(PlanStep::runs("compliance", why, &sizes).costing(work, self.rates))
    }

    fn rig(&self, stage: &Stage) -> Result<PlanStep, HapdefError> {
        let limb = self.limb;
        let why = "the simulated hardware's readings, which the transfer net learns from";
        let n_gauges = limb.gauges.len();
        if stage.cached {
            let step = PlanStep::runs("rig", why, &[("right-hand sides", n_gauges)]);
            return Ok(cached(step, stage));
        }
        let estimate = rig_estimate(self.run, limb)?;
        let sizes = [
            ("FE nodes", estimate.n_fe_nodes),
            ("equations", estimate.n_equations),
            ("non-zeros of L", estimate.nnz_l),
            ("right-hand sides", n_gauges),
        ];
        let work = Work::elastic(WorkKind::Rig, &estimate, n_gauges);
        Ok(PlanStep::runs("rig", why, &sizes).costing(work, self.rates))
    }

    fn datasets(&self, data: &Datasets) -> Vec<PlanStep> {
        let (profile, most) = (&self.run.profile, self.run.scene.contact.max_contacts);
        let too_many = format!("contact.max_contacts is {most}");
        let mut steps = Vec::new();
        for n_contacts in 1..=MOST_CONTACTS {
            let n = if n_contacts == 1 { profile.n_single } else { profile.n_multi };
            let name = set_name(n_contacts);
            steps.push(match data.simulated.get(n_contacts - 1) {
                Some(stage) => self.dataset(&name, n, n_contacts, stage),
                None => PlanStep::skipped(Skip::LargerSets, &name, &too_many, &[("samples", n)]),
            });
        }
        let singles = &data.rig_single;
        steps.push(self.dataset("rig's single presses", profile.n_real_single, 1, singles));
        let (name, n) = ("rig's double presses", profile.n_pairs * profile.n_amplitudes);
        steps.push(match &data.rig_double {
            Some(stage) => self.dataset(name, n, 2, stage),
            None => PlanStep::skipped(Skip::LargerSets, name, &too_many, &[("samples", n)]),
        });
        // The first that runs reads the table.
        if let Some(first) = steps.iter_mut().find(|step| step.state == StepState::Runs)
            && let Some(work) = first.work
        {
            let table = table_bytes(self.limb.n_surface_nodes(), self.n_nodes());
            *first = first.clone().costing(work.reading(table), self.rates);
        }
        steps
    }

    fn dataset(&self, name: &str, n: usize, n_contacts: usize, stage: &Stage) -> PlanStep {
        let n_nodes = self.n_nodes();
        let sizes = [
            ("samples", n),
            ("surface nodes", self.limb.n_surface_nodes()),
            ("virtual gauges", n_nodes - self.limb.n_surface_nodes()),
            ("gauges", self.limb.gauges.len()),
        ];
        let why = format!("samples of {n_contacts} at a time, superposed");
        self.run_or_cached(
            PlanStep::runs(name, why, &sizes),
            stage,
            Work::samples(n, n_contacts, n_nodes),
        )
    }

    fn nets(&self, stages: &ChainStages) -> Vec<PlanStep> {
        let trained = &stages.nets.nets;
        let mut steps: Vec<PlanStep> =
            trained.iter().map(|net| self.net(net.kind, &net.stage)).collect();
        let unions = (1..=MOST_CONTACTS).map(|n_sets| NetKind::Reconstruction { n_sets });
        for kind in unions.chain([NetKind::Direct]) {
            if trained.iter().any(|net| net.kind == kind) {
                continue;
            }
            let why = "no part of the chain: the scores of `hapdef eval` compare with it";
            let sizes = [("parameters", self.n_parameters(kind))];
            let name = kind.name();
            steps.push(PlanStep::skipped(Skip::OtherNets, &name, why, &sizes));
        }
        let why = "no contact needs the scores: `hapdef eval` makes them";
        steps.push(PlanStep::skipped(Skip::Scores, "eval", why, &[]));
        steps
    }

    fn net(&self, kind: NetKind, stage: &Stage) -> PlanStep {
        let (schedule, n_parameters) = (self.schedule(kind), self.n_parameters(kind));
        let sizes = [
            ("parameters", n_parameters),
            ("steps", schedule.steps),
            ("samples a step", schedule.batch),
        ];
        let n = schedule.steps * schedule.batch;
        let mut work = Work::training(kind.into(), &self.trained(kind), n);
        if let NetKind::Reconstruction { n_sets } = kind
            && self.run.profile.samples == Samples::Drawn
        {
            let modes = self.run.profile.output_modes.min(self.limb.n_surface_nodes());
            work = work.drawing(n, n_sets.div_ceil(2), self.n_nodes(), modes);
        }
        let why = "a net of the chain";
        self.run_or_cached(PlanStep::runs(&kind.name(), why, &sizes), stage, work)
    }

    /// A frame passes the three nets; F_S once for each contact.
    fn frame(&self) -> Vec<PlanStep> {
        let n_sets = self.run.scene.contact.max_contacts;
        let kinds = [NetKind::Transfer, NetKind::Reconstruction { n_sets }, NetKind::Sensitivity];
        let passes = kinds.map(|kind| {
            let n = self.n_parameters(kind);
            let why = format!("{} net, forward", kind.name());
            let name = format!("pass of {}", kind.name());
            PlanStep::runs(&name, why, &[("parameters", n)]).costing(Work::pass(n), self.rates)
        });
        let n_nodes = self.limb.n_surface_nodes();
        let sizes = [("surface nodes", n_nodes)];
        let rest = [
            PlanStep::runs("k-Max", "local maxima of the map", &sizes)
                .costing(Work::kmax(n_nodes), self.rates),
            PlanStep::skipped(
                Skip::OtherEstimator,
                "scan and pair search",
                "the estimator is hapdefx",
                &[],
            ),
        ];
        let steps = passes.into_iter().chain(rest);
        steps.map(PlanStep::each_frame).collect()
    }

    fn schedule(&self, kind: NetKind) -> Schedule {
        let profile = &self.run.profile;
        match kind {
            NetKind::Transfer => profile.transfer,
            NetKind::Reconstruction { .. } => profile.reconstruction,
            NetKind::Sensitivity => profile.sensitivity,
            NetKind::Direct => profile.direct,
        }
    }

    fn n_parameters(&self, kind: NetKind) -> usize {
        self.spec(kind, self.limb.n_surface_nodes()).n_parameters()
    }

    /// The net while it is trained: F_R's outputs are the map's modes, where fewer than nodes.
    fn trained(&self, kind: NetKind) -> MlpSpec {
        let (n_modes, n_surface) = (self.run.profile.output_modes, self.limb.n_surface_nodes());
        let n_outputs = if n_modes == 0 { n_surface } else { n_modes.min(n_surface) };
        self.spec(kind, n_outputs)
    }

    fn spec(&self, kind: NetKind, n_outputs: usize) -> MlpSpec {
        let n_gauges = self.limb.gauges.len();
        let n_virtual = self.n_nodes() - self.limb.n_surface_nodes();
        match kind {
            NetKind::Transfer => kind.spec(n_gauges, n_virtual),
            NetKind::Reconstruction { .. } => kind.spec(n_virtual, n_outputs),
            NetKind::Sensitivity | NetKind::Direct => kind.spec(n_gauges, 0),
        }
    }

    /// The step with its work, or answered by the cache.
    fn run_or_cached(&self, step: PlanStep, stage: &Stage, work: Work) -> PlanStep {
        if stage.cached { cached(step, stage) } else { step.costing(work, self.rates) }
    }

    /// Surface nodes and virtual gauges.
    fn n_nodes(&self) -> usize {
        self.limb.wanted_nodes().len()
    }
}

/// The paper's name of a simulated set.
fn set_name(n_contacts: usize) -> String {
    format!("set {}", ["I", "II", "III", "IV"][n_contacts - 1])
}

fn cached(step: PlanStep, stage: &Stage) -> PlanStep {
    PlanStep {
        state: StepState::Cached,
        why: format!("its inputs are unchanged: {}", stage.dir.display()),
        recorded_s: Some(stage.record.elapsed_s),
        ..step
    }
}
