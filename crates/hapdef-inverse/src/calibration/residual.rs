//! One gauge's Gaussian process: the whitened problem, leave-one-out parts, variances at places.

use crate::calibration::factor::{Trapezoid, dot};
use crate::calibration::kernel::{Amplitude, Kernel};
use crate::calibration::samples::{Places, Samples};

/// What one gauge's presses say, before the modes' coefficients are known.
pub(crate) struct GaugeFit {
    /// C⁻¹ y `[n]`.
    pub(crate) alpha_y: Vec<f64>,
    /// C⁻¹ h for every column `[n_columns][n]`.
    pub(crate) alpha_h: Vec<Vec<f64>>,
    /// Diagonal of C⁻¹ `[n]`.
    pub(crate) inverse_diagonal: Vec<f64>,
    /// Hᵀ C⁻¹ H `[n_columns, n_columns]`.
    pub(crate) gram: Vec<f64>,
    /// Hᵀ C⁻¹ y `[n_columns]`.
    pub(crate) rhs: Vec<f64>,
    /// Errors of the presses after the first `cut` as predicted from those: of y and of each column.
    pub(crate) cuts: Vec<CutErrors>,
    pub(crate) at_sites: Option<AtSites>,
}

pub(crate) struct CutErrors {
    pub(crate) cut: usize,
    pub(crate) of_y: Vec<f64>,
    pub(crate) of_columns: Vec<Vec<f64>>,
}

/// What of a fit is wanted beside the coefficients.
#[derive(Clone, Copy, Default)]
pub(crate) struct Wanted<'a> {
    /// What is known at these scan sites.
    pub(crate) sites: Option<&'a Places>,
    /// Their covariance, too: half of the time of a fit.
    pub(crate) has_covariance: bool,
    /// See [`GaugeFit::cuts`].
    pub(crate) cuts: &'a [usize],
}

/// What is known at the scan sites.
pub(crate) struct AtSites {
    /// Variance of the process given the presses `[n_sites]`.
    pub(crate) variance: Vec<f64>,
    /// Columns less what the presses predict of them `[n_sites, n_columns]`.
    pub(crate) columns: Vec<f64>,
    /// Covariance of the process given the presses `[n_sites, n_sites]`, lower half; empty where it isn't wanted.
    pub(crate) covariance: Vec<f64>,
}

/// L of the presses `rows`, and below it, solved along, y, the modes' columns and the covariances
/// with the sites.
fn factored(
    samples: &Samples,
    gauge: usize,
    rows: &[usize],
    kernel: &Kernel,
    sites: Option<&Places>,
    mean_square: f64,
) -> Option<Trapezoid> {
    let places = &samples.places;
    let (n, m) = (rows.len(), samples.n_gauges());
    let n_columns = places.n_columns;
    let n_sites = sites.map_or(0, |s| s.points.len());
    let mut t = Trapezoid::zeros(n, n + 1 + n_columns + n_sites);
    let amplitude = |of: &Places, i: usize| kernel.amplitude(of.around(i, gauge), mean_square);
    let sizes: Vec<Amplitude> = rows.iter().map(|&i| amplitude(places, i)).collect();
    let at: Vec<_> = rows.iter().map(|&i| places.positions[i]).collect();
    for a in 0..n {
        let row = t.row_mut(a);
        for b in 0..a {
            row[b] = kernel.covariance(sizes[a], sizes[b], (at[a] - at[b]).norm_squared());
        }
        row[a] = Kernel::variance(sizes[a]) * (1.0 + 1e-8) + samples.noise[rows[a] * m + gauge];
    }
    for (a, &i) in rows.iter().enumerate() {
        t.row_mut(n)[a] = samples.residual[i * m + gauge];
        for (c, h) in places.columns_of(i, gauge).iter().enumerate() {
            t.row_mut(n + 1 + c)[a] = *h;
        }
    }
    if let Some(sites) = sites {
        for s in 0..n_sites {
            let size = amplitude(sites, s);
            let x = sites.positions[s];
            let row = t.row_mut(n + 1 + n_columns + s);
            for b in 0..n {
                row[b] = kernel.covariance(size, sizes[b], (x - at[b]).norm_squared());
            }
        }
    }
    t.factor().then_some(t)
}

