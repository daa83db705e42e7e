//! The steps of contacts by superposition.

use hapdef_inverse::tip_ring_m;

use super::chain;
use super::elastic::limb_estimate;
use super::{PlanStep, Rates, Skip};
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::scene::{Outputs, SuperpositionSpec};
use crate::touch::Calibration;
use crate::work::{Work, WorkKind};

/// Names of steps that are measured.
pub(super) const RESPONSE: &str = "response";
pub(super) const TEST: &str = "χ² test";
pub(super) const SINGLE: &str = "scan for one contact";
pub(super) const PAIRS: &str = "pair search";
pub(super) const FOLLOWED: &str = "a contact followed";

/// Gauges that one contact takes: two coordinates and a force.
const GAUGES_PER_CONTACT: usize = 3;

pub(super) fn steps(
    run: &Run,
    limb: &Limb,
    spec: &SuperpositionSpec,
    rates: &Rates,
) -> Result<Vec<PlanStep>, HapdefError> {
    let calibration = spec.calibration.as_ref();
    let read = |path| Calibration::read(&run.scene_dir.join(path), limb);
    let n_sites = calibration.map(read).transpose()?.map(|c| c.n_sites);
    let mut steps = response(run, limb, spec, rates)?;
    let superposed = "the estimator is superposition";
    steps.push(compliance(run, limb, rates)?);
    let needless = [
        ("rig", "no net learns from the rig"),
        ("datasets", "no net is trained"),
        ("nets", "readings are explained by the response itself"),
    ];
    for (name, why) in needless {
        let why = format!("{superposed}: {why}");
        steps.push(PlanStep::skipped(Skip::OtherEstimator, name, why, &[]));
    }
    steps.push(unlike_presses(run, limb, spec));
    let frame = Frame {
        n_gauges: limb.gauges.len(),
        n_sites: n_sites.unwrap_or(spec.n_sites),
        max_contacts: run.scene.contact.max_contacts,
        rates,
    };
    steps.extend(frame.steps().map(PlanStep::each_frame));
    Ok(steps)
}

/// What the noise gets for contacts unlike the map's.
fn unlike_presses(run: &Run, limb: &Limb, spec: &SuperpositionSpec) -> PlanStep {
    let name = "friction and wider tips in the noise";
    let own_m = run.scene.contact.tip_radius_m;
    if spec.friction > 0.0 || tip_ring_m(spec.widest_tip_m, own_m) > 0.0 {
        let (friction, tip_m) = (spec.friction, spec.widest_tip_m);
        let why = format!("estimator.friction is {friction}, estimator.widest_tip_m {tip_m}");
        return PlanStep::runs(name, why, &[("gauges", limb.gauges.len())]);
    }
    let why = format!(
        "normal forces only, tips of {own_m} m: estimator.friction is 0, estimator.widest_tip_m no more"
    );
    PlanStep::skipped(Skip::Friction, name, why, &[])
}

/// What only a map of the skin needs; contacts don't.
fn compliance(run: &Run, limb: &Limb, rates: &Rates) -> Result<PlanStep, HapdefError> {
    let why = match run.scene.outputs {
        Some(Outputs::Map) => return chain::compliance_step(run, limb, rates),
        Some(Outputs::Contacts) => "outputs is contacts: no map of the skin",
        None => "contacts need no map of the skin; a live page has it solved beside the frames",
    };
    let sizes = [("right-hand sides", limb.n_surface_nodes())];
    Ok(PlanStep::skipped(Skip::UnwantedMap, "compliance", why, &sizes))
}

