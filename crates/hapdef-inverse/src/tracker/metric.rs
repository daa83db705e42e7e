//! Forces and residual of a frame for contacts whose places are known: the path of every frame.

use crate::dense::{add_scaled, cholesky, dot, log_det, solve_lower, solve_upper};
use crate::estimator::MAX_CONTACTS;
use crate::estimator::non_negative;

const SIZE: usize = MAX_CONTACTS * MAX_CONTACTS;

/// The covariance S of a frame, and the contacts' atoms whitened by it.
#[derive(Clone, Debug)]
pub(super) struct Metric {
    pub(super) m: usize,
    width: usize,
    /// L of S = L Lᵀ `[m, m]`.
    pub(super) l: Vec<f64>,
    /// L⁻¹ h `[MAX_CONTACTS, width]`.
    atoms: Vec<f64>,
    n: usize,
    gram: [f64; SIZE],
    /// Of `gram`; what `is_definite` says it is.
    factor: [f64; SIZE],
    is_definite: bool,
    /// The last frame's residual, whitened `[width]`.
    pub(super) r: Vec<f64>,
    pub(super) log_det: f64,
}

/// Forces of a frame, 0 or more, and its χ².
#[derive(Clone, Copy, Debug)]
pub(super) struct Solved {
    pub(super) forces: [f64; MAX_CONTACTS],
    pub(super) chi2: f64,
}

impl Metric {
    pub(super) fn new(m: usize, width: usize) -> Self {
        let mut metric = Self {
            m,
            width,
            l: vec![0.0; m * m],
            atoms: vec![0.0; MAX_CONTACTS * width],
            n: 0,
            gram: [0.0; SIZE],
            factor: [0.0; SIZE],
            is_definite: true,
            r: vec![0.0; width],
            log_det: 0.0,
        };
        (0..m).for_each(|i| metric.l[i * m + i] = 1.0);
        metric
    }

    /// Takes S from `s` `[m, m]`; the unit matrix stands in where rounding spoils it.
    pub(super) fn set_covariance(&mut self, s: &[f64]) {
        let m = self.m;
        self.l.copy_from_slice(s);
        if !cholesky(&mut self.l, m, 0.0) {
            self.l.fill(0.0);
            for i in 0..m {
                self.l[i * m + i] = s[i * m + i].max(1.0).sqrt();
            }
        }
        self.log_det = log_det(&self.l, m);
    }

    pub(super) fn whiten(&self, row: &mut [f64]) {
        solve_lower(&self.l, self.m, &mut row[..self.m]);
    }

    /// Takes the atoms of `n` contacts from `atoms` `[n, width]`, noise as it is.
    pub(super) fn set_atoms(&mut self, atoms: &[f64], n: usize) {
        self.n = n;
        self.atoms[..n * self.width].copy_from_slice(&atoms[..n * self.width]);
        for i in 0..n {
            let at = i * self.width;
            solve_lower(&self.l, self.m, &mut self.atoms[at..at + self.m]);
        }
        for i in 0..n {
            for j in 0..=i {
                let product = dot(self.atom(i), self.atom(j));
                self.gram[i * n + j] = product;
                self.gram[j * n + i] = product;
            }
        }
        self.factor = self.gram;
        self.is_definite = cholesky(&mut self.factor[..n * n], n, 1e-10);
    }

    pub(super) fn atom(&self, i: usize) -> &[f64] {
        &self.atoms[i * self.width..(i + 1) * self.width]
    }

    /// Forces, residual and χ² of the frame `z` `[width]`.
    pub(super) fn solve(&mut self, z: &[f64]) -> Solved {
        let n = self.n;
        self.r.copy_from_slice(z);
        solve_lower(&self.l, self.m, &mut self.r[..self.m]);
        let mut c = [0.0; MAX_CONTACTS];
        for (i, c) in c[..n].iter_mut().enumerate() {
            *c = dot(&self.atoms[i * self.width..(i + 1) * self.width], &self.r);
        }
        let forces = self.forces(&c);
        for (atom, force) in self.atoms.chunks_exact(self.width).zip(&forces[..n]) {
            add_scaled(&mut self.r, -force, atom);
        }
        let chi2 = dot(&self.r, &self.r);
        Solved { forces, chi2 }
    }

    fn forces(&self, c: &[f64; MAX_CONTACTS]) -> [f64; MAX_CONTACTS] {
        let n = self.n;
        if self.is_definite {
            let mut x = *c;
            solve_lower(&self.factor, n, &mut x[..n]);
            solve_upper(&self.factor, n, &mut x[..n]);
            if x[..n].iter().all(|&a| a >= 0.0) {
                return x;
            }
        }
        non_negative(&self.gram[..n * n], c, n)
    }

    /// Variances of the forces `[n, n]` into `out`, noise and what is unknown of the atoms together;
    /// `false` if the readings don't distinguish the contacts.
    pub(super) fn force_covariance(&self, out: &mut [f64; SIZE]) -> bool {
        if self.is_definite {
            crate::dense::inverse(&self.factor, self.n, out);
        }
        self.is_definite
    }

    /// ln det of the atoms' products.
    pub(super) fn log_det_atoms(&self) -> f64 {
        if self.is_definite { log_det(&self.factor, self.n) } else { 0.0 }
    }

    /// Orthonormal rows that span the atoms of contacts with `forces` above 0, into `basis`
    /// `[MAX_CONTACTS, width]`; how many there are.
    pub(super) fn span(&self, forces: &[f64], basis: &mut [f64]) -> usize {
        let width = self.width;
        let mut n = 0;
        for i in (0..self.n).filter(|&i| forces[i] > 0.0) {
            let (before, rest) = basis.split_at_mut(n * width);
            let row = &mut rest[..width];
            row.copy_from_slice(self.atom(i));
            let length = dot(row, row).sqrt();
            // twice is enough (Giraud et al. 2005)
            for _ in 0..2 {
                for q in before.chunks_exact(width) {
                    let along = dot(q, row);
                    add_scaled(row, -along, q);
                }
            }
            let left = dot(row, row).sqrt();
            if left > 1e-9 * length {
                row.iter_mut().for_each(|v| *v /= left);
                n += 1;
            }
        }
        n
    }
}
