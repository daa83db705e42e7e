//! What of a frame loads explain that are no contacts: kept away from touch detection and from the zero.

use crate::dense::{cholesky, solve_lower, solve_upper};
use crate::other_loads::OtherLoads;

/// Variance of a gauge that doesn't count, in units of its noise: it says nothing of the loads.
const UNREAD: f64 = 1e14;

/// The most probable loads of a frame. Allocates nothing once it is there.
#[derive(Clone, Debug)]
pub(crate) struct LoadFit {
    /// Σ s² b bᵀ `[n, n]`; empty without loads.
    covariance: Vec<f64>,
    /// L of the covariance of loads and noise `[n, n]`.
    l: Vec<f64>,
    /// Gauges that it was made for.
    live: Vec<bool>,
    sd: Vec<f64>,
    weights: Vec<f64>,
    /// What the loads of the last frame add to the readings `[n]`.
    pub(crate) explained: Vec<f64>,
}

impl LoadFit {
    pub(crate) fn new(loads: &OtherLoads, gauge_sd: &[f64]) -> Self {
        let n = gauge_sd.len();
        let mut covariance = vec![0.0; if loads.is_empty() { 0 } else { n * n }];
        if !loads.is_empty() {
            let all: Vec<usize> = (0..n).collect();
            loads.add_to(&all, n, &mut covariance);
        }
        let mut fit = Self {
            l: covariance.clone(),
            covariance,
            live: vec![true; n],
            sd: gauge_sd.to_vec(),
            weights: vec![0.0; n],
            explained: vec![0.0; n],
        };
        fit.factor();
        fit
    }

    pub(crate) fn set_gauge_sd(&mut self, gauge_sd: &[f64]) {
        self.sd.copy_from_slice(gauge_sd);
        self.factor();
    }

    /// Takes off `readings` `[n]` what the loads most probably add to them.
    pub(crate) fn take_off(&mut self, readings: &mut [f64], live: &[bool]) {
        if self.covariance.is_empty() {
            return;
        }
        let n = readings.len();
        if self.live != live {
            self.live.copy_from_slice(live);
            self.factor();
        }
        self.weights.copy_from_slice(readings);
        solve_lower(&self.l, n, &mut self.weights);
        solve_upper(&self.l, n, &mut self.weights);
        for (g, explained) in self.explained.iter_mut().enumerate() {
            let row = &self.covariance[g * n..(g + 1) * n];
            *explained = row.iter().zip(&self.weights).map(|(c, w)| c * w).sum();
            if live[g] {
                readings[g] -= *explained;
            }
        }
    }

    /// Adds what [`Self::take_off`] took off.
    pub(crate) fn put_back(&self, readings: &mut [f64], live: &[bool]) {
        if self.covariance.is_empty() {
            return;
        }
        for (g, reading) in readings.iter_mut().enumerate().filter(|(g, _)| live[*g]) {
            *reading += self.explained[g];
        }
    }

    fn factor(&mut self) {
        if self.covariance.is_empty() {
            return;
        }
        let n = self.sd.len();
        self.l.copy_from_slice(&self.covariance);
        for g in 0..n {
            let scale = if self.live[g] { 1.0 } else { UNREAD };
            self.l[g * n + g] += scale * self.sd[g].powi(2);
        }
        if !cholesky(&mut self.l, n, 0.0) {
            // rounding beside huge loads: nothing is known of them
            self.l.fill(0.0);
            (0..n).for_each(|g| self.l[g * n + g] = 1e12 * self.sd[g]);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Loads much larger than the noise are taken off but for a trace, whatever gauge is dead, and come back.
        #[test]
        fn loads_are_taken_off_and_come_back(
            rows in prop::collection::vec(-20.0_f64..20.0, 3 * 8),
            amounts in prop::collection::vec(-30.0_f64..30.0, 3),
            dead in 0_usize..8,
        ) {
            let loads = OtherLoads { response: rows.clone(), sd: vec![30.0; 3] };
            let mut fit = LoadFit::new(&loads, &[1.0; 8]);
            let mut live = [true; 8];
            live[dead] = false;
            let mut readings = vec![0.0; 8];
            loads.take_off(&amounts.iter().map(|a| -a).collect::<Vec<_>>(), &mut readings).unwrap();
            readings[dead] = 0.0;
            let before = readings.clone();
            fit.take_off(&mut readings, &live);
            for g in (0..8).filter(|g| live[*g]) {
                prop_assert!(readings[g].abs() < 1.0, "{:?}", readings);
            }
            fit.put_back(&mut readings, &live);
            for (a, b) in readings.iter().zip(before) {
                prop_assert!((a - b).abs() < 1e-6);
            }
        }
    }
}
