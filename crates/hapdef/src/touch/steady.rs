//! How much a gauge's reading changes when it is glued a little off its place.

use hapdef_mesh::farthest_nodes;
use hapdef_sim::{ComplianceParams, ElasticModel, GaugeStrain, NodalLoad, PressedSkin};
use nalgebra::Vector3;
use rayon::prelude::*;

use crate::error::HapdefError;
use crate::limb::Limb;

/// Presses all over the skin by which readings are compared.
const N_PRESSES: usize = 48;

/// A gauge at its place, and beside it.
pub(super) struct GluedOff {
    pub(super) gauge: GaugeStrain,
    /// The same moved to every side, and turned.
    pub(super) off: Vec<GaugeStrain>,
}

/// The largest change of each gauge's readings under presses all over the skin, relative to the readings
/// themselves, root mean squares both `[n_gauges]`.
///
/// A gauge whose axis is nearly that of no strain, or that sits where the wall turns, reads next to nothing,
/// and when it is glued off by a millimetre something else, of another sign even: a computed response says
/// nothing of it.
///
/// # Errors
/// [`HapdefError::Sim`].
pub(super) fn changes(
    limb: &Limb,
    model: &ElasticModel,
    gauges: &[GluedOff],
    tip_radius_m: f64,
) -> Result<Vec<f64>, HapdefError> {
    let fields = pressed(limb, model, tip_radius_m)?;
    let readings = |gauge: &GaugeStrain| -> Vec<f64> {
        fields.iter().map(|field| gauge.strain(field)).collect()
    };
    let change = |glued: &GluedOff| {
        let own = readings(&glued.gauge);
        let off =
            glued.off.iter().map(|off| norm(own.iter().zip(readings(off)).map(|(a, b)| a - b)));
        off.fold(0.0, f64::max) / norm(own.iter().copied()).max(f64::MIN_POSITIVE)
    };
    Ok(gauges.par_iter().map(change).collect())
}

/// Displacements under each press `[n_presses][n_fe_nodes]`, m.
fn pressed(
    limb: &Limb,
    model: &ElasticModel,
    tip_radius_m: f64,
) -> Result<Vec<Vec<Vector3<f64>>>, HapdefError> {
    let skin = PressedSkin::new(&limb.mesh, &limb.skin)?;
    let load = |node| {
        let place = limb.skin.nodes.partition_point(|other| *other < node);
        skin.load(&limb.mesh.position(node), tip_radius_m, &limb.directions[place])
    };
    let nodes = farthest_nodes(&limb.mesh, &limb.skin.nodes, N_PRESSES);
    let loads: Vec<NodalLoad> = nodes.into_iter().map(load).collect::<Result<_, _>>()?;
    let all: Vec<_> = (0..limb.mesh.nodes().len()).map(hapdef_mesh::FeNodeId::from_index).collect();
    let (compliance, _) = model.compliance(&loads, &all, &ComplianceParams::default())?;
    let field = |load: usize| compliance.row(load).chunks_exact(3).map(Vector3::from_column_slice);
    Ok((0..loads.len()).map(|load| field(load).collect()).collect())
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|v| v * v).sum::<f64>().sqrt()
}
