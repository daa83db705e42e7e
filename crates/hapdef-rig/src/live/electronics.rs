//! The measuring chain sample by sample: bridge, drift, temperature, creep, noise, converter.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::electronics::Electronics;
use crate::error::RigError;
use crate::live::flicker::Flicker;
use crate::params::ElectronicsParams;

/// Streams of the seed, beside the noise's own.
const CHANNEL_STREAM: u64 = 1;
const WALK_STREAM: u64 = 2;
const FLICKER_STREAM: u64 = 3;

/// What the chain does to a strain.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveElectronicsParams {
    /// White noise and converter; the seed is that of everything here.
    pub converter: ElectronicsParams,
    /// The bridge and its amplifier; without one the full scale is the converter's headroom times the
    /// largest reading, and readings are linear.
    pub bridge: Option<BridgeParams>,
    /// Largest zero offset; the channels' are uniform up to it, µε.
    pub offset_ue: f64,
    /// Random walk of each channel: its standard deviation after t is this times √t, µε/√s.
    pub walk_ue_per_sqrt_s: f64,
    /// 1/f noise of each channel from 1 mHz up: its density at 1 Hz, µε/√Hz.
    pub flicker_ue: f64,
    /// Largest temperature coefficient; the channels' are uniform up to it, µε/K.
    pub temperature_ue_per_k: f64,
    /// Temperature over time: (s, °C), ascending, straight lines between, constant outside; empty for
    /// 25 °C.
    pub temperature_c: Vec<(f64, f64)>,
    /// What creeps.
    pub creep: Vec<CreepTerm>,
    /// Pairs of gauges whose wires are swapped.
    pub swapped: Vec<(usize, usize)>,
    /// Channels that read 0, always.
    pub dead: Vec<usize>,
}

/// A quarter bridge: one gauge and three resistors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BridgeParams {
    /// Relative change of resistance per strain; 2 for most foil gauges.
    pub gauge_factor: f64,
    /// Excitation, V.
    pub excitation_v: f64,
    /// Gain of the amplifier.
    pub gain: f64,
    /// Whole input range of the converter, zero in its middle, V.
    pub range_v: f64,
}

/// A part of a strain that follows it exponentially: after a step it is `share (1 − exp(−t/τ))` of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CreepTerm {
    /// Part of the strain in the end.
    pub share: f64,
    /// τ, s.
    pub time_s: f64,
}

/// The chain of all channels, sample by sample at a fixed rate; the same seed gives the same codes.
#[derive(Clone, Debug)]
pub struct LiveElectronics {
    params: LiveElectronicsParams,
    converter: Electronics,
    period_s: f64,
    walk_rng: ChaCha8Rng,
    flicker: Flicker,
    /// Gauge behind each channel `[n]`.
    gauge_of: Vec<usize>,
    offset_ue: Vec<f64>,
    coefficient_ue_per_k: Vec<f64>,
    walk_ue: Vec<f64>,
    /// `[n, n_creep]`, µε.
    creep_ue: Vec<f64>,
    volts: Vec<f64>,
    saturated: u64,
}

impl LiveElectronicsParams {
    /// Noise and converter, nothing else.
    #[must_use]
    pub fn new(converter: ElectronicsParams) -> Self {
        Self {
            converter,
            bridge: None,
            offset_ue: 0.0,
            walk_ue_per_sqrt_s: 0.0,
            flicker_ue: 0.0,
            temperature_ue_per_k: 0.0,
            temperature_c: Vec::new(),
            creep: Vec::new(),
            swapped: Vec::new(),
            dead: Vec::new(),
        }
    }

    /// Temperature at `t_s`, °C.
    #[must_use]
    pub fn temperature_at(&self, t_s: f64) -> f64 {
        let after = self.temperature_c.partition_point(|(at_s, _)| *at_s <= t_s);
        let (before, next) = (after.checked_sub(1), self.temperature_c.get(after));
        match (before.map(|i| self.temperature_c[i]), next) {
            (Some((from_s, from)), Some((to_s, to))) => {
                from + (to - from) * (t_s - from_s) / (to_s - from_s)
            }
            (Some((_, c)), None) | (None, Some(&(_, c))) => c,
            (None, None) => 25.0,
        }
    }
}

