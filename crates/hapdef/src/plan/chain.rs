//! The steps of the paper's chain.

use hapdef_nets::MlpSpec;

use super::cost::{Cost, elastic, projected, superposed, training};
use super::elastic::{left_out_loads, limb_estimate, rig_estimate};
use super::{Machine, PlanStep, Skip, StepState};
use crate::cache::Stage;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::pipeline::{Pipeline, Until};
use crate::profile::{Samples, Schedule};
use crate::run::Run;
use crate::stages::{self, Datasets, NetKind};
use crate::touch::{ChainStages, chain_stages};

/// Most contacts of a sample: the paper's sets I to IV.
const MOST_CONTACTS: usize = 4;

pub(super) fn steps(
    run: &Run,
    limb: &Limb,
    machine: &Machine,
) -> Result<Vec<PlanStep>, HapdefError> {
    let stages = chain_stages(&looking(run), limb)?;
    let planner = Planner { run, limb, machine };
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
    machine: &Machine,
) -> Result<PlanStep, HapdefError> {
    let stage = stages::compliance(&looking(run), limb)?;
    Planner { run, limb, machine }.compliance(&stage)
}

/// Expected time of what a pipeline up to its nets has to run, s: compliance, rig, datasets, nets.
pub(super) fn parts_s(run: &Run, limb: &Limb, machine: &Machine) -> Result<[f64; 4], HapdefError> {
    let stages = Pipeline::run(&looking(run), limb, Until::Train)?;
    let planner = Planner { run, limb, machine };
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
    machine: &'a Machine,
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
        let (estimate, order_s) = limb_estimate(self.run, limb)?;
        let sizes = [
            ("FE nodes", estimate.n_fe_nodes),
            ("equations", estimate.n_equations),
            ("non-zeros of L", estimate.nnz_l),
            ("right-hand sides", n_loads + limb.gauges.len()),
            ("wanted nodes", n_wanted),
        ];
        let cost = elastic(&estimate, n_loads + limb.gauges.len(), order_s, self.machine);
        // It is made in f64, twice the bytes, before it is written.
        let cost = cost.writing(3.0 * self.table_bytes(), self.machine);
        Ok(PlanStep::runs("compliance", why, &sizes).costing(cost))
    }

    fn rig(&self, stage: &Stage) -> Result<PlanStep, HapdefError> {
        let limb = self.limb;
        let why = "the simulated hardware's readings, which the transfer net learns from";
        let n_gauges = limb.gauges.len();
        if stage.cached {
            let step = PlanStep::runs("rig", why, &[("right-hand sides", n_gauges)]);
            return Ok(cached(step, stage));
        }
        let (estimate, prepare_s) = rig_estimate(self.run, limb)?;
        let sizes = [
            ("FE nodes", estimate.n_fe_nodes),
            ("equations", estimate.n_equations),
            ("non-zeros of L", estimate.nnz_l),
            ("right-hand sides", n_gauges),
        ];
        let cost = elastic(&estimate, n_gauges, prepare_s, self.machine);
        Ok(PlanStep::runs("rig", why, &sizes).costing(cost))
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
        if let Some(first) = steps.iter_mut().find(|step| step.state == StepState::Runs) {
            let read_s = self.table_bytes() / self.machine.read_bytes_per_s;
            first.predicted_s = first.predicted_s.map(|seconds| seconds + read_s);
        }
        steps
    }

    /// Bytes of the compliance of the skin and the virtual gauges.
    fn table_bytes(&self) -> f64 {
        12.0 * (self.limb.n_surface_nodes() * self.n_nodes()) as f64
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
        let cost = superposed(n, n_contacts, n_nodes, self.machine)
            .writing(4.0 * (n * n_nodes) as f64, self.machine);
        from_stage(PlanStep::runs(name, why, &sizes), stage, cost)
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
        let mut cost = training(&self.trained(kind), &schedule, self.machine);
        if let NetKind::Reconstruction { n_sets } = kind
            && self.run.profile.samples == Samples::Drawn
        {
            let n = schedule.steps * schedule.batch;
            let drawn = superposed(n, n_sets.div_ceil(2), self.n_nodes(), self.machine);
            let modes = self.run.profile.output_modes.min(self.limb.n_surface_nodes());
            let projected = projected(n, self.limb.n_surface_nodes(), modes, self.machine);
            cost = cost.plus(drawn).plus(projected);
        }
        let why = "a net of the chain";
        from_stage(PlanStep::runs(&kind.name(), why, &sizes), stage, cost)
    }

    /// A frame passes the three nets; F_S once for each contact.
    fn frame(&self) -> Vec<PlanStep> {
        let n_sets = self.run.scene.contact.max_contacts;
        let kinds = [NetKind::Transfer, NetKind::Reconstruction { n_sets }, NetKind::Sensitivity];
        let passes = kinds.map(|kind| {
            let n = self.n_parameters(kind);
            let why = format!("{} net, forward", kind.name());
            let flops = 2.0 * n as f64;
            let cost = Cost {
                flops,
                bytes: 4.0 * n as f64,
                seconds: Some(flops / self.machine.pass_flops_per_s),
            };
            let name = format!("pass of {}", kind.name());
            PlanStep::runs(&name, why, &[("parameters", n)]).costing(cost)
        });
        let n_nodes = self.limb.n_surface_nodes();
        let sizes = [("surface nodes", n_nodes)];
        let searched = Cost {
            flops: 0.0,
            bytes: 4.0 * n_nodes as f64,
            seconds: Some(n_nodes as f64 / self.machine.kmax_nodes_per_s),
        };
        let rest = [
            PlanStep::runs("k-Max", "local maxima of the map", &sizes).costing(searched),
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

    /// Surface nodes and virtual gauges.
    fn n_nodes(&self) -> usize {
        self.limb.wanted_nodes().len()
    }
}

/// The paper's name of a simulated set.
fn set_name(n_contacts: usize) -> String {
    format!("set {}", ["I", "II", "III", "IV"][n_contacts - 1])
}

/// The step with its cost, or answered by the cache.
fn from_stage(step: PlanStep, stage: &Stage, cost: Cost) -> PlanStep {
    if stage.cached { cached(step, stage) } else { step.costing(cost) }
}

fn cached(step: PlanStep, stage: &Stage) -> PlanStep {
    PlanStep {
        state: StepState::Cached,
        why: format!("its inputs are unchanged: {}", stage.dir.display()),
        recorded_s: Some(stage.record.elapsed_s),
        ..step
    }
}
