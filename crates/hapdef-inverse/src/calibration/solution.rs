//! All gauges solved together on some of the presses, and each press as if it were left out.

use crate::calibration::kernel::Kernel;
use crate::calibration::mode_fit::{ModeFit, fit_modes, quadratic_form};
use crate::calibration::residual::{GaugeFit, Wanted, fit_gauge};
use crate::calibration::samples::Samples;
use crate::error::InverseError;

/// What stays the same over all solutions of one calibration.
pub(crate) struct Problem<'a> {
    pub(crate) samples: &'a Samples,
    /// Columns with a coefficient for each gauge.
    pub(crate) n_own: usize,
    /// Mean squares of the map over the skin `[n_gauges]`.
    pub(crate) mean_squares: &'a [f64],
    pub(crate) n_threads: usize,
}

pub(crate) struct Solution {
    pub(crate) rows: Vec<usize>,
    pub(crate) fits: Vec<GaugeFit>,
    pub(crate) modes: ModeFit,
}

/// Errors of left-out presses for one gauge `[n]`.
pub(crate) struct LeftOut {
    pub(crate) error: Vec<f64>,
    /// Variance of the error, noise included.
    pub(crate) variance: Vec<f64>,
}

impl Problem<'_> {
    /// Solves for the presses `rows` of the samples.
    ///
    /// # Errors
    /// [`InverseError::NotPositiveDefinite`] when rounding spoils a covariance.
    pub(crate) fn solve(
        &self,
        rows: &[usize],
        kernels: &[Kernel],
        wanted: Wanted<'_>,
    ) -> Result<Solution, InverseError> {
        let fits = by_gauge(self.samples.n_gauges(), self.n_threads, |gauge| {
            let mean_square = self.mean_squares[gauge];
            fit_gauge(self.samples, gauge, rows, &kernels[gauge], mean_square, wanted)
        });
        let fits: Option<Vec<_>> = fits.into_iter().collect();
        let fits = fits
            .ok_or(InverseError::NotPositiveDefinite { what: "the covariance of the presses" })?;
        Ok(Solution { rows: rows.to_vec(), modes: fit_modes(&fits, self.n_own)?, fits })
    }
}

impl Solution {
    /// C⁻¹ (y − H θ) of one gauge `[n]`.
    pub(crate) fn alpha(&self, gauge: usize) -> Vec<f64> {
        let fit = &self.fits[gauge];
        let mut alpha = fit.alpha_y.clone();
        for (theta, h) in self.modes.theta[gauge].iter().zip(&fit.alpha_h) {
            alpha.iter_mut().zip(h).for_each(|(a, h)| *a -= theta * h);
        }
        alpha
    }

    /// Leave-one-out errors in closed form (Rasmussen & Williams 2006, equation 5.12) of the process
    /// with the modes' coefficients uncertain.
    pub(crate) fn left_out(&self, gauge: usize) -> LeftOut {
        let (fit, alpha) = (&self.fits[gauge], self.alpha(gauge));
        let n_columns = fit.rhs.len();
        let mut out = LeftOut {
            error: Vec::with_capacity(alpha.len()),
            variance: Vec::with_capacity(alpha.len()),
        };
        for i in 0..alpha.len() {
            let w: Vec<f64> = (0..n_columns).map(|c| fit.alpha_h[c][i]).collect();
            let explained = quadratic_form(&self.modes.covariance[gauge], &w);
            let precision = fit.inverse_diagonal[i];
            let precision = (precision - explained).max(1e-3 * precision);
            out.error.push(alpha[i] / precision);
            out.variance.push(1.0 / precision);
        }
        out
    }
}

/// `f` of every gauge, in order, on `n_threads` threads.
pub(crate) fn by_gauge<T: Send>(
    n_gauges: usize,
    n_threads: usize,
    f: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let mut results: Vec<Option<T>> = (0..n_gauges).map(|_| None).collect();
    let next = std::sync::Mutex::new(results.iter_mut().enumerate());
    std::thread::scope(|scope| {
        for _ in 0..n_threads.min(n_gauges) {
            scope.spawn(|| {
                loop {
                    let taken = next.lock().map_or(None, |mut queue| queue.next());
                    let Some((gauge, result)) = taken else {
                        break;
                    };
                    *result = Some(f(gauge));
                }
            });
        }
    });
    results.into_iter().flatten().collect()
}
