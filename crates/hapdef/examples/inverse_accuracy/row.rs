//! One row of the table: frames drawn, estimated, matched one to one.

use std::time::Instant;

use anyhow::Result;
use hapdef_inverse::{
    ContactEstimate, ContactEstimator, EstimatorScratch, NoiseParams, Skin, SkinPoint, Verdict,
    joint_bounds,
};
use nalgebra::Point3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

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
        let (points, forces) = draw(skin, k, rng);
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
            self.bound_mm
                .extend(bounds.iter().map(|b| b.position_sd_m * 1e3));
        }
        let truth: Vec<_> = points.iter().map(|p| skin.position(p)).collect();
        let found: Vec<_> = out.contacts.iter().map(|c| c.position_m).collect();
        let pairs = matched(&truth, &found, &mut vec![false; found.len()]).1;
        for (i, pair) in pairs.into_iter().enumerate() {
            let (mm, newtons) = pair.map_or((100.0, forces[i]), |j| {
                let miss_n = (forces[i] - out.contacts[j].force_n).abs();
                ((truth[i] - found[j]).norm() * 1e3, miss_n)
            });
            self.miss_mm.push(mm);
            self.miss_n.push(newtons);
        }
        estimator.refine_into(&y, &points, scratch, out)?;
        let is_worse = found_misfit.0 == out.contacts.len() && found_misfit.1 > out.chi2 + 1.0;
        self.n_missed += usize::from(is_worse);
        Ok(())
    }

    pub(crate) fn text(&mut self, n_frames: usize) -> String {
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len().max(1) as f64;
        let near = self.miss_mm.iter().filter(|&&mm| mm <= 10.0).count();
        let percent = |n: usize, of: usize| n as f64 / of.max(1) as f64 * 100.0;
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

fn draw(skin: &Skin, k: usize, rng: &mut ChaCha8Rng) -> (Vec<SkinPoint>, Vec<f64>) {
    let mut points: Vec<SkinPoint> = Vec::new();
    while points.len() < k {
        let face = rng.random_range(0..skin.n_faces());
        let (a, b): (f64, f64) = (rng.random(), rng.random());
        let (a, b) = if a + b > 1.0 {
            (1.0 - a, 1.0 - b)
        } else {
            (a, b)
        };
        let Ok(point) = SkinPoint::new(skin, face, [1.0 - a - b, a, b]) else {
            continue;
        };
        let x = skin.position(&point);
        if points
            .iter()
            .all(|p| (skin.position(p) - x).norm() >= 0.012)
        {
            points.push(point);
        }
    }
    let forces = points.iter().map(|_| rng.random_range(5.0..34.0)).collect();
    (points, forces)
}

/// The one-to-one matching with the least summed distance; a contact without a match costs 10 m.
fn matched(
    truth: &[Point3<f64>],
    found: &[Point3<f64>],
    used: &mut Vec<bool>,
) -> (f64, Vec<Option<usize>>) {
    let Some((first, rest)) = truth.split_first() else {
        return (0.0, Vec::new());
    };
    let (cost, after) = matched(rest, found, used);
    let mut best = (cost + 10.0, None, after);
    for j in 0..found.len() {
        if used[j] {
            continue;
        }
        used[j] = true;
        let (cost, after) = matched(rest, found, used);
        used[j] = false;
        let cost = cost + (first - found[j]).norm();
        if cost < best.0 {
            best = (cost, Some(j), after);
        }
    }
    let (cost, pair, after) = best;
    (cost, std::iter::once(pair).chain(after).collect())
}

fn quantile(values: &mut [f64], q: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1) as f64;
    let place = (last * q).round() as usize;
    values.get(place).copied().unwrap_or(f64::NAN)
}
