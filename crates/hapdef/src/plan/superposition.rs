//! The steps of contacts by superposition.

use super::cost::{Cost, elastic};
use super::elastic::limb_estimate;
use super::{Machine, PlanStep};
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::scene::SuperpositionSpec;
use crate::touch::Calibration;

/// Gauges that one contact takes: two coordinates and a force.
const GAUGES_PER_CONTACT: usize = 3;

pub(super) fn steps(
    run: &Run,
    limb: &Limb,
    spec: &SuperpositionSpec,
    machine: &Machine,
) -> Result<Vec<PlanStep>, HapdefError> {
    let calibration = spec.calibration.as_ref();
    let read = |path| Calibration::read(&run.scene_dir.join(path), limb);
    let n_sites = calibration.map(read).transpose()?.map(|c| c.n_sites);
    let mut steps = response(run, limb, spec, machine)?;
    let superposed = "the estimator is superposition";
    let needless = [
        ("compliance", "surface-to-surface compliance is for maps"),
        ("rig", "no net learns from the rig"),
        ("datasets", "no net is trained"),
        ("nets", "readings are explained by the response itself"),
    ];
    for (name, why) in needless {
        steps.push(PlanStep::skipped(name, format!("{superposed}: {why}"), &[]));
    }
    let friction = "shear columns in the noise";
    steps.push(if spec.friction > 0.0 {
        let why = format!("estimator.friction is {}", spec.friction);
        PlanStep::runs(friction, why, &[("gauges", limb.gauges.len())])
    } else {
        PlanStep::skipped(friction, "normal forces only: estimator.friction is 0", &[])
    });
    let n_sites = n_sites.unwrap_or(spec.n_sites);
    steps.extend(frame(run, limb, n_sites).map(PlanStep::each_frame));
    Ok(steps)
}

/// Where the response comes from: a calibration, or one adjoint solve for each gauge.
fn response(
    run: &Run,
    limb: &Limb,
    spec: &SuperpositionSpec,
    machine: &Machine,
) -> Result<Vec<PlanStep>, HapdefError> {
    let sizes = [
        ("gauges", limb.gauges.len()),
        ("surface nodes", limb.n_surface_nodes()),
    ];
    if let Some(path) = &spec.calibration {
        let file = path.display();
        let read = format!("the response and its error are read from {file}");
        let left_out = format!("nothing is solved: {file} has the response");
        return Ok(vec![
            PlanStep::runs("calibration", read, &sizes),
            PlanStep::skipped("response", left_out, &sizes),
        ]);
    }
    let (estimate, order_s) = limb_estimate(run, limb)?;
    let n_loads = limb.gauges.len();
    let sizes = [
        ("FE nodes", estimate.n_fe_nodes),
        ("equations", estimate.n_equations),
        ("non-zeros of L", estimate.nnz_l),
        ("right-hand sides", n_loads),
        sizes[1],
    ];
    let why = "one factorisation and one adjoint solve for each gauge";
    let cost = elastic(&estimate, n_loads, order_s, machine);
    let every_node = estimate.n_fe_nodes - clamped_once(limb);
    Ok(vec![
        PlanStep::runs("response", why, &sizes).costing(cost),
        PlanStep::skipped(
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

/// What a frame runs. Operations: two for each gauge and site, some ten for each pair of sites.
fn frame(run: &Run, limb: &Limb, sites: usize) -> impl Iterator<Item = PlanStep> {
    let m = limb.gauges.len();
    let (wanted, carried) = (run.scene.contact.max_contacts, m / GAUGES_PER_CONTACT);
    let no_time = |flops: usize, bytes: usize| Cost {
        flops: flops as f64,
        bytes: bytes as f64,
        seconds: None,
    };
    let touched = PlanStep::runs("χ² test", "nothing touching ends a frame here", &[]);
    let scan = PlanStep::runs(
        "scan for one contact",
        "",
        &[("sites", sites), ("gauges", m)],
    );
    let n_pairs = sites * sites.saturating_sub(1) / 2;
    let sizes = [("pairs", n_pairs)];
    let pairs = if wanted.min(carried) < 2 {
        let why = if wanted < 2 {
            "contact.max_contacts is 1".to_owned()
        } else {
            format!("{m} gauges carry {carried} contact, three each")
        };
        PlanStep::skipped("pair search", why, &sizes)
    } else {
        let why = "only where one contact does not explain the frame";
        PlanStep::runs("pair search", why, &sizes).costing(no_time(10 * n_pairs, 4 * sites * sites))
    };
    let net_parts = PlanStep::skipped("nets and k-Max", "the estimator is superposition", &[]);
    [
        touched.costing(no_time(2 * m * m, 8 * m * m)),
        scan.costing(no_time(2 * m * sites, 4 * m * sites)),
        pairs,
        net_parts,
    ]
    .into_iter()
}
