//! Scene section about the simulated hardware. Every perturbation has a seed of its own.

use serde::{Deserialize, Serialize};

/// The simulated hardware: how it differs from the drawing and what it presses.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RigSpec {
    /// The mesh the rig is solved on.
    pub mesh: RigMesh,
    /// Smooth variation of Young's modulus.
    pub stiffness: VariationSpec,
    /// Smooth variation of the wall thickness.
    pub thickness: VariationSpec,
    /// Depth below the skin down to which material counts as wall, m.
    pub max_wall_m: f64,
    /// Gauges off their place.
    pub misplacement: MisplacementSpec,
    /// Gauge gains.
    pub gain: GainSpec,
    /// Noise and conversion.
    pub electronics: ElectronicsSpec,
    /// The presses that are recorded.
    pub presses: PressSpec,
}

/// The mesh the rig is solved on.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum RigMesh {
    /// The training side's mesh, every tetrahedron cut into eight, `times` times.
    Refined {
        /// How often; 0 would be the training mesh itself and is refused.
        times: u32,
    },
}

/// A smooth relative variation over the limb.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct VariationSpec {
    /// Largest deviation as a fraction.
    pub fraction: f64,
    /// Correlation length, m.
    pub correlation_length_m: f64,
    /// Seed.
    pub seed: u64,
}

/// Gauges off their nominal place.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct MisplacementSpec {
    /// Distance along the wall, m.
    pub shift_m: f64,
    /// Turn about the wall's normal, degrees.
    pub turn_deg: f64,
    /// Seed.
    pub seed: u64,
}

/// Gauge gains off from one.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GainSpec {
    /// Largest deviation as a fraction.
    pub fraction: f64,
    /// Seed.
    pub seed: u64,
}

/// The measuring chain.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ElectronicsSpec {
    /// White noise, standard deviation, µε.
    pub noise_ue: f64,
    /// Bits of the converter.
    pub adc_bits: u32,
    /// Full scale over the largest single-press reading of each channel.
    pub headroom: f64,
    /// Seed of the noise.
    pub seed: u64,
}

/// The probing robot's protocol (Sun & Martius 2019, sections 3.1 and 4.4).
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PressSpec {
    /// Seed of the single presses.
    pub single_seed: u64,
    /// Seed of the double presses.
    pub double_seed: u64,
    /// Distance of two contacts, m; the paper has 12–75 mm.
    pub spacing_range_m: [f64; 2],
    /// Force of the held contact, N; the paper has around 30 N.
    pub held_force_n: f64,
    /// Half width of the held force's uniform spread, N.
    pub held_spread_n: f64,
}
