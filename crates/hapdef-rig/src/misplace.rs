//! Gauges glued a little off their nominal place.

use hapdef_mesh::{Tet10Mesh, Tri6Face};
use hapdef_sim::{GaugeSite, GaugeStrain};
use nalgebra::{Rotation3, Unit};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::error::RigError;
use crate::nominal_limb::NominalLimb;
use crate::params::MisplacementParams;

/// Directions tried before a gauge is refused.
const N_DIRECTIONS: usize = 64;

/// Shifts and turns every gauge on the real limb's `mesh`; a direction in which it would leave its
/// wall is drawn again. Where the real wall's edge has moved over a gauge's nominal place, its
/// directions are those of the nominal wall.
pub(crate) fn misplaced_gauges(
    mesh: &Tet10Mesh,
    limb: &NominalLimb<'_>,
    params: &MisplacementParams,
) -> Result<Vec<GaugeStrain>, RigError> {
    let mut rng = ChaCha8Rng::seed_from_u64(params.seed);
    let boundary = mesh.boundary();
    let on = |mesh: &Tet10Mesh, faces: &[Tri6Face], site: &GaugeSite| {
        GaugeStrain::with_params(mesh, faces, site, &limb.gauge_params)
    };
    let place = |site: &GaugeSite| on(mesh, &boundary.faces, site);
    limb.gauges
        .iter()
        .enumerate()
        .map(|(gauge, site)| {
            let nominal =
                place(site).or_else(|_| on(limb.mesh, &limb.mesh.boundary().faces, site))?;
            (0..N_DIRECTIONS)
                .map(|_| misplaced(site, &nominal, params, &mut rng))
                .find_map(|moved| place(&moved).ok())
                .ok_or(RigError::NoRoomForGauge {
                    gauge,
                    shift_mm: params.shift_m * 1e3,
                    tried: N_DIRECTIONS,
                })
        })
        .collect()
}

fn misplaced(
    site: &GaugeSite,
    nominal: &GaugeStrain,
    params: &MisplacementParams,
    rng: &mut ChaCha8Rng,
) -> GaugeSite {
    let direction = rng.random_range(0.0..std::f64::consts::TAU);
    let turn = if rng.random_bool(0.5) { params.turn_rad } else { -params.turn_rad };
    let normal = Unit::new_normalize(nominal.normal());
    let shift = Rotation3::from_axis_angle(&normal, direction) * nominal.axis() * params.shift_m;
    GaugeSite {
        position: site.position + shift,
        axis: Rotation3::from_axis_angle(&normal, turn) * site.axis,
        ..*site
    }
}
