//! Error measures of deformation maps and of contacts, accumulated row by row.

use crate::error::{ReproError, check_len, whole_rows};

/// Running error of predicted maps against true ones, in f64 and in the order of the calls.
#[derive(Clone, Debug)]
pub struct MapScore {
    n_samples: usize,
    abs_sum_m: f64,
    square_sum_m2: f64,
    /// Running mean and Σ(y − mean)² of each node's true value (Welford 1962).
    node_mean_m: Vec<f64>,
    node_spread_m2: Vec<f64>,
}

/// What [`MapScore::info`] reports. NaN predictions give NaN errors.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct MapScoreInfo {
    /// Samples scored.
    pub n_samples: usize,
    /// Nodes of each map.
    pub n_nodes: usize,
    /// Mean of |ŷ − y| over all nodes and samples, m; the "displacement error" of Table 1.
    pub mean_abs_m: f64,
    /// Root of the mean of (ŷ − y)² over all nodes and samples, m.
    pub rms_m: f64,
    /// Fraction of variance unexplained: Σ(y − ŷ)² / Σ(y − ȳ)² over all nodes and samples, with
    /// ȳ each node's own mean over the samples scored. NaN if no node varies.
    pub fvu: f64,
}

impl MapScore {
    /// Nothing scored yet, maps of `n_nodes` values.
    #[must_use]
    pub fn new(n_nodes: usize) -> Self {
        Self {
            n_samples: 0,
            abs_sum_m: 0.0,
            square_sum_m2: 0.0,
            node_mean_m: vec![0.0; n_nodes],
            node_spread_m2: vec![0.0; n_nodes],
        }
    }

    /// Scores a block of maps: `predicted_m` and `true_m`, both `[rows, n_nodes]`, row-major, m.
    ///
    /// # Errors
    /// Lengths that are not whole rows or differ.
    pub fn add_block(&mut self, predicted_m: &[f32], true_m: &[f32]) -> Result<(), ReproError> {
        let width = self.node_mean_m.len();
        whole_rows("true maps", width, true_m.len())?;
        check_len("predicted maps", true_m.len(), predicted_m.len())?;
        for (predicted, truth) in predicted_m
            .chunks_exact(width)
            .zip(true_m.chunks_exact(width))
        {
            self.add_row(predicted, truth);
        }
        Ok(())
    }

    fn add_row(&mut self, predicted: &[f32], truth: &[f32]) {
        self.n_samples += 1;
        let n = self.n_samples as f64;
        let (mut abs, mut square) = (0.0, 0.0);
        for (node, (p, y)) in predicted.iter().zip(truth).enumerate() {
            let y = f64::from(*y);
            let e = f64::from(*p) - y;
            abs += e.abs();
            square += e * e;
            let d = y - self.node_mean_m[node];
            self.node_mean_m[node] += d / n;
            self.node_spread_m2[node] += d * (y - self.node_mean_m[node]);
        }
        self.abs_sum_m += abs;
        self.square_sum_m2 += square;
    }

    /// The error over all blocks so far.
    ///
    /// # Errors
    /// Nothing scored yet.
    pub fn info(&self) -> Result<MapScoreInfo, ReproError> {
        let n_nodes = self.node_mean_m.len();
        if self.n_samples == 0 {
            return Err(ReproError::TooFewSamples {
                what: "map score",
                needed: 1,
                found: 0,
            });
        }
        let n = self.n_samples as f64 * n_nodes as f64;
        let spread: f64 = self.node_spread_m2.iter().sum();
        Ok(MapScoreInfo {
            n_samples: self.n_samples,
            n_nodes,
            mean_abs_m: self.abs_sum_m / n,
            rms_m: (self.square_sum_m2 / n).sqrt(),
            fvu: if spread > 0.0 {
                self.square_sum_m2 / spread
            } else {
                f64::NAN
            },
        })
    }
}

/// Position and force errors of many contacts.
#[derive(Clone, Debug, Default)]
pub struct ContactScore {
    position_m: Vec<f64>,
    force_n: Vec<f64>,
}

/// What [`ContactScore::info`] reports.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ContactScoreInfo {
    /// Contacts scored.
    pub n_contacts: usize,
    /// Mean position error, m.
    pub position_mean_m: f64,
    /// Median position error, m.
    pub position_median_m: f64,
    /// 90th percentile of the position error, m.
    pub position_p90_m: f64,
    /// Share of contacts with a position error above 10 mm, in [0, 1].
    pub share_above_10_mm: f64,
    /// Mean |force error|, N.
    pub force_mean_n: f64,
    /// Median |force error|, N.
    pub force_median_n: f64,
    /// 90th percentile of |force error|, N.
    pub force_p90_n: f64,
}

impl ContactScore {
    /// Adds one contact's errors: the distance between found and true position, m, and the
    /// found minus the true force (of either sign), N.
    ///
    /// # Errors
    /// A value that is not finite, or a negative distance; nothing is added then.
    pub fn add(&mut self, position_error_m: f64, force_error_n: f64) -> Result<(), ReproError> {
        let index = self.position_m.len();
        for (what, value) in [
            ("contact position error", position_error_m),
            ("contact force error", force_error_n),
        ] {
            if !value.is_finite() {
                return Err(ReproError::NotFinite { what, index, value });
            }
        }
        if position_error_m < 0.0 {
            return Err(ReproError::Parameter {
                what: "contact position error",
                value: position_error_m,
                expected: "at least 0",
            });
        }
        self.position_m.push(position_error_m);
        self.force_n.push(force_error_n.abs());
        Ok(())
    }

