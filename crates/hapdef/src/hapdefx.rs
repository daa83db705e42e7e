//! The paper's chain on a limb's surface.

use hapdef_kmax::{KMaxGraph, KMaxParams};
use hapdef_live::estimator::{ChainNets, Hapdefx};

use crate::error::HapdefError;
use crate::scene::HapdefxSpec;

/// Puts the trained nets around k-Max on the limb's surface points `[n_surface]`.
///
/// # Errors
/// [`HapdefError::KMax`] when the neighbourhoods can't be built; [`HapdefError::Live`] when the nets
/// don't fit the points.
pub fn hapdefx(
    nets: ChainNets,
    points_m: Vec<[f64; 3]>,
    spec: &HapdefxSpec,
) -> Result<Hapdefx, HapdefError> {
    let params = KMaxParams::spanning_radius(&points_m, spec.kmax_radius_m)?;
    let graph = KMaxGraph::new(&points_m, params)?;
    Ok(Hapdefx::new(nets, graph, points_m, spec.floor_um as f32)?)
}