impl BridgeParams {
    /// Strain at the end of the converter's range: U = U₀ k ε / 4 for small ε, µε.
    #[must_use]
    pub fn full_scale_ue(&self) -> f64 {
        let volts_per_strain = self.excitation_v * self.gauge_factor / 4.0 * self.gain;
        self.range_v / 2.0 / volts_per_strain * 1e6
    }

    /// What a strain reads as: a quarter bridge gives U/U₀ = k ε / (4 + 2 k ε), and k ε / 4 is what it
    /// is taken for.
    #[must_use]
    pub fn read_ue(&self, strain_ue: f64) -> f64 {
        strain_ue / (1.0 + self.gauge_factor * strain_ue * 1e-6 / 2.0)
    }
}

impl CreepTerm {
    /// Creep that goes with the logarithm of time, `per_decade` of the strain for each decade from
    /// `from_s` to `to_s`: four exponential terms a decade.
    #[must_use]
    pub fn logarithmic(per_decade: f64, from_s: f64, to_s: f64) -> Vec<Self> {
        const PER_DECADE: f64 = 4.0;
        let n = ((to_s / from_s).log10() * PER_DECADE).round().max(1.0) as i32;
        let term = |i: i32| Self {
            share: per_decade / PER_DECADE,
            time_s: from_s * 10f64.powf((f64::from(i) + 0.5) / PER_DECADE),
        };
        (0..n).map(term).collect()
    }
}

impl LiveElectronics {
    /// The chain at `rate_hz`; without a bridge each channel's full scale is `headroom` times its
    /// largest reading `largest_ue` `[n_gauges]`, µε.
    ///
    /// # Errors
    /// [`RigError::Parameter`] for a value outside its range.
    pub fn new(
        params: LiveElectronicsParams,
        rate_hz: f64,
        largest_ue: &[f64],
    ) -> Result<Self, RigError> {
        check(&params, rate_hz, largest_ue.len())?;
        let n = largest_ue.len();
        let converter = match &params.bridge {
            None => Electronics::new(params.converter, largest_ue)?,
            Some(bridge) => {
                let ends = vec![bridge.full_scale_ue(); n];
                let params = ElectronicsParams { headroom: 1.0, ..params.converter };
                Electronics::new(params, &ends)?
            }
        };
        let stream = |number| {
            let mut rng = ChaCha8Rng::seed_from_u64(params.converter.seed);
            rng.set_stream(number);
            rng
        };
        let mut rng = stream(CHANNEL_STREAM);
        let mut uniform = |largest: f64| -> Vec<f64> {
            (0..n).map(|_| rng.random_range(-1.0..=1.0) * largest).collect()
        };
        let mut gauge_of: Vec<usize> = (0..n).collect();
        for &(a, b) in &params.swapped {
            gauge_of.swap(a, b);
        }
        Ok(Self {
            offset_ue: uniform(params.offset_ue),
            coefficient_ue_per_k: uniform(params.temperature_ue_per_k),
            converter,
            period_s: 1.0 / rate_hz,
            walk_rng: stream(WALK_STREAM),
            flicker: Flicker::new(params.flicker_ue, rate_hz, n, stream(FLICKER_STREAM)),
            gauge_of,
            walk_ue: vec![0.0; n],
            creep_ue: vec![0.0; n * params.creep.len()],
            volts: vec![0.0; n],
            saturated: 0,
            params,
        })
    }

    /// Number of channels.
    #[must_use]
    pub fn n_channels(&self) -> usize {
        self.gauge_of.len()
    }

    /// Bits of the converter.
    #[must_use]
    pub fn adc_bits(&self) -> u32 {
        self.params.converter.adc_bits
    }

    /// One step of the converter of `channel`, µε.
    #[must_use]
    pub fn resolution_ue(&self, channel: usize) -> f64 {
        self.converter.resolution_ue(channel)
    }

    /// Temperature coefficient of each channel `[n]`, µε/K.
    #[must_use]
    pub fn coefficients_ue_per_k(&self) -> &[f64] {
        &self.coefficient_ue_per_k
    }

