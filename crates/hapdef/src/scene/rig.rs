//! Scene section about the simulated hardware. Every perturbation has a seed of its own.

use std::path::PathBuf;

use hapdef_rig::ElectronicsParams;
use hapdef_rig::live::LoadSensorParams;
use serde::{Deserialize, Serialize};

/// The simulated hardware: how it differs from the drawing and what it presses.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct RigSpec {
    /// The mesh the rig is solved on.
    #[serde(deserialize_with = "super::tag::rig_mesh")]
    pub mesh: RigMesh,
    /// Smooth variation of Young's modulus.
    pub stiffness: VariationSpec,
    /// Smooth variation of the wall thickness.
    pub thickness: VariationSpec,
    /// Depth below the skin down to which material counts as wall, m; if absent, half as much again
    /// as the wall of `geometry.skin` at its thickest, 3 mm for a deck.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_wall_m: Option<f64>,
    /// Gauges off their place.
    pub misplacement: MisplacementSpec,
    /// Gauge gains.
    pub gain: GainSpec,
    /// Noise and conversion.
    pub electronics: ElectronicsSpec,
    /// The presses that are recorded.
    pub presses: PressSpec,
    /// What the virtual rig's electronics do over time; nothing if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub live: Option<LiveSpec>,
}

/// What the virtual rig's electronics do over time, beside noise and conversion.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct LiveSpec {
    /// The bridge and its amplifier; `electronics.headroom` sets the range without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bridge: Option<BridgeSpec>,
    /// Largest zero offset of a channel, µε.
    pub offset_ue: f64,
    /// Random walk of a channel, µε/√s.
    pub walk_ue_per_sqrt_s: f64,
    /// 1/f noise of a channel: its density at 1 Hz, µε/√Hz.
    #[serde(skip_serializing_if = "is_zero")]
    pub flicker_ue: f64,
    /// Largest temperature coefficient of a channel, µε/K.
    pub temperature_ue_per_k: f64,
    /// Temperature over time: pairs of s and °C, ascending.
    pub temperature_c: Vec<[f64; 2]>,
    /// Adds a channel that tells the temperature.
    pub temperature_channel: bool,
    /// Adds channels of an inertial unit and of a sensor of force and torque at the flange, as far as the scene's loads
    /// are of weight, motion and a flange.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_sensors: Option<LoadSensorsSpec>,
    /// What creeps.
    pub creep: Vec<CreepSpec>,
    /// How much faster than true the device's clock runs, parts per million.
    pub drift_ppm: f64,
}

/// How well the rig's device measures the loads on the whole limb.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct LoadSensorsSpec {
    /// Each channel's gain is off by up to this share.
    pub gain_error: f64,
    /// Noise of an accelerometer's axis in a frame, standard deviation, m/s².
    pub acceleration_noise_m_s2: f64,
    /// Of a gyroscope's, rad/s.
    pub rate_noise_rad_s: f64,
    /// Of a force at the flange, N.
    pub force_noise_n: f64,
    /// Of a moment at the flange, N m.
    pub moment_noise_nm: f64,
}

impl Default for LoadSensorsSpec {
    fn default() -> Self {
        let LoadSensorParams {
            gain_error,
            acceleration_noise_m_s2,
            rate_noise_rad_s,
            force_noise_n,
            moment_noise_nm,
            ..
        } = LoadSensorParams::default();
        Self {
            gain_error,
            acceleration_noise_m_s2,
            rate_noise_rad_s,
            force_noise_n,
            moment_noise_nm,
        }
    }
}

/// A quarter bridge.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BridgeSpec {
    /// Relative change of resistance per strain.
    pub gauge_factor: f64,
    /// Excitation, V.
    pub excitation_v: f64,
    /// Gain of the amplifier.
    pub gain: f64,
    /// Whole input range of the converter, V.
    pub range_v: f64,
}

/// A part of a strain that follows it exponentially.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct CreepSpec {
    /// Part of the strain in the end.
    pub share: f64,
    /// Time constant, s.
    pub time_s: f64,
}

/// The mesh the rig is solved on.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum RigMesh {
    /// The training side's mesh, every tetrahedron cut into eight, `times` times.
    Refined {
        /// How often; 0 would be the training mesh itself and is refused.
        #[serde(default = "once")]
        times: u32,
    },
    /// A mesh of its own: the same limb, meshed independently.
    Deck {
        /// Deck of ten-node tetrahedra, relative to the scene file; mount, region and gauges are
        /// found on it as on `geometry.solid_deck`, whose unit it has.
        solid_deck: PathBuf,
        /// How many times every tetrahedron of it is cut into eight.
        #[serde(default)]
        refinements: u32,
    },
}

impl RigMesh {
    /// How often its tetrahedra are cut into eight.
    #[must_use]
    pub fn refinements(&self) -> u32 {
        match self {
            Self::Refined { times } => *times,
            Self::Deck { refinements, .. } => *refinements,
        }
    }
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
#[serde(default, deny_unknown_fields)]
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
#[serde(default, deny_unknown_fields)]
pub struct GainSpec {
    /// Largest deviation as a fraction.
    pub fraction: f64,
    /// Seed.
    pub seed: u64,
}

/// The measuring chain.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
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

impl ElectronicsSpec {
    /// What the simulated measuring chain takes.
    #[must_use]
    pub fn params(&self) -> ElectronicsParams {
        let Self { noise_ue, adc_bits, headroom, seed } = *self;
        ElectronicsParams { noise_ue, adc_bits, headroom, seed }
    }
}

/// The probing robot's protocol (Sun & Martius 2019, sections 3.1 and 4.4).
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
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

impl Default for RigSpec {
    /// The limb's mesh refined once; stiffness 10 %, wall 5 %, gains 3 % off.
    fn default() -> Self {
        let varied = |fraction, seed| VariationSpec { fraction, correlation_length_m: 0.03, seed };
        Self {
            mesh: RigMesh::Refined { times: 1 },
            stiffness: varied(0.1, 11),
            thickness: varied(0.05, 12),
            max_wall_m: None,
            misplacement: MisplacementSpec::default(),
            gain: GainSpec::default(),
            electronics: ElectronicsSpec::default(),
            presses: PressSpec::default(),
            live: None,
        }
    }
}

impl Default for MisplacementSpec {
    /// A millimetre and 3°.
    fn default() -> Self {
        Self { shift_m: 1e-3, turn_deg: 3.0, seed: 13 }
    }
}

impl Default for GainSpec {
    /// 3 %.
    fn default() -> Self {
        Self { fraction: 0.03, seed: 14 }
    }
}

impl Default for ElectronicsSpec {
    /// A microstrain of noise and 12 bits.
    fn default() -> Self {
        Self { noise_ue: 1.0, adc_bits: 12, headroom: 1.5, seed: 15 }
    }
}

impl Default for PressSpec {
    /// The paper's: 12–75 mm apart, one held at 30 N.
    fn default() -> Self {
        Self {
            single_seed: 16,
            double_seed: 17,
            spacing_range_m: [0.012, 0.075],
            held_force_n: 30.0,
            held_spread_n: 1.0,
        }
    }
}

fn once() -> u32 {
    1
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde calls it so")]
pub(super) fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
