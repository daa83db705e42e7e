//! How much a gauge's reading changes when it is glued a little off its place.

use hapdef_mesh::farthest_nodes;
use hapdef_sim::{GaugeStrain, LinearFunctional, Motion, NodalLoad, PressedSkin};
use rayon::prelude::*;

use super::model::LimbModel;
use crate::error::HapdefError;

/// Presses all over the skin by which readings are compared.
const N_PRESSES: usize = 48;

/// A gauge at its place, and beside it.
pub(super) struct GluedOff {
    pub(super) gauge: GaugeStrain,
    /// The same as the limb's model has it.
    pub(super) in_model: LinearFunctional,
    /// The same moved to every side, and turned.
    pub(super) off: Vec<LinearFunctional>,
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
    model: &LimbModel<'_>,
    gauges: &[GluedOff],
    tip_radius_m: f64,
) -> Result<Vec<f64>, HapdefError> {
    let motions = pressed(model, tip_radius_m)?;
    let readings = |gauge: &LinearFunctional| -> Vec<f64> {
        let reading = |m: &Motion| gauge.reading(&m.displacement, &m.rotation);
        motions.iter().map(reading).collect()
    };
    let change = |glued: &GluedOff| {
        let own = readings(&glued.in_model);
        let off =
            glued.off.iter().map(|off| norm(own.iter().zip(readings(off)).map(|(a, b)| a - b)));
        off.fold(0.0, f64::max) / norm(own.iter().copied()).max(f64::MIN_POSITIVE)
    };
    Ok(gauges.par_iter().map(change).collect())
}

/// How the model moves under each press `[n_presses]`.
fn pressed(model: &LimbModel<'_>, tip_radius_m: f64) -> Result<Vec<Motion>, HapdefError> {
    let limb = model.limb;
    let skin = PressedSkin::new(&limb.mesh, &limb.skin)?;
    let load = |node| {
        let place = limb.skin.nodes.partition_point(|other| *other < node);
        skin.load(&limb.mesh.position(node), tip_radius_m, &limb.directions[place])
    };
    let nodes = farthest_nodes(&limb.mesh, &limb.skin.nodes, N_PRESSES);
    let loads: Vec<NodalLoad> = nodes.into_iter().map(load).collect::<Result<_, _>>()?;
    Ok(model.motions(&loads)?)
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|v| v * v).sum::<f64>().sqrt()
}
