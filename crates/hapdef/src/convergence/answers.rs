//! What a model's gauges and the places under a tip answer to presses.

use hapdef_mesh::{FeNodeId, GaugeId};
use hapdef_sim::{ComplianceParams, ElasticModel, LinearFunctional, NodalLoad, SimError};

/// Presses solved together: of a fine solid their displacements are kept at all loaded nodes.
const PRESSES_AT_A_TIME: usize = 60;

/// The answers to a newton at each place.
pub(crate) struct Answers {
    /// Gauge strains `[n_presses][n_gauges]`, µε/N.
    pub(crate) reading_ue_per_n: Vec<Vec<f64>>,
    /// Displacement under the tip along the force `[n_tips]`, µm/N.
    pub(crate) tip_um_per_n: Vec<f64>,
    /// Seconds to solve for the gauges.
    pub(crate) adjoint_s: f64,
}

impl Answers {
    /// The answers of `gauges` to all `loads`, and the displacement under the first `n_tips` of them.
    ///
    /// # Errors
    /// [`SimError`].
    pub(crate) fn of<G: AsRef<LinearFunctional>>(
        model: &ElasticModel,
        gauges: &[G],
        loads: &[NodalLoad],
        n_tips: usize,
    ) -> Result<Self, SimError> {
        let (response, adjoint) = model.response(gauges)?;
        let reading = |load: &NodalLoad| {
            let of = |gauge| response.reading(GaugeId::from_index(gauge), load) * 1e6;
            (0..gauges.len()).map(of).collect()
        };
        let mut tip_um_per_n = Vec::new();
        for together in loads[..loads.len().min(n_tips)].chunks(PRESSES_AT_A_TIME) {
            tip_um_per_n.extend(under_tips(model, together)?);
        }
        Ok(Self {
            reading_ue_per_n: loads.iter().map(reading).collect(),
            tip_um_per_n,
            adjoint_s: adjoint.elapsed_s,
        })
    }
}

/// The displacement under each load along its force, µm/N.
fn under_tips(model: &ElasticModel, loads: &[NodalLoad]) -> Result<Vec<f64>, SimError> {
    let loaded = loads.iter().flat_map(|load| &load.forces_n);
    let mut wanted: Vec<FeNodeId> = loaded.map(|(node, _)| *node).collect();
    wanted.sort_unstable();
    wanted.dedup();
    let (moved, _) = model.compliance(loads, &wanted, &ComplianceParams::default())?;
    let work = |(i, load): (usize, &NodalLoad)| {
        let shares = load.forces_n.iter().map(|(node, force)| {
            let place = wanted.partition_point(|other| other < node);
            force.dot(&moved.displacement(i, place))
        });
        shares.sum::<f64>() * 1e6
    };
    Ok(loads.iter().enumerate().map(work).collect())
}
