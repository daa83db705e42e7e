//! Parameters of the simulated hardware; each perturbation has its own seed.

/// A smooth relative variation over the limb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VariationParams {
    /// Largest deviation as a fraction of the nominal value: 0.1 for ±10 %.
    pub fraction: f64,
    /// Length over which the field changes, m.
    pub correlation_length_m: f64,
    /// Seed of the field.
    pub seed: u64,
}

/// How far each gauge sits from its nominal place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MisplacementParams {
    /// Distance along the wall, in a random direction, m.
    pub shift_m: f64,
    /// Turn about the wall's normal, of random sign, rad.
    pub turn_rad: f64,
    /// Seed of directions and signs.
    pub seed: u64,
}

/// Deviation of each gauge's gain from one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GainParams {
    /// Largest deviation; gains are uniform in `1 ± fraction`.
    pub fraction: f64,
    /// Seed of the gains.
    pub seed: u64,
}

/// The measuring chain of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElectronicsParams {
    /// Standard deviation of white noise on a reading, µε.
    pub noise_ue: f64,
    /// Bits of the converter.
    pub adc_bits: u32,
    /// Full scale over the largest single-press reading of the channel; 1 is just enough for it.
    pub headroom: f64,
    /// Seed of the noise.
    pub seed: u64,
}

/// The simulated hardware as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigParams {
    /// Times the nominal limb's mesh is refined uniformly before it is solved.
    pub refinements: u32,
    /// How far from the nominal skin a press may be given, m: it goes to the nearest point, as it
    /// must where places come from another mesh of the limb. `None` takes places as they are.
    pub max_off_skin_m: Option<f64>,
    /// Variation of Young's modulus.
    pub stiffness: VariationParams,
    /// Variation of the wall thickness.
    pub thickness: VariationParams,
    /// Depth below the skin down to which material counts as wall, m.
    pub max_wall_m: f64,
    /// Displacement and turn of the gauges.
    pub misplacement: MisplacementParams,
    /// Gauge gains.
    pub gain: GainParams,
}