/// Where the response comes from: a calibration, or one adjoint solve for each gauge.
fn response(
    run: &Run,
    limb: &Limb,
    spec: &SuperpositionSpec,
    rates: &Rates,
) -> Result<Vec<PlanStep>, HapdefError> {
    let sizes = [("gauges", limb.gauges.len()), ("surface nodes", limb.n_surface_nodes())];
    if let Some(path) = &spec.calibration {
        let file = path.display();
        let read = format!("the response and its error are read from {file}");
        let why = format!("nothing is solved: {file} has the response");
        return Ok(vec![
            PlanStep::runs("calibration", read, &sizes),
            PlanStep::skipped(Skip::CalibratedResponse, RESPONSE, why, &sizes),
        ]);
    }
    let estimate = limb_estimate(run, limb)?;
    let n_loads = limb.gauges.len();
    let sizes = [
        ("FE nodes", estimate.n_fe_nodes),
        ("equations", estimate.n_equations),
        ("non-zeros of L", estimate.nnz_l),
        ("right-hand sides", n_loads),
        sizes[1],
    ];
    let why = "one factorisation and one adjoint solve for each gauge";
    let work = Work::elastic(WorkKind::Response, &estimate, n_loads);
    let work = work.with_tips(limb.n_surface_nodes());
    let every_node = estimate.n_fe_nodes - clamped_once(limb);
    Ok(vec![
        PlanStep::runs(RESPONSE, why, &sizes).costing(work, rates),
        PlanStep::skipped(
            Skip::LoadsAtEveryNode,
            "a load at every node",
            "adjoint: a right-hand side for each gauge, none for clamped nodes, nodes outside \
             contact.region or directions",
            &[("right-hand sides", 3 * every_node)],
        ),
    ])
}

fn clamped_once(limb: &Limb) -> usize {
    let clamped: std::collections::BTreeSet<_> = limb.clamped.iter().collect();
    clamped.len()
}

/// What a frame runs.
struct Frame<'a> {
    n_gauges: usize,
    n_sites: usize,
    max_contacts: usize,
    rates: &'a Rates,
}

impl Frame<'_> {
    /// A frame on its own is tested and searched; in a stream contacts are followed instead.
    fn steps(&self) -> [PlanStep; 6] {
        let (m, n_sites) = (self.n_gauges, self.n_sites);
        let sizes = [("sites", n_sites), ("gauges", m)];
        [
            PlanStep::runs(TEST, "does anything touch", &sizes[1..])
                .costing(Work::test(m), self.rates),
            PlanStep::skipped(
                Skip::UntouchedFrames,
                "search while nothing touches",
                "the χ² test ends a frame that nothing touches",
                &sizes,
            ),
            self.single(),
            self.pairs(),
            PlanStep::runs(FOLLOWED, "in a stream, in place of a search", &sizes[1..])
                .costing(Work::followed(m), self.rates),
            PlanStep::skipped(
                Skip::OtherEstimator,
                "nets and k-Max",
                "the estimator is superposition",
                &[],
            ),
        ]
    }

    fn single(&self) -> PlanStep {
        let (m, n_sites) = (self.n_gauges, self.n_sites);
        let sizes = [("sites", n_sites), ("gauges", m)];
        let why = "and the refinement of the best";
        PlanStep::runs(SINGLE, why, &sizes).costing(Work::single(m, n_sites), self.rates)
    }

    fn pairs(&self) -> PlanStep {
        let (m, n_sites) = (self.n_gauges, self.n_sites);
        let sizes = [("pairs", n_sites * n_sites.saturating_sub(1) / 2)];
        if self.max_contacts < 2 {
            let why = "contact.max_contacts is 1";
            return PlanStep::skipped(Skip::UnwantedPairs, PAIRS, why, &sizes);
        }
        let carried = m / GAUGES_PER_CONTACT;
        if carried < 2 {
            let why = format!("{m} gauges carry {carried} contact, three each");
            return PlanStep::skipped(Skip::UncarriedPairs, PAIRS, why, &sizes);
        }
        let why = "where one contact does not explain the frame; the search for one included";
        PlanStep::runs(PAIRS, why, &sizes).costing(Work::pair(m, n_sites), self.rates)
    }
}
