//! The limb before it is perturbed.

use hapdef_mesh::{FeNodeId, SkinRegion, Tet10Mesh};
use hapdef_sim::{GaugeParams, GaugeSite, IsotropicMaterial};

/// The limb as it is drawn, before anything is perturbed.
pub struct NominalLimb<'a> {
    /// The training side's mesh, or another one of the same limb.
    pub mesh: &'a Tet10Mesh,
    /// Nodes held fast.
    pub clamped: &'a [FeNodeId],
    /// Nominal material.
    pub material: IsotropicMaterial,
    /// Nominal gauge sites.
    pub gauges: &'a [GaugeSite],
    /// How much of a gauge may miss the wall.
    pub gauge_params: GaugeParams,
    /// The touchable skin.
    pub skin: &'a SkinRegion,
    /// Radius of the probing tip, m.
    pub tip_radius_m: f64,
}
