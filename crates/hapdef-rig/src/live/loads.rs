//! Loads on the whole limb that are no contacts and change all the time, as on a robot that moves.

use std::f64::consts::TAU;
use std::sync::{Arc, Mutex, PoisonError};

use hapdef_contact::LimbLoad;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Mean frequencies of each load's waves, Hz: a pose that changes, a joint that moves, a limb that shakes.
const FREQUENCIES_HZ: [f64; 3] = [0.11, 0.37, 1.3];

/// Each load's own frequencies are off these by up to this share, so that loads are independent of each other.
const SPREAD: f64 = 0.2;

/// Time in which loads come to their full size, s.
const RISE_S: f64 = 1.0;

/// How a limb is loaded as a whole, in its frame, as a simulator of the robot knows it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LimbLoads {
    /// Gravity less the acceleration of the limb's origin, m/s².
    pub specific_force_m_s2: Vector3<f64>,
    /// Angular rate, rad/s.
    pub angular_rate_rad_s: Vector3<f64>,
    /// Angular acceleration, rad/s².
    pub angular_acceleration_rad_s2: Vector3<f64>,
    /// Force of the next joint on the limb at the middle of the flange, N.
    pub flange_force_n: Vector3<f64>,
    /// Its moment about that point, N m.
    pub flange_moment_nm: Vector3<f64>,
    /// How much warmer the limb is than at first, K.
    pub warmer_k: f64,
}

/// Sets how the limb is loaded as a whole by hand, from any thread, in place of waves: the device takes it up with its next
/// frame.
#[derive(Clone, Debug, Default)]
pub struct LoadHandle {
    loads: Arc<Mutex<Option<LimbLoads>>>,
}

/// Sums of waves, a load each, none before they begin. Of a limb that turns, the rate about each axis is one, and what
/// it does follows from the rates: their products and, where there is such a load, their slopes.
#[derive(Clone, Debug, Default)]
pub struct MovingLoads {
    loads: Vec<LimbLoad>,
    /// Strain of each gauge for one unit `[n_loads, n_gauges]`, µε.
    responses_ue: Vec<f64>,
    /// Standard deviation of each load over time `[n_loads]`.
    sd: Vec<f64>,
    /// Frequency, Hz, and phase of each wave.
    waves: Vec<[(f64, f64); 3]>,
    begin_s: f64,
}

impl LimbLoads {
    /// How much there is of a load.
    #[must_use]
    pub fn amount(&self, load: LimbLoad) -> f64 {
        match load {
            LimbLoad::FlangeForce(i) => self.flange_force_n[i],
            LimbLoad::FlangeMoment(i) => self.flange_moment_nm[i],
            LimbLoad::SpecificForce(i) => self.specific_force_m_s2[i],
            LimbLoad::AngularAcceleration(i) => self.angular_acceleration_rad_s2[i],
            LimbLoad::AngularRates(i, j) => self.angular_rate_rad_s[i] * self.angular_rate_rad_s[j],
            LimbLoad::Temperature => self.warmer_k,
        }
    }
}

impl LoadHandle {
    /// Sets the loads from now on.
    pub fn set(&self, loads: LimbLoads) {
        *self.loads.lock().unwrap_or_else(PoisonError::into_inner) = Some(loads);
    }

