//! One row of the table: frames drawn, estimated, matched one to one.

use std::time::Instant;

use anyhow::Result;
use hapdef_inverse::{
    ContactEstimate, ContactEstimator, EstimatorScratch, NoiseParams, SkinPoint, Verdict,
    joint_bounds,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::shared::{matched, mean, percent, places_apart, quantile};

/// Least distance between contacts, m.
const GAP_M: f64 = 0.012;

/// A contact that was missed counts as so far away.
const MISSED_MM: f64 = 100.0;

/// Readings per newton of the limb that is touched.
pub(crate) type Response<'a> = &'a dyn Fn(&SkinPoint) -> Result<Vec<f64>>;

#[derive(Default)]
pub(crate) struct Row {
    miss_mm: Vec<f64>,
    miss_n: Vec<f64>,
    times_us: Vec<f64>,
    n_right: usize,
    n_unsure: usize,
    /// Frames whose search ended above what a start at the truth reaches.
    n_missed: usize,
    bound_mm: Vec<f64>,
}

impl Row {
    pub(crate) const HEAD: &str = " k     count  mean mm  median     p90  in 10 mm  mean N   right  unsure   missed   bound     p90   p50 µs   p99 µs";

    pub(crate) fn frame(
        &mut self,
        estimator: &ContactEstimator,
        k: usize,
        noise: &NoiseParams,
        response: Response<'_>,
        rng: &mut ChaCha8Rng,
        (scratch, out): &mut (EstimatorScratch, ContactEstimate),
    ) -> Result<()> {
        let skin = estimator.map().skin();
        let points = places_apart(skin, k, GAP_M, rng);
        let forces: Vec<f64> = points.iter().map(|_| rng.random_range(5.0..34.0)).collect();
        let mut y = vec![0.0; estimator.map().n_gauges()];
        for (point, force_n) in points.iter().zip(&forces) {
            for (y, g) in y.iter_mut().zip(response(point)?) {
                *y += force_n * g;
            }
        }
        for (y, sd) in y.iter_mut().zip(&noise.gauge_sd) {
            let n: f64 = StandardNormal.sample(rng);
            *y += sd * n;
        }
        // the least of three runs, since other programs share the machine
        let mut least_us = f64::INFINITY;
        for _ in 0..3 {
            let start = Instant::now();
            estimator.estimate_into(&y, scratch, out)?;
            least_us = least_us.min(start.elapsed().as_secs_f64() * 1e6);
        }
        self.times_us.push(least_us);
        self.n_right += usize::from(out.contacts.len() == k);
        self.n_unsure += usize::from(matches!(out.verdict, Verdict::NotIdentifiable(_)));
        let found_misfit = (out.contacts.len(), out.chi2);
        let contacts: Vec<_> = points.iter().copied().zip(forces.iter().copied()).collect();
        if let Some(bounds) = joint_bounds(estimator, &contacts)? {
            self.bound_mm.extend(bounds.iter().map(|b| b.position_sd_m * 1e3));
        }
        let truth = contacts.iter().map(|(p, force_n)| (skin.position(p), *force_n));
        let found = out.contacts.iter().map(|c| (c.position_m, c.force_n));
        let matched = matched(truth, found)?;
        for pair in &matched.pairs {
            self.miss_mm.push(pair.position_error_m * 1e3);
            self.miss_n.push(pair.force_error_n.abs());
        }
        for missed in matched.missed {
            self.miss_mm.push(MISSED_MM);
            self.miss_n.push(forces[missed]);
        }
        estimator.refine_into(&y, &points, scratch, out)?;
        let is_worse = found_misfit.0 == out.contacts.len() && found_misfit.1 > out.chi2 + 1.0;
        self.n_missed += usize::from(is_worse);
        Ok(())
    }

    pub(crate) fn text(&mut self, n_frames: usize) -> String {
        let near = self.miss_mm.iter().filter(|&&mm| mm <= 10.0).count();
        format!(
            "{:>8.2} {:>7.2} {:>7.2} {:>8.1}% {:>7.2} {:>6.1}% {:>6.1}% {:>6.1}% {:>7.2} {:>7.2} {:>8.0} {:>8.0}",
            mean(&self.miss_mm),
            quantile(&mut self.miss_mm, 0.5),
            quantile(&mut self.miss_mm, 0.9),
            percent(near, self.miss_mm.len()),
            mean(&self.miss_n),
            percent(self.n_right, n_frames),
            percent(self.n_unsure, n_frames),
            percent(self.n_missed, n_frames),
            quantile(&mut self.bound_mm, 0.5),
            quantile(&mut self.bound_mm, 0.9),
            quantile(&mut self.times_us, 0.5),
            quantile(&mut self.times_us, 0.99),
        )
    }
}
