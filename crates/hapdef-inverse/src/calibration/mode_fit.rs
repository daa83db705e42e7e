//! The modes' coefficients, from all gauges together.

use crate::calibration::residual::GaugeFit;
use crate::dense::{cholesky, inverse, solve_lower, solve_upper};
use crate::error::InverseError;

/// Scaled coefficients: mean and covariance.
pub(crate) struct ModeFit {
    /// `[n_gauges][n_columns]`; the shared ones are the same for all gauges.
    pub(crate) theta: Vec<Vec<f64>>,
    /// Covariance of each gauge's columns `[n_gauges][n_columns, n_columns]`.
    pub(crate) covariance: Vec<Vec<f64>>,
}

/// θ = (1 + Σ Hᵀ C⁻¹ H)⁻¹ Σ Hᵀ C⁻¹ y (Rasmussen & Williams 2006, equation 2.42 with B = 1), where
/// the first `n_own` columns belong to one gauge and the others to all.
pub(crate) fn fit_modes(fits: &[GaugeFit], n_own: usize) -> Result<ModeFit, InverseError> {
    let n_columns = fits.first().map_or(0, |fit| fit.rhs.len());
    let n = fits.len() * n_own + n_columns - n_own;
    let place = |gauge: usize, c: usize| {
        if c < n_own { gauge * n_own + c } else { fits.len() * n_own + c - n_own }
    };
    let (mut a, mut theta) = (vec![0.0; n * n], vec![0.0; n]);
    (0..n).for_each(|i| a[i * n + i] = 1.0);
    for (gauge, fit) in fits.iter().enumerate() {
        for p in 0..n_columns {
            theta[place(gauge, p)] += fit.rhs[p];
            for q in 0..n_columns {
                a[place(gauge, p) * n + place(gauge, q)] += fit.gram[p * n_columns + q];
            }
        }
    }
    if !cholesky(&mut a, n, 0.0) {
        let what = "the information of the calibration's modes";
        return Err(InverseError::NotPositiveDefinite { what });
    }
    solve_lower(&a, n, &mut theta);
    solve_upper(&a, n, &mut theta);
    let mut covariance = vec![0.0; n * n];
    inverse(&a, n, &mut covariance);
    let of_gauge = |gauge: usize| -> Vec<f64> {
        let pairs = (0..n_columns * n_columns).map(|i| (i / n_columns, i % n_columns));
        pairs.map(|(p, q)| covariance[place(gauge, p) * n + place(gauge, q)]).collect()
    };
    let theta_of =
        |gauge: usize| (0..n_columns).map(|c| theta[place(gauge, c)]).collect::<Vec<_>>();
    Ok(ModeFit {
        theta: (0..fits.len()).map(theta_of).collect(),
        covariance: (0..fits.len()).map(of_gauge).collect(),
    })
}

/// uᵀ Σ u.
pub(crate) fn quadratic_form(covariance: &[f64], u: &[f64]) -> f64 {
    let rows = covariance.chunks_exact(u.len().max(1));
    rows.zip(u).map(|(row, a)| a * row.iter().zip(u).map(|(c, b)| c * b).sum::<f64>()).sum()
}
