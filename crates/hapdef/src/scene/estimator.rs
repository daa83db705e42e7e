//! Scene section about how contacts are found.

use std::path::PathBuf;

use hapdef_live::estimator::EstimatorKind;
use serde::{Deserialize, Serialize};

/// Which estimator turns readings into contacts, with its settings.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum EstimatorSpec {
    /// The paper's chain: transfer net, reconstruction net, k-Max, sensitivity net.
    Hapdefx(HapdefxSpec),
    /// Readings add up: the contacts whose responses explain them.
    Superposition(SuperpositionSpec),
}

/// Parameters of the paper's chain.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct HapdefxSpec {
    /// Radius that the k nearest neighbours of k-Max span, m; the paper has about 10 mm.
    pub kmax_radius_m: f64,
    /// Displacement below which a point is no candidate, µm.
    pub floor_um: f64,
}

/// Parameters of superposition.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct SuperpositionSpec {
    /// Standard deviation of a reading's noise, µε.
    pub noise_ue: f64,
    /// Relative error of the response map: a tenth for a limb that was only computed, a hundredth
    /// after a calibration with thousands of presses.
    pub map_error: f64,
    /// Refinements of the limb's mesh for the map that `hapdef calibrate` corrects; each cuts an
    /// element into eight.
    #[serde(skip_serializing_if = "is_default")]
    pub map_refinements: u32,
    /// Largest friction coefficient of what touches.
    pub friction: f64,
    /// Radius of the widest tip that touches, m; none wider than `contact.tip_radius_m` if that is more.
    #[serde(skip_serializing_if = "is_default")]
    pub widest_tip_m: f64,
    /// Radius of the widest contact that is looked for where narrow ones leave a doubt, such as a palm's 0.02, m;
    /// none wider than `contact.tip_radius_m` if that is more. In single frames: contacts that are followed are
    /// narrow.
    #[serde(skip_serializing_if = "is_default")]
    pub palm_radius_m: f64,
    /// What `hapdef calibrate` wrote, relative to the scene file: the map and its error come from
    /// there, and nothing is solved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub calibration: Option<PathBuf>,
    /// Sites of the scan.
    pub n_sites: usize,
}

impl Default for HapdefxSpec {
    /// The paper's 10 mm, and 5 µm.
    fn default() -> Self {
        Self { kmax_radius_m: 0.01, floor_um: 5.0 }
    }
}

impl Default for SuperpositionSpec {
    /// A microstrain of noise, a map off by a tenth, no friction, no wider tips.
    fn default() -> Self {
        Self {
            noise_ue: 1.0,
            map_error: 0.1,
            map_refinements: 0,
            friction: 0.0,
            widest_tip_m: 0.0,
            palm_radius_m: 0.0,
            calibration: None,
            n_sites: 800,
        }
    }
}

impl Default for EstimatorSpec {
    fn default() -> Self {
        Self::Superposition(SuperpositionSpec::default())
    }
}

impl EstimatorSpec {
    /// What it chooses for a frame on its own.
    #[must_use]
    pub fn kind(&self) -> EstimatorKind {
        match self {
            Self::Hapdefx(_) => EstimatorKind::Hapdefx,
            Self::Superposition(_) => EstimatorKind::Superposition,
        }
    }

    /// Refinements of the mesh for the map behind a calibration; none where the scene chooses
    /// another estimator.
    #[must_use]
    pub fn map_refinements(&self) -> u32 {
        match self {
            Self::Superposition(spec) => spec.map_refinements,
            Self::Hapdefx(_) => 0,
        }
    }

    /// The parameters of the paper's chain; the defaults where the scene chooses another estimator.
    #[must_use]
    pub fn hapdefx(&self) -> HapdefxSpec {
        match self {
            Self::Hapdefx(spec) => *spec,
            Self::Superposition(_) => HapdefxSpec::default(),
        }
    }

    /// The parameters of superposition; the defaults where the scene chooses another estimator.
    #[must_use]
    pub fn superposition(&self) -> SuperpositionSpec {
        match self {
            Self::Superposition(spec) => spec.clone(),
            Self::Hapdefx(_) => SuperpositionSpec::default(),
        }
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
