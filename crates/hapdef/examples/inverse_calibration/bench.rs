//! Errors of the contacts found with a map.

use std::sync::Arc;

use anyhow::Result;
use hapdef_inverse::{
    ContactEstimator, EstimatorParams, ModelError, ResponseMap, ScanSites, SkinPoint,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::draw::Hardware;
use crate::shared::{matched, mean, percent, quantile};

/// χ²₂ and |z| that 95 % don't exceed.
const CHI2_2: f64 = 5.991;
const Z: f64 = 1.96;

/// No press or contact is stronger than 34 N.
const MAX_FORCE_N: f64 = 50.0;

type Frame = (Vec<(SkinPoint, f64)>, Vec<f64>);

pub(crate) struct Bench<'a, 'b> {
    pub(crate) hardware: &'a mut Hardware<'b>,
    sites: Arc<ScanSites>,
    frames: [Vec<Frame>; 2],
}

#[derive(Default)]
struct Row {
    mm: Vec<f64>,
    newtons: Vec<f64>,
    /// Positions, forces and how many of them lie in their regions.
    covered: [usize; 2],
    n_far: usize,
    n_missed: usize,
    n_right: usize,
}

impl<'a, 'b> Bench<'a, 'b> {
    pub(crate) fn new(
        hardware: &'a mut Hardware<'b>,
        sites: &Arc<ScanSites>,
        n_frames: usize,
        seed: u64,
    ) -> Result<Self> {
        let mut frames = [Vec::new(), Vec::new()];
        for (k, frames) in frames.iter_mut().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(seed + k as u64);
            for _ in 0..n_frames {
                let contacts = hardware.contacts(k + 1, &mut rng)?;
                let readings = hardware.readings(&contacts)?;
                frames.push((contacts, readings));
            }
        }
        Ok(Self { hardware, sites: sites.clone(), frames })
    }

    /// Prints a row for one and for two contacts, the count estimated.
    pub(crate) fn tables(&self, map: &Arc<ResponseMap>, model_error: ModelError) -> Result<()> {
        println!(
            "  k  mean mm  median     p90   mean N  median  >10 mm  missed   count  95 %: place  force"
        );
        let noise = self.hardware.noise(model_error);
        let params = EstimatorParams { max_force_n: MAX_FORCE_N, ..EstimatorParams::default() };
        let estimator = ContactEstimator::new(map.clone(), self.sites.clone(), noise, params)?;
        for (k, frames) in self.frames.iter().enumerate() {
            let mut row = Row::default();
            for (contacts, readings) in frames {
                row.add(&estimator, contacts, readings)?;
            }
            row.print(k + 1, frames.len());
        }
        Ok(())
    }
}

impl Row {
    fn add(
        &mut self,
        estimator: &ContactEstimator,
        contacts: &[(SkinPoint, f64)],
        readings: &[f64],
    ) -> Result<()> {
        let skin = estimator.map().skin();
        let found = estimator.estimate(readings)?.contacts;
        self.n_right += usize::from(found.len() == contacts.len());
        let truth = contacts.iter().map(|(p, force_n)| (skin.position(p), *force_n));
        let matched = matched(truth, found.iter().map(|c| (c.position_m, c.force_n)))?;
        self.n_missed += matched.missed.len();
        for pair in matched.pairs {
            let (point, force_n) = &contacts[pair.truth];
            let c = &found[pair.detected];
            let miss = skin.position(point) - c.position_m;
            self.n_far += usize::from(miss.norm() > 0.01);
            self.mm.push(miss.norm() * 1e3);
            self.newtons.push((c.force_n - force_n).abs());
            let [a, b] = skin.tangents(&c.point).map(|t| t.dot(&miss));
            let s = &c.covariance;
            let det = s[(0, 0)] * s[(1, 1)] - s[(0, 1)] * s[(0, 1)];
            let chi2 = (s[(1, 1)] * a * a - 2.0 * s[(0, 1)] * a * b + s[(0, 0)] * b * b) / det;
            self.covered[0] += usize::from(chi2 <= CHI2_2);
            let z = (c.force_n - force_n) / s[(2, 2)].sqrt();
            self.covered[1] += usize::from(z.abs() <= Z);
        }
        Ok(())
    }

    fn print(&mut self, k: usize, n_frames: usize) {
        let n = self.mm.len().max(1);
        println!(
            "{k:>3} {:>8.3} {:>7.3} {:>7.3} {:>8.3} {:>7.3} {:>6.1}% {:>6.1}% {:>6.1}% {:>11.1}% {:>5.1}%",
            mean(&self.mm),
            quantile(&mut self.mm, 0.5),
            quantile(&mut self.mm, 0.9),
            mean(&self.newtons),
            quantile(&mut self.newtons, 0.5),
            percent(self.n_far, n),
            percent(self.n_missed, k * n_frames),
            percent(self.n_right, n_frames),
            percent(self.covered[0], n),
            percent(self.covered[1], n),
        );
    }
}
