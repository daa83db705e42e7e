//! From strain to a tared, quantised reading.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::error::RigError;
use crate::params::ElectronicsParams;

/// The measuring chain: white noise, then a converter with its full scale set per channel.
#[derive(Clone, Debug)]
pub struct Electronics {
    full_scale_ue: Vec<f64>,
    params: ElectronicsParams,
    rng: ChaCha8Rng,
    n_saturated: u64,
}

impl Electronics {
    /// Sets each channel's full scale to `params.headroom` times its largest single-press reading
    /// `largest_ue` `[n_gauges]`, µε.
    ///
    /// # Errors
    /// [`RigError::Parameter`] for a headroom or a largest reading that is not positive, negative
    /// noise, or a converter of no or more than 32 bits.
    pub fn new(params: ElectronicsParams, largest_ue: &[f64]) -> Result<Self, RigError> {
        let check = |ok: bool, name, expected, found| {
            if ok { Ok(()) } else { Err(RigError::Parameter { name, expected, found }) }
        };
        check(params.headroom > 0.0, "headroom", "above 0", params.headroom)?;
        check(params.noise_ue >= 0.0, "noise_ue", "0 or more", params.noise_ue)?;
        let bits = params.adc_bits;
        check((1..=32).contains(&bits), "adc_bits", "1 to 32", f64::from(bits))?;
        for &largest in largest_ue {
            check(largest > 0.0, "largest reading", "above 0: the gauge answers", largest)?;
        }
        Ok(Self {
            full_scale_ue: largest_ue.iter().map(|l| l * params.headroom).collect(),
            rng: ChaCha8Rng::seed_from_u64(params.seed),
            params,
            n_saturated: 0,
        })
    }

    /// Turns the strains of one frame into readings in place, `[n_gauges]`, µε.
    pub fn measure(&mut self, frame_ue: &mut [f64]) {
        for channel in 0..frame_ue.len() {
            let noise: f64 = StandardNormal.sample(&mut self.rng);
            let volts = frame_ue[channel] + self.params.noise_ue * noise;
            frame_ue[channel] = self.convert(channel, volts);
        }
    }

    /// Turns the strains of one frame, µε, into the converter's codes, both `[n_gauges]`; returns the
    /// channels at an end of their range, a bit each for the first 64.
    pub fn sample(&mut self, frame_ue: &[f64], codes: &mut [i32]) -> u64 {
        let mut saturated = 0;
        for channel in 0..frame_ue.len() {
            let noise: f64 = StandardNormal.sample(&mut self.rng);
            let volts = frame_ue[channel] + self.params.noise_ue * noise;
            let (code, is_saturated) = self.code(channel, volts);
            // In the range of 32 bits by the check of `adc_bits`.
            codes[channel] = code as i32;
            saturated |= u64::from(is_saturated && channel < 64) << (channel % 64);
        }
        saturated
    }

    /// One step of the converter of `channel`, µε.
    #[must_use]
    pub fn resolution_ue(&self, channel: usize) -> f64 {
        self.full_scale_ue[channel] / 2.0_f64.powi(self.params.adc_bits as i32 - 1)
    }

    /// Readings so far that met an end of the converter's range.
    #[must_use]
    pub fn n_saturated(&self) -> u64 {
        self.n_saturated
    }

    fn convert(&mut self, channel: usize, reading_ue: f64) -> f64 {
        self.code(channel, reading_ue).0 * self.resolution_ue(channel)
    }

    /// Two's-complement converter over ± full scale: its code, and whether the range has ended.
    fn code(&mut self, channel: usize, reading_ue: f64) -> (f64, bool) {
        let half_range = 2.0_f64.powi(self.params.adc_bits as i32 - 1);
        let code = (reading_ue / self.resolution_ue(channel)).round();
        let clamped = code.clamp(-half_range, half_range - 1.0);
        let is_saturated = clamped.total_cmp(&code).is_ne();
        self.n_saturated += u64::from(is_saturated);
        (clamped, is_saturated)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn params(noise_ue: f64) -> ElectronicsParams {
        ElectronicsParams { noise_ue, adc_bits: 12, headroom: 1.5, seed: 9 }
    }

    #[test]
    fn a_quiet_reading_is_off_by_half_a_step_at_most() {
        let mut electronics = Electronics::new(params(0.0), &[1000.0]).unwrap();
        let step = electronics.resolution_ue(0);
        assert!((step - 1500.0 / 2048.0).abs() < 1e-12);
        for k in -20..20 {
            let strain = f64::from(k) * 71.3;
            let mut frame = [strain];
            electronics.measure(&mut frame);
            assert!(
                (frame[0] - strain).abs() <= step / 2.0 + 1e-9,
                "{strain} read as {}",
                frame[0]
            );
        }
        assert_eq!(electronics.n_saturated(), 0);
    }

    #[test]
    fn the_ends_of_the_range_hold_and_are_counted() {
        let mut electronics = Electronics::new(params(0.0), &[1000.0]).unwrap();
        let mut frame = [9e9];
        electronics.measure(&mut frame);
        assert!(frame[0] < 1500.0 && frame[0] > 1499.0, "{}", frame[0]);
        assert_eq!(electronics.n_saturated(), 1);
    }

    #[test]
    fn noise_has_the_stated_spread() {
        let mut electronics =
            Electronics::new(ElectronicsParams { adc_bits: 24, ..params(5.0) }, &[1e4]).unwrap();
        let n = 20_000;
        let mut sum_of_squares = 0.0;
        for _ in 0..n {
            let mut frame = [0.0];
            electronics.measure(&mut frame);
            sum_of_squares += frame[0] * frame[0];
        }
        let spread = (sum_of_squares / f64::from(n)).sqrt();
        assert!((spread - 5.0).abs() < 0.1, "spread {spread}");
    }

    #[test]
    fn a_gauge_that_answers_nothing_is_refused() {
        let error = Electronics::new(params(1.0), &[10.0, 0.0]).unwrap_err();
        assert!(error.to_string().contains("largest reading"), "{error}");
    }
}