    /// The errors so far. Percentiles interpolate linearly between order statistics (type 7 of
    /// Hyndman & Fan, The American Statistician 50:361, 1996).
    ///
    /// # Errors
    /// Nothing added yet.
    pub fn info(&self) -> Result<ContactScoreInfo, ReproError> {
        let n = self.position_m.len();
        if n == 0 {
            return Err(ReproError::TooFewSamples {
                what: "contact score",
                needed: 1,
                found: 0,
            });
        }
        let (position, force) = (sorted(&self.position_m), sorted(&self.force_n));
        let above = position.iter().filter(|e| **e > 0.01).count();
        Ok(ContactScoreInfo {
            n_contacts: n,
            position_mean_m: self.position_m.iter().sum::<f64>() / n as f64,
            position_median_m: quantile(&position, 0.5),
            position_p90_m: quantile(&position, 0.9),
            share_above_10_mm: above as f64 / n as f64,
            force_mean_n: self.force_n.iter().sum::<f64>() / n as f64,
            force_median_n: quantile(&force, 0.5),
            force_p90_n: quantile(&force, 0.9),
        })
    }
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted
}

/// `sorted` is not empty.
fn quantile(sorted: &[f64], q: f64) -> f64 {
    let at = q * (sorted.len() - 1) as f64;
    let below = at.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (at - below as f64) * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Two samples of two nodes; errors 1, 0, 0, −2; node means 2 and 6, spreads 2 and 8.
    #[test]
    fn maps_by_hand() {
        let mut score = MapScore::new(2);
        score.add_block(&[2.0, 4.0], &[1.0, 4.0]).unwrap();
        score.add_block(&[3.0, 6.0], &[3.0, 8.0]).unwrap();
        let info = score.info().unwrap();
        assert_eq!((info.n_samples, info.n_nodes), (2, 2));
        assert!((info.mean_abs_m - 0.75).abs() < 1e-15, "{info:?}");
        assert!((info.rms_m - 1.25_f64.sqrt()).abs() < 1e-15, "{info:?}");
        assert!((info.fvu - 0.5).abs() < 1e-15, "{info:?}");
    }

    #[test]
    fn predicting_each_nodes_mean_leaves_all_variance() {
        let truth = [1.0, 1000.0, 3.0, 1010.0, 8.0, 1020.0];
        let mean = [4.0, 1010.0].repeat(3);
        let mut score = MapScore::new(2);
        score.add_block(&mean, &truth).unwrap();
        let info = score.info().unwrap();
        assert!((info.fvu - 1.0).abs() < 1e-12, "{info:?}");
    }

    #[test]
    fn nan_predictions_and_flat_truths_are_not_hidden() {
        let mut score = MapScore::new(1);
        score.add_block(&[f32::NAN, 1.0], &[1.0, 2.0]).unwrap();
        assert!(score.info().unwrap().mean_abs_m.is_nan());
        let mut flat = MapScore::new(1);
        flat.add_block(&[1.0, 1.0], &[2.0, 2.0]).unwrap();
        assert!(flat.info().unwrap().fvu.is_nan());
        assert!(MapScore::new(3).info().is_err());
        assert!(matches!(
            flat.add_block(&[1.0], &[]),
            Err(ReproError::Shape { .. })
        ));
        assert!(ContactScore::default().info().is_err());
        assert!(ContactScore::default().add(f64::NAN, 0.0).is_err());
        assert!(ContactScore::default().add(-1.0, 0.0).is_err());
    }

    /// Errors 0…10 mm: median 5, 90th percentile 9; one of eleven lies above 10 mm by a hair.
    #[test]
    fn contacts_by_hand() {
        let mut score = ContactScore::default();
        for i in (0..10).rev() {
            score.add(f64::from(i) * 1e-3, -f64::from(i)).unwrap();
        }
        score.add(0.010_001, 10.0).unwrap();
        let info = score.info().unwrap();
        assert!((info.position_median_m - 5e-3).abs() < 1e-15, "{info:?}");
        assert!((info.position_p90_m - 9e-3).abs() < 1e-15, "{info:?}");
        assert!(
            (info.share_above_10_mm - 1.0 / 11.0).abs() < 1e-15,
            "{info:?}"
        );
        assert!((info.force_mean_n - 5.0).abs() < 1e-12, "{info:?}");
        assert!((info.force_p90_n - 9.0).abs() < 1e-12, "{info:?}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Streaming equals the two-pass formulas, however the rows are cut into blocks.
        #[test]
        fn streaming_equals_two_passes(
            rows in prop::collection::vec(prop::array::uniform6(-1e-3f32..1e-3), 2..20),
            cut in 0usize..20,
        ) {
            let truth: Vec<f32> = rows.iter().flat_map(|r| r[..3].to_vec()).collect();
            let predicted: Vec<f32> = rows.iter().flat_map(|r| r[3..].to_vec()).collect();
            let cut = 3 * cut.min(rows.len());
            let mut score = MapScore::new(3);
            score.add_block(&predicted[..cut], &truth[..cut]).unwrap();
            score.add_block(&predicted[cut..], &truth[cut..]).unwrap();
            let info = score.info().unwrap();
            let n = rows.len() as f64;
            let (mut abs, mut square, mut spread) = (0.0, 0.0, 0.0);
            for j in 0..3 {
                let mean = rows.iter().map(|r| f64::from(r[j])).sum::<f64>() / n;
                for r in &rows {
                    let (y, p) = (f64::from(r[j]), f64::from(r[j + 3]));
                    abs += (p - y).abs();
                    square += (p - y).powi(2);
                    spread += (y - mean).powi(2);
                }
            }
            prop_assert!((info.mean_abs_m - abs / n / 3.0).abs() <= 1e-12 * abs);
            prop_assert!((info.rms_m - (square / n / 3.0).sqrt()).abs() <= 1e-12 * abs);
            prop_assert!((info.fvu - square / spread).abs() <= 1e-9 * info.fvu);
        }
    }
}