    /// Temperature at `t_s`, °C.
    #[must_use]
    pub fn temperature_at(&self, t_s: f64) -> f64 {
        self.params.temperature_at(t_s)
    }

    /// Channels at an end of their range in the last sample, a bit each.
    #[must_use]
    pub fn saturated(&self) -> u64 {
        self.saturated
    }

    /// One sample of all channels: strains of the gauges `[n]`, µε, at `t_s` to the converter's codes
    /// `[n]`.
    pub fn sample(&mut self, t_s: f64, strain_ue: &[f64], codes: &mut [i32]) {
        let warmer_k = self.params.temperature_at(t_s) - self.params.temperature_at(0.0);
        let walk_step = self.params.walk_ue_per_sqrt_s * self.period_s.sqrt();
        for channel in 0..self.gauge_of.len() {
            let strain = strain_ue[self.gauge_of[channel]];
            let crept = self.crept(channel, strain);
            if walk_step > 0.0 {
                let step: f64 = StandardNormal.sample(&mut self.walk_rng);
                self.walk_ue[channel] += walk_step * step;
            }
            let seen = match &self.params.bridge {
                None => crept,
                Some(bridge) => bridge.read_ue(crept),
            };
            self.volts[channel] = seen
                + self.offset_ue[channel]
                + self.walk_ue[channel]
                + self.flicker.next(channel)
                + self.coefficient_ue_per_k[channel] * warmer_k;
        }
        self.saturated = self.converter.sample(&self.volts, codes);
        for &channel in &self.params.dead {
            codes[channel] = 0;
            self.saturated &= !(1 << channel);
        }
    }

    /// The strain with what has crept; exact for strains that are constant from sample to sample.
    fn crept(&mut self, channel: usize, strain_ue: f64) -> f64 {
        let n = self.params.creep.len();
        let states = &mut self.creep_ue[channel * n..(channel + 1) * n];
        let mut crept = strain_ue;
        for (state, term) in states.iter_mut().zip(&self.params.creep) {
            crept += *state;
            let gain = -(-self.period_s / term.time_s).exp_m1();
            *state += (term.share * strain_ue - *state) * gain;
        }
        crept
    }
}

fn check(params: &LiveElectronicsParams, rate_hz: f64, n: usize) -> Result<(), RigError> {
    let require = |ok: bool, name, expected, found| {
        if ok {
            return Ok(());
        }
        Err(RigError::Parameter { name, expected, found })
    };
    let not_negative = |name, value: f64| {
        let ok = value.is_finite() && value >= 0.0;
        require(ok, name, "0 or more", value)
    };
    let positive = |name, value: f64| {
        let ok = value.is_finite() && value > 0.0;
        require(ok, name, "above 0", value)
    };
    positive("rate_hz", rate_hz)?;
    require((1..=64).contains(&n), "channels", "1 to 64", n as f64)?;
    not_negative("offset_ue", params.offset_ue)?;
    not_negative("walk_ue_per_sqrt_s", params.walk_ue_per_sqrt_s)?;
    not_negative("flicker_ue", params.flicker_ue)?;
    not_negative("temperature_ue_per_k", params.temperature_ue_per_k)?;
    for pair in params.temperature_c.windows(2) {
        let rises = pair[0].0 < pair[1].0;
        require(rises, "temperature_c", "rising times", pair[1].0)?;
    }
    for term in &params.creep {
        require(term.share.is_finite(), "creep.share", "a finite number", term.share)?;
        positive("creep.time_s", term.time_s)?;
    }
    if let Some(bridge) = &params.bridge {
        positive("bridge.gauge_factor", bridge.gauge_factor)?;
        positive("bridge.excitation_v", bridge.excitation_v)?;
        positive("bridge.gain", bridge.gain)?;
        positive("bridge.range_v", bridge.range_v)?;
    }
    let swapped = params.swapped.iter().flat_map(|(a, b)| [*a, *b]);
    for channel in swapped.chain(params.dead.iter().copied()) {
        let expected = "below the number of channels";
        require(channel < n, "swapped or dead channel", expected, channel as f64)?;
    }
    Ok(())
}
