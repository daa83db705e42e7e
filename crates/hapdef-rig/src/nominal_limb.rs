//! The limb before it is perturbed.

use hapdef_mesh::{FeNodeId, SkinRegion, Tet10Mesh};
use hapdef_sim::{GaugeParams, GaugeSite, IsotropicMaterial, LimbLoad};
use nalgebra::Point3;

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
    /// Loads on the whole limb that it answers to, too.
    pub loads: NominalLoads<'a>,
}

/// Loads on the whole limb that are no contacts.
#[derive(Clone, Copy, Debug, Default)]
pub struct NominalLoads<'a> {
    /// Which ones.
    pub loads: &'a [LimbLoad],
    /// Nodes that the next joint is fixed to.
    pub flange: &'a [FeNodeId],
    /// Where forces on them act, m.
    pub flange_point_m: Point3<f64>,
    /// Thermal expansion, 1/K.
    pub expansion_per_k: f64,
}
