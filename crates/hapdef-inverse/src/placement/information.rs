//! What gauges say of one contact at each site, whatever the loads are that are no contacts.

use crate::placement::{Candidates, PlacementParams};

/// Information of the gauges taken so far on one contact at every site, beside loads that are no contacts.
///
/// Contact and loads are unknowns of one least-squares problem, each in units of its prior: M = 1 + Σ j jᵀ, j what a
/// gauge reads for one of each over its noise, the three of the contact first. The contact's own information, the
/// loads marginalised, is the Schur complement of their block L of M, so that its ln det is ln det M − ln det L (Boyd
/// and Vandenberghe, Convex Optimization, 2004, appendix A.5.5).
pub(crate) struct Information<'a> {
    candidates: &'a Candidates,
    params: &'a PlacementParams,
    /// M⁻¹ of every site `[n_sites, n, n]`, n = 3 + n_loads.
    inverses: Vec<f64>,
    /// L⁻¹ `[n_loads, n_loads]`, the same for every site.
    of_loads: Vec<f64>,
}

impl<'a> Information<'a> {
    /// Of the gauges `taken`.
    pub(crate) fn of(
        candidates: &'a Candidates,
        params: &'a PlacementParams,
        taken: &[usize],
    ) -> Self {
        let n_loads = candidates.n_loads();
        let mut information = Self {
            candidates,
            params,
            inverses: unit(3 + n_loads).repeat(candidates.n_sites()),
            of_loads: unit(n_loads),
        };
        taken.iter().for_each(|&c| information.take(c));
        information
    }

    /// Mean over the sites of what candidate `c` adds to the ln det of the contact's information.
    pub(crate) fn gain(&self, c: usize) -> f64 {
        let n = 3 + self.candidates.n_loads();
        let (mut j, mut v) = (vec![0.0; n], vec![0.0; n]);
        let mut sum = 0.0;
        for (site, inverse) in self.inverses.chunks_exact(n * n).enumerate() {
            self.candidates.unknowns(c, &[site], self.params, &mut j);
            sum += times(inverse, &j, &mut v).ln_1p();
        }
        // ln det (M + j jᵀ) − ln det M = ln (1 + jᵀ M⁻¹ j), and so of L
        let of_loads = times(&self.of_loads, &j[3..], &mut v[3..]).ln_1p();
        sum / self.candidates.n_sites() as f64 - of_loads
    }

    /// Adds a gauge.
    pub(crate) fn take(&mut self, c: usize) {
        let n = 3 + self.candidates.n_loads();
        let (mut j, mut v) = (vec![0.0; n], vec![0.0; n]);
        for (site, inverse) in self.inverses.chunks_exact_mut(n * n).enumerate() {
            self.candidates.unknowns(c, &[site], self.params, &mut j);
            add(inverse, &j, &mut v);
        }
        add(&mut self.of_loads, &j[3..], &mut v[3..]);
    }
}

/// The unit matrix `[n, n]`.
pub(crate) fn unit(n: usize) -> Vec<f64> {
    let mut matrix = vec![0.0; n * n];
    (0..n).for_each(|i| matrix[i * n + i] = 1.0);
    matrix
}

/// v = M j of a matrix `[n, n]`; returns jᵀ M j.
fn times(matrix: &[f64], j: &[f64], v: &mut [f64]) -> f64 {
    let mut product = 0.0;
    for ((row, v), own) in matrix.chunks_exact(j.len().max(1)).zip(&mut *v).zip(j) {
        *v = row.iter().zip(j).map(|(m, j)| m * j).sum();
        product += own * *v;
    }
    product
}

/// The inverse of M with j jᵀ more: M⁻¹ less M⁻¹ j jᵀ M⁻¹ / (1 + jᵀ M⁻¹ j) (Sherman and Morrison 1950).
fn add(inverse: &mut [f64], j: &[f64], v: &mut [f64]) {
    let scale = 1.0 / (1.0 + times(inverse, j, v));
    for (row, of_row) in inverse.chunks_exact_mut(j.len().max(1)).zip(&*v) {
        row.iter_mut().zip(&*v).for_each(|(m, v)| *m -= scale * of_row * v);
    }
}
