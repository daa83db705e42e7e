//! Loads on the whole limb that are no contacts and change all the time, as on a robot that moves.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Mean frequencies of each load's waves, Hz: a pose that changes, a joint that moves, a limb that shakes.
const FREQUENCIES_HZ: [f64; 3] = [0.11, 0.37, 1.3];

/// Each load's own frequencies are off these by up to this share, so that loads are independent of each other.
const SPREAD: f64 = 0.2;

/// Time in which loads come to their full size, s.
const RISE_S: f64 = 1.0;

/// Sums of waves, a load each, none before they begin.
#[derive(Clone, Debug, Default)]
pub struct MovingLoads {
    /// Strain of each gauge for one unit `[n_loads, n_gauges]`, µε.
    responses_ue: Vec<f64>,
    /// Standard deviation of each load over time `[n_loads]`.
    sd: Vec<f64>,
    /// Frequency, Hz, and phase of each wave.
    waves: Vec<[(f64, f64); 3]>,
    begin_s: f64,
}

impl MovingLoads {
    /// Loads of standard deviation `sd` `[n_loads]` from `begin_s` on, which strain the gauges by `responses_ue`
    /// `[n_loads, n_gauges]`, µε per unit.
    #[must_use]
    pub fn new(responses_ue: Vec<f64>, sd: Vec<f64>, begin_s: f64, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut wave =
            |hz: f64| (hz * (1.0 + rng.random_range(-SPREAD..=SPREAD)), rng.random_range(0.0..TAU));
        let waves = sd.iter().map(|_| FREQUENCIES_HZ.map(&mut wave)).collect();
        Self { responses_ue, sd, waves, begin_s }
    }

    /// How much of each load there is at `t_s` `[n_loads]`.
    pub fn amounts(&self, t_s: f64) -> impl Iterator<Item = f64> {
        let since_s = (t_s - self.begin_s).max(0.0);
        let size = (since_s / RISE_S).min(1.0) * (2.0 / FREQUENCIES_HZ.len() as f64).sqrt();
        let sum = move |waves: &[(f64, f64); 3]| -> f64 {
            waves.iter().map(|(hz, phase)| (TAU * hz * since_s + phase).sin()).sum()
        };
        self.sd.iter().zip(&self.waves).map(move |(sd, waves)| sd * size * sum(waves))
    }

    /// Adds the strains at `t_s` to `strain_ue` `[n_gauges]`, µε.
    pub(super) fn add_strain_ue(&self, t_s: f64, strain_ue: &mut [f64]) {
        for (row, amount) in self.responses_ue.chunks_exact(strain_ue.len()).zip(self.amounts(t_s))
        {
            strain_ue.iter_mut().zip(row).for_each(|(sum, unit)| *sum += amount * unit);
        }
    }

    /// Two standard deviations of all loads together for each of `n_gauges` gauges, added up, µε.
    pub(super) fn largest_ue(&self, n_gauges: usize) -> Vec<f64> {
        let mut largest = vec![0.0; n_gauges];
        for (row, sd) in self.responses_ue.chunks_exact(n_gauges.max(1)).zip(&self.sd) {
            largest.iter_mut().zip(row).for_each(|(sum, unit)| *sum += 2.0 * sd * unit.abs());
        }
        largest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_are_still_first_and_then_of_their_size() {
        let loads = MovingLoads::new(vec![1.0, -2.0], vec![3.0], 2.0, 7);
        let mut strain = [0.0; 2];
        loads.add_strain_ue(1.9, &mut strain);
        assert_eq!(strain, [0.0; 2]);
        let times = (0..200_000).map(|i| 10.0 + f64::from(i) * 0.01);
        let squares: f64 = times.map(|t| loads.amounts(t).map(|a| a * a).sum::<f64>()).sum();
        let sd = (squares / 200_000.0).sqrt();
        assert!((sd / 3.0 - 1.0).abs() < 0.02, "{sd}");
        loads.add_strain_ue(12.3, &mut strain);
        assert!((strain[1] + 2.0 * strain[0]).abs() < 1e-12 && strain[0] != 0.0);
        assert_eq!(loads.largest_ue(2), [6.0, 12.0]);
    }
}
