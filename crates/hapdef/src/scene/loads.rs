//! Scene section about loads on the whole limb that are no contacts.

use std::path::PathBuf;

use hapdef_sim::LimbLoad;
use serde::{Deserialize, Serialize};

use super::Mount;
use super::rig::is_zero;

/// Loads on the whole limb that are no contacts, each by the standard deviation of what is not known of it since the
/// tare: all of it, or what is left where it is measured and taken off. What is 0 or left out isn't there.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct LoadsSpec {
    /// A file that `hapdef loads` learned from untouched frames, relative to the scene: with it, contacts are found
    /// beside what it says; what follows is what acts on the simulated rig.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learned: Option<PathBuf>,
    /// What the next joint passes on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flange: Option<FlangeSpec>,
    /// Weight and inertia: gravity less the acceleration of the limb's origin, along each axis, m/s².
    #[serde(skip_serializing_if = "is_zero")]
    pub specific_force_sd_m_s2: f64,
    /// Angular acceleration about each axis, rad/s².
    #[serde(skip_serializing_if = "is_zero")]
    pub angular_acceleration_sd_rad_s2: f64,
    /// Angular rate about each axis, rad/s: what is centrifugal.
    #[serde(skip_serializing_if = "is_zero")]
    pub angular_rate_sd_rad_s: f64,
    /// Temperature of the whole limb, K.
    #[serde(skip_serializing_if = "is_zero")]
    pub temperature_sd_k: f64,
    /// Thermal expansion of the limb less that of its gauges, 1/K.
    pub expansion_per_k: f64,
}

/// The face that the next joint is fixed to, and what it passes on.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FlangeSpec {
    /// Which nodes, as of a mount.
    pub at: Mount,
    /// Force along each axis, N.
    pub force_sd_n: f64,
    /// Moment about each axis at the middle of the nodes, N m.
    pub moment_sd_nm: f64,
}

impl Default for LoadsSpec {
    /// None; PA2200 expands by 1.09e-4 per kelvin (EOS, PA 2200 material data sheet), a gauge for steel by
    /// 1.1e-5.
    fn default() -> Self {
        Self {
            learned: None,
            flange: None,
            specific_force_sd_m_s2: 0.0,
            angular_acceleration_sd_rad_s2: 0.0,
            angular_rate_sd_rad_s: 0.0,
            temperature_sd_k: 0.0,
            expansion_per_k: 9.8e-5,
        }
    }
}

impl LoadsSpec {
    /// The loads there are, and the standard deviation of each in its unit.
    #[must_use]
    pub fn loads(&self) -> Vec<(LimbLoad, f64)> {
        let sd = |load: LimbLoad| match load {
            LimbLoad::FlangeForce(_) => self.flange.as_ref().map_or(0.0, |f| f.force_sd_n),
            LimbLoad::FlangeMoment(_) => self.flange.as_ref().map_or(0.0, |f| f.moment_sd_nm),
            LimbLoad::SpecificForce(_) => self.specific_force_sd_m_s2,
            LimbLoad::AngularAcceleration(_) => self.angular_acceleration_sd_rad_s2,
            LimbLoad::AngularRates(i, j) => of_product(self.angular_rate_sd_rad_s, i == j),
            LimbLoad::Temperature => self.temperature_sd_k,
        };
        let all = LimbLoad::all().into_iter().map(|load| (load, sd(load)));
        all.filter(|(_, sd)| *sd > 0.0).collect()
    }
}

/// Root mean square of the product of two rates of standard deviation `sd`: E ωᵢ²ωⱼ² = σ⁴, E ωᵢ⁴ = 3 σ⁴.
fn of_product(sd: f64, is_square: bool) -> f64 {
    if is_square { 3.0_f64.sqrt() * sd * sd } else { sd * sd }
}
