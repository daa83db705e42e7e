//! Scenes at random, each with a press or two.

use proptest::prelude::*;
use serde::{Deserialize, Serialize};

/// A scene and what presses it.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Trial {
    /// Thickness of the wall, m.
    pub(crate) wall_m: f64,
    pub(crate) n_sectors: usize,
    pub(crate) n_rib_layers: usize,
    /// Young's modulus, log10 of Pa.
    pub(crate) log10_e_pa: f64,
    /// Poisson's ratio.
    pub(crate) nu: f64,
    /// So many of the scene's gauges, from one of them on.
    pub(crate) n_gauges: usize,
    pub(crate) first_gauge: usize,
    /// Standard deviation of a reading's noise, log10 of µε.
    pub(crate) log10_noise_ue: f64,
    /// Relative error of the response map, as assumed; on these meshes it is off from
    /// the forward solve by less than the least that is drawn.
    pub(crate) map_error: f64,
    /// Force of the first press, log10 of N.
    pub(crate) log10_force_n: f64,
    pub(crate) place: Place,
    pub(crate) second: Option<Second>,
    /// Seed of the noise.
    pub(crate) seed: u64,
}

/// A second press.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Second {
    /// Its force over that of the first, log10.
    pub(crate) log10_share: f64,
    pub(crate) place: Place,
}

/// A place on the skin, whatever its mesh.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Place {
    /// Which face, as a share of them all in [0, 1).
    pub(crate) face: f64,
    /// Where on the face, two numbers in [0, 1) that are uniform over its area.
    pub(crate) within: [f64; 2],
}

impl Place {
    /// Barycentric coordinates on the face (Osada et al., ACM Trans. Graph. 21, 2002, section 4.2).
    pub(crate) fn bary(&self) -> [f64; 3] {
        let (root, v) = (self.within[0].sqrt(), self.within[1]);
        [1.0 - root, root * (1.0 - v), root * v]
    }
}

/// Every number far beyond what anybody builds.
pub(crate) fn trials() -> impl Strategy<Value = Trial> {
    let limb = (5e-4..1.9e-3_f64, 5..9_usize, 1..4_usize);
    let material = (5.0..12.0_f64, 0.0..0.49_f64);
    let gauges = (2..=10_usize, 0..10_usize);
    let noise = (-3.0..3.0_f64, 0.03..0.1_f64);
    let second = (-2.0..0.0_f64, places());
    let second = second.prop_map(|(log10_share, place)| Second { log10_share, place });
    let presses = (-3.0..4.0_f64, places(), prop::option::of(second), any::<u64>());
    (limb, material, gauges, noise, presses).prop_map(|(limb, material, gauges, noise, presses)| {
        let (wall_m, n_sectors, n_rib_layers) = limb;
        let (log10_e_pa, nu) = material;
        let (n_gauges, first_gauge) = gauges;
        let (log10_noise_ue, map_error) = noise;
        let (log10_force_n, place, second, seed) = presses;
        Trial {
            wall_m,
            n_sectors,
            n_rib_layers,
            log10_e_pa,
            nu,
            n_gauges,
            first_gauge,
            log10_noise_ue,
            map_error,
            log10_force_n,
            place,
            second,
            seed,
        }
    })
}

fn places() -> impl Strategy<Value = Place> {
    let within = [0.0..1.0_f64, 0.0..1.0_f64];
    (0.0..1.0_f64, within).prop_map(|(face, within)| Place { face, within })
}
