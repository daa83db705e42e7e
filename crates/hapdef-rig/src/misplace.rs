//! Gauges glued a little off their nominal place.

use hapdef_mesh::{Tet10Mesh, Tri6Face};
use hapdef_sim::{GaugeParams, GaugeSite, GaugeStrain};
use nalgebra::{Rotation3, Unit};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::error::RigError;
use crate::params::MisplacementParams;

/// Directions tried before a gauge is refused.
const N_DIRECTIONS: usize = 64;

/// Shifts and turns every gauge; a direction in which it would leave its wall is drawn again.
pub(crate) fn misplaced_gauges(
    mesh: &Tet10Mesh,
    wall_faces: &[Tri6Face],
    nominal: &[GaugeSite],
    gauge_params: &GaugeParams,
    params: &MisplacementParams,
) -> Result<Vec<GaugeStrain>, RigError> {
    let mut rng = ChaCha8Rng::seed_from_u64(params.seed);
    let place = |site: &GaugeSite| GaugeStrain::with_params(mesh, wall_faces, site, gauge_params);
    nominal
        .iter()
        .enumerate()
        .map(|(gauge, site)| {
            let nominal = place(site)?;
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
    let turn = if rng.random_bool(0.5) {
        params.turn_rad
    } else {
        -params.turn_rad
    };
    let normal = Unit::new_normalize(nominal.normal());
    let shift = Rotation3::from_axis_angle(&normal, direction) * nominal.axis() * params.shift_m;
    GaugeSite {
        position: site.position + shift,
        axis: Rotation3::from_axis_angle(&normal, turn) * site.axis,
        ..*site
    }
}