    /// What was set, if anything.
    pub(super) fn get(&self) -> Option<LimbLoads> {
        *self.loads.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl MovingLoads {
    /// Loads with their standard deviations `[n_loads]` from `begin_s` on, which strain the gauges by `responses_ue`
    /// `[n_loads, n_gauges]`, µε per unit.
    #[must_use]
    pub fn new(
        loads: Vec<(LimbLoad, f64)>,
        responses_ue: Vec<f64>,
        begin_s: f64,
        seed: u64,
    ) -> Self {
        let (loads, sd): (Vec<_>, Vec<f64>) = loads.into_iter().unzip();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut wave =
            |hz: f64| (hz * (1.0 + rng.random_range(-SPREAD..=SPREAD)), rng.random_range(0.0..TAU));
        let waves = sd.iter().map(|_| FREQUENCIES_HZ.map(&mut wave)).collect();
        Self { loads, responses_ue, sd, waves, begin_s }
    }

    /// How much of each load there is at `t_s` `[n_loads]`.
    pub fn amounts(&self, t_s: f64) -> impl Iterator<Item = f64> {
        (0..self.loads.len()).map(move |place| match self.loads[place] {
            LimbLoad::AngularRates(i, j) => self.rate_rad_s(i, t_s) * self.rate_rad_s(j, t_s),
            LimbLoad::AngularAcceleration(i) => match self.place_of_rate(i) {
                Some(rate) => self.rate_sd(rate) * self.wave(rate, t_s).1,
                None => self.sd[place] * self.wave(place, t_s).0,
            },
            _ => self.sd[place] * self.wave(place, t_s).0,
        })
    }

    /// The loads, in their order.
    #[must_use]
    pub fn loads(&self) -> &[LimbLoad] {
        &self.loads
    }

    /// Angular rate about a direction, rad/s; 0 of a limb that doesn't turn.
    #[must_use]
    pub fn rate_rad_s(&self, direction: usize, t_s: f64) -> f64 {
        let rate = self.place_of_rate(direction);
        rate.map_or(0.0, |rate| self.rate_sd(rate) * self.wave(rate, t_s).0)
    }

    fn place_of_rate(&self, i: usize) -> Option<usize> {
        self.loads.iter().position(|load| *load == LimbLoad::AngularRates(i, i))
    }

    /// Standard deviation σ of a rate whose square has a root mean square of √3 σ².
    fn rate_sd(&self, place: usize) -> f64 {
        (self.sd[place] / 3.0_f64.sqrt()).sqrt()
    }

    /// The sum of the waves of the load at `place`, of standard deviation 1, and its slope, 1/s.
    fn wave(&self, place: usize, t_s: f64) -> (f64, f64) {
        let since_s = (t_s - self.begin_s).max(0.0);
        let full = (2.0 / FREQUENCIES_HZ.len() as f64).sqrt();
        let size = full * (since_s / RISE_S).min(1.0);
        let is_rising = t_s > self.begin_s && since_s < RISE_S;
        let growth = if is_rising { full / RISE_S } else { 0.0 };
        let (mut sum, mut slope) = (0.0, 0.0);
        for (hz, phase) in &self.waves[place] {
            let (sin, cos) = (TAU * hz * since_s + phase).sin_cos();
            sum += sin;
            slope += TAU * hz * cos;
        }
        (size * sum, growth * sum + size * slope)
    }

    /// Adds the strains of `amounts` `[n_loads]` to `strain_ue` `[n_gauges]`, µε.
    pub(super) fn add_strain_ue(&self, amounts: &[f64], strain_ue: &mut [f64]) {
        for (row, amount) in self.responses_ue.chunks_exact(strain_ue.len()).zip(amounts) {
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
        let loads = MovingLoads::new(vec![(LimbLoad::Temperature, 3.0)], vec![1.0, -2.0], 2.0, 7);
        let mut strain = [0.0; 2];
        let amounts = |t_s: f64| loads.amounts(t_s).collect::<Vec<_>>();
        loads.add_strain_ue(&amounts(1.9), &mut strain);
        assert_eq!(strain, [0.0; 2]);
        let times = (0..200_000).map(|i| 10.0 + f64::from(i) * 0.01);
        let squares: f64 = times.map(|t| loads.amounts(t).map(|a| a * a).sum::<f64>()).sum();
        let sd = (squares / 200_000.0).sqrt();
        assert!((sd / 3.0 - 1.0).abs() < 0.02, "{sd}");
        loads.add_strain_ue(&amounts(12.3), &mut strain);
        assert!((strain[1] + 2.0 * strain[0]).abs() < 1e-12 && strain[0] != 0.0);
        assert_eq!(loads.largest_ue(2), [6.0, 12.0]);
    }

    /// Products and slopes are those of the rates.
    #[test]
    fn a_limb_that_turns_has_one_rate_about_each_axis() {
        let rates = (0..3).flat_map(|i| (i..3).map(move |j| LimbLoad::AngularRates(i, j)));
        let slopes = (0..3).map(LimbLoad::AngularAcceleration);
        let loads: Vec<_> = slopes.chain(rates).map(|load| (load, 2.0)).collect();
        let loads = MovingLoads::new(loads, vec![0.0; 9], 1.0, 4);
        for t_s in [0.5, 1.4, 3.7] {
            let amounts: Vec<f64> = loads.amounts(t_s).collect();
            for i in 0..3 {
                let rate = |t_s: f64| loads.rate_rad_s(i, t_s);
                let slope = (rate(t_s + 1e-5) - rate(t_s - 1e-5)) / 2e-5;
                assert!((amounts[i] - slope).abs() < 1e-6, "{} {slope}", amounts[i]);
            }
            assert_eq!(amounts[4], loads.rate_rad_s(0, t_s) * loads.rate_rad_s(1, t_s));
        }
    }
}
