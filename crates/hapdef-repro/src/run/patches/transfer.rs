//! F_T by the three methods that figure 5A compares.

use anyhow::Result;
use hapdef_data::{Standardiser, StandardiserFit};
use hapdef_nets::Net;
use hapdef_repro::{Knn, KnnParams, LinearRegression};

use super::super::chain::forward;

/// From readings to virtual gauges.
pub(super) enum Transfer {
    Linear(LinearRegression),
    Nearest { knn: Knn, standardiser: Standardiser, y: Vec<f32>, width: usize },
    Net(Net),
}

impl Transfer {
    /// k nearest presses by standardised readings, k = 6, weights 1/distance.
    pub(super) fn nearest(x: &[f32], y: Vec<f32>, n_gauges: usize) -> Result<Self> {
        let mut fit = StandardiserFit::new(n_gauges);
        fit.push(x)?;
        let (standardiser, _) = fit.finish()?;
        let mut x = x.to_vec();
        standardiser.apply(&mut x)?;
        Ok(Self::Nearest {
            width: y.len() / (x.len() / n_gauges),
            knn: Knn::new(&x, n_gauges)?,
            standardiser,
            y,
        })
    }

    /// Virtual gauges, `[n, n_virtual]`, µm, of readings, `[n, n_gauges]`, µε.
    pub(super) fn predict(&self, readings: &[f32]) -> Result<Vec<f32>> {
        match self {
            Self::Net(net) => forward(net, readings),
            Self::Linear(linear) => {
                let n = readings.len() / linear.n_inputs();
                let mut out = vec![0.0; n * linear.n_outputs()];
                linear.predict(readings, &mut out)?;
                Ok(out)
            }
            Self::Nearest { knn, standardiser, y, width } => {
                let mut x = readings.to_vec();
                standardiser.apply(&mut x)?;
                let found = knn.neighbours(&x, &KnnParams::default())?;
                let mut out = vec![0.0; found.n_queries() * width];
                for (query, out) in out.chunks_exact_mut(*width).enumerate() {
                    let fetch = |row: usize, buffer: &mut [f32]| {
                        buffer.copy_from_slice(&y[row * width..(row + 1) * width]);
                        Ok::<(), std::convert::Infallible>(())
                    };
                    found.predict(query, fetch, out)?;
                }
                Ok(out)
            }
        }
    }
}