/// ln of the evidence of one gauge's presses, its modes' coefficients integrated out (Rasmussen &
/// Williams 2006, equation 2.43); `None` if rounding spoils it.
pub(crate) fn log_evidence(
    samples: &Samples,
    gauge: usize,
    rows: &[usize],
    kernel: &Kernel,
    mean_square: f64,
) -> Option<f64> {
    let t = factored(samples, gauge, rows, kernel, None, mean_square)?;
    let (gram, rhs) = normal_equations(&t, samples.places.n_columns);
    let n_columns = rhs.len();
    let mut l = gram;
    (0..n_columns).for_each(|i| l[i * n_columns + i] += 1.0);
    if !crate::dense::cholesky(&mut l, n_columns, 0.0) {
        return None;
    }
    let mut w = rhs;
    crate::dense::solve_lower(&l, n_columns, &mut w);
    let y = t.row(t.n);
    let misfit = dot(y, y) - w.iter().map(|w| w * w).sum::<f64>();
    Some(-0.5 * (misfit + t.log_det() + crate::dense::log_det(&l, n_columns)))
}

/// Everything about one gauge; `None` if rounding spoils it.
pub(crate) fn fit_gauge(
    samples: &Samples,
    gauge: usize,
    rows: &[usize],
    kernel: &Kernel,
    mean_square: f64,
    wanted: Wanted<'_>,
) -> Option<GaugeFit> {
    let t = factored(samples, gauge, rows, kernel, wanted.sites, mean_square)?;
    let n_columns = samples.places.n_columns;
    let (gram, rhs) = normal_equations(&t, n_columns);
    let solved = |row: usize| {
        let mut x = t.row(row).to_vec();
        t.solve_upper(&mut x);
        x
    };
    let m = samples.n_gauges();
    let y: Vec<f64> = rows.iter().map(|&i| samples.residual[i * m + gauge]).collect();
    let column = |c: usize| -> Vec<f64> {
        rows.iter().map(|&i| samples.places.columns_of(i, gauge)[c]).collect()
    };
    let cut_errors = |&cut: &usize| CutErrors {
        cut,
        of_y: after_cut(&t, cut, t.n, &y),
        of_columns: (0..n_columns).map(|c| after_cut(&t, cut, t.n + 1 + c, &column(c))).collect(),
    };
    Some(GaugeFit {
        alpha_y: solved(t.n),
        alpha_h: (0..n_columns).map(|c| solved(t.n + 1 + c)).collect(),
        inverse_diagonal: t.inverse_diagonal(),
        cuts: wanted.cuts.iter().map(cut_errors).collect(),
        at_sites: wanted
            .sites
            .map(|s| at_sites(&t, s, gauge, kernel, mean_square, wanted.has_covariance)),
        gram,
        rhs,
    })
}

fn normal_equations(t: &Trapezoid, n_columns: usize) -> (Vec<f64>, Vec<f64>) {
    let column = |c: usize| t.row(t.n + 1 + c);
    let mut gram = vec![0.0; n_columns * n_columns];
    for a in 0..n_columns {
        for b in 0..=a {
            let product = dot(column(a), column(b));
            gram[a * n_columns + b] = product;
            gram[b * n_columns + a] = product;
        }
    }
    let rhs = (0..n_columns).map(|c| dot(column(c), t.row(t.n))).collect();
    (gram, rhs)
}

/// Values after the first `cut` less what those say: the leading block of L is the factor of the
/// first presses alone.
fn after_cut(t: &Trapezoid, cut: usize, row: usize, values: &[f64]) -> Vec<f64> {
    let whitened = &t.row(row)[..cut];
    (cut..t.n).map(|i| values[i] - dot(&t.row(i)[..cut], whitened)).collect()
}

fn at_sites(
    t: &Trapezoid,
    sites: &Places,
    gauge: usize,
    kernel: &Kernel,
    mean_square: f64,
    has_covariance: bool,
) -> AtSites {
    let (n_sites, n_columns) = (sites.points.len(), sites.n_columns);
    let row = |s: usize| t.row(t.n + 1 + n_columns + s);
    let size = |s: usize| kernel.amplitude(sites.around(s, gauge), mean_square);
    let covariance_of = |s: usize, r: usize| {
        let d_2 = (sites.positions[s] - sites.positions[r]).norm_squared();
        kernel.covariance(size(s), size(r), d_2) - dot(row(s), row(r))
    };
    let mut covariance = Vec::new();
    if has_covariance {
        covariance.resize(n_sites * n_sites, 0.0);
        for s in 0..n_sites {
            (0..=s).for_each(|r| covariance[s * n_sites + r] = covariance_of(s, r));
        }
    }
    let mut columns = Vec::with_capacity(n_sites * n_columns);
    for s in 0..n_sites {
        let predicted = |c: usize| dot(row(s), t.row(t.n + 1 + c));
        let here = sites.columns_of(s, gauge).iter().enumerate();
        columns.extend(here.map(|(c, h)| h - predicted(c)));
    }
    let variance = (0..n_sites).map(|s| covariance_of(s, s).max(0.0)).collect();
    AtSites { variance, columns, covariance }
}
