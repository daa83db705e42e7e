//! Where a new contact explains what the others leave: scans of the sites, and of their pairs.

use crate::dense::{add_scaled, dot, solve_lower};
use crate::estimator::{Gain, MAX_CONTACTS, Model, pair_energies};
use crate::tracker::metric::Metric;

/// Sites looked at together.
const LANES: usize = 16;

/// Share of the largest squared length below which a site counts as blind: its length is less
/// than a ten-thousandth of the longest, and what it explains mostly rounding of f32.
const BLIND_SHARE: f32 = 1e-8;

/// Atoms of the sites, projected beside contacts that are there already.
#[derive(Clone, Debug)]
pub(super) struct SiteScan {
    n_sites: usize,
    /// Atoms whitened by the noise, gauge by gauge `[m, n_sites]`.
    atoms: Vec<f32>,
    /// `[m, n_sites]`: (1 − QQᵀ) L⁻¹ times them, Q the contacts' whitened atoms made orthonormal.
    projected: Vec<f32>,
    /// Squared lengths of the projected atoms.
    lengths_2: Vec<f32>,
    /// Products with the residual.
    along: Vec<f32>,
    pub(super) gains: Vec<f32>,
    pub(super) peaks: Vec<Gain>,
    /// (1 − QQᵀ) L⁻¹ `[m, m]`, by column `[m, width]`.
    columns: Vec<f64>,
    basis: Vec<f64>,
}

impl SiteScan {
    pub(super) fn new(model: &Model) -> Self {
        let (n_sites, m) = (model.n_sites(), model.m);
        let mut atoms = vec![0.0; m * n_sites];
        for site in 0..n_sites {
            for g in 0..m {
                atoms[g * n_sites + site] = (model.atom(site)[g] * model.lengths[site]) as f32;
            }
        }
        Self {
            n_sites,
            projected: vec![0.0; m * n_sites],
            atoms,
            lengths_2: vec![0.0; n_sites],
            along: vec![0.0; n_sites],
            gains: vec![0.0; n_sites],
            peaks: Vec::with_capacity(32),
            columns: vec![0.0; m * model.width],
            basis: vec![0.0; MAX_CONTACTS * model.width],
        }
    }

    /// What a pushing contact at each site explains of the frame that `metric` solved last, with
    /// `forces`: (b·r)² / b·b where b·r > 0, b the projected atom.
    pub(super) fn scan(&mut self, metric: &Metric, forces: &[f64]) {
        let (m, width) = (metric.m, metric.r.len());
        let n_basis = metric.span(forces, &mut self.basis);
        for (g, column) in self.columns.chunks_exact_mut(width).enumerate() {
            column.fill(0.0);
            column[g] = 1.0;
            solve_lower(&metric.l, m, &mut column[..m]);
            for q in self.basis.chunks_exact(width).take(n_basis) {
                let along = dot(q, column);
                add_scaled(column, -along, q);
            }
        }
        pulp::Arch::new().dispatch(|| self.project(&metric.r, m, width));
        let longest = self.lengths_2.iter().fold(0.0, |a: f32, &b| a.max(b));
        let least = (BLIND_SHARE * longest).max(f32::MIN_POSITIVE);
        for site in 0..self.n_sites {
            let (along, length_2) = (self.along[site], self.lengths_2[site]);
            let is_usable = along > 0.0 && length_2 > least;
            self.gains[site] = if is_usable { along * along / length_2 } else { 0.0 };
        }
    }

    #[inline(always)]
    fn project(&mut self, r: &[f64], m: usize, width: usize) {
        let n = self.n_sites;
        self.lengths_2.fill(0.0);
        self.along.fill(0.0);
        self.projected.fill(0.0);
        for row in 0..m {
            let out = &mut self.projected[row * n..(row + 1) * n];
            for g in 0..m {
                let weight = self.columns[g * width + row] as f32;
                for (out, atom) in out.iter_mut().zip(&self.atoms[g * n..(g + 1) * n]) {
                    *out += weight * atom;
                }
            }
            let r = r[row] as f32;
            for ((b, length_2), along) in out.iter().zip(&mut self.lengths_2).zip(&mut self.along) {
                *length_2 += b * b;
                *along += b * r;
            }
        }
    }

    /// The best local maxima of the scan.
    pub(super) fn find_peaks(&mut self, model: &Model, n: usize) {
        model.peaks(&self.gains, n, &mut self.peaks);
    }
}

/// Two sites and the χ² they explain together.
#[derive(Clone, Copy, Debug)]
pub(super) struct SitePair {
    pub(super) sites: [usize; 2],
    energy: f32,
}

/// A scan of all pairs of sites that goes on from frame to frame.
#[derive(Clone, Debug)]
pub(super) struct PairJob {
    n_sites: usize,
    m: usize,
    /// Unit projected atoms `[m, n_sites]`.
    units: Vec<f32>,
    /// Their products with the residual.
    c: Vec<f32>,
    energies: Vec<f32>,
    next_row: usize,
    /// The best partner of each site.
    order: Vec<SitePair>,
    pub(super) pairs: Vec<SitePair>,
    pub(super) is_active: bool,
}

impl PairJob {
    pub(super) fn new(model: &Model) -> Self {
        let (n_sites, m) = (model.n_sites(), model.m);
        Self {
            n_sites,
            m,
            units: vec![0.0; m * n_sites],
            c: vec![0.0; n_sites],
            energies: vec![0.0; n_sites],
            next_row: 0,
            order: Vec::with_capacity(n_sites),
            pairs: Vec::with_capacity(64),
            is_active: false,
        }
    }

    /// Takes what `scan` projected.
    pub(super) fn prepare(&mut self, scan: &SiteScan) {
        let n = self.n_sites;
        let longest = scan.lengths_2.iter().fold(0.0, |a: f32, &b| a.max(b));
        let least = (BLIND_SHARE * longest).max(f32::MIN_POSITIVE);
        for site in 0..n {
            let length_2 = scan.lengths_2[site];
            let scale = if length_2 > least { 1.0 / length_2.sqrt() } else { 0.0 };
            self.c[site] = scan.along[site] * scale;
            for g in 0..self.m {
                self.units[g * n + site] = scan.projected[g * n + site] * scale;
            }
        }
    }

    pub(super) fn start(&mut self) {
        self.order.clear();
        self.pairs.clear();
        self.next_row = 0;
        self.is_active = true;
    }

    /// Rows that are not scanned yet.
    pub(super) fn n_left(&self) -> usize {
        self.n_sites - self.next_row
    }

    /// Scans at most `n_rows` rows; whether all are done.
    pub(super) fn go_on(&mut self, n_rows: usize) -> bool {
        let end = (self.next_row + n_rows).min(self.n_sites);
        for s in self.next_row..end {
            pulp::Arch::new().dispatch(|| self.row(s));
            let mut best = SitePair { sites: [s, s], energy: 0.0 };
            for (t, &energy) in self.energies.iter().enumerate().skip(s + 1) {
                if energy > best.energy {
                    best = SitePair { sites: [s, t], energy };
                }
            }
            if best.energy > 0.0 {
                self.order.push(best);
            }
        }
        self.next_row = end;
        end == self.n_sites
    }

    #[inline(always)]
    fn row(&mut self, s: usize) {
        let n = self.n_sites;
        let first = (s + 1) / LANES * LANES;
        self.energies[first..].fill(0.0);
        for g in 0..self.m {
            let row = &self.units[g * n..(g + 1) * n];
            let weight = row[s];
            for (sum, unit) in self.energies[first..].iter_mut().zip(&row[first..]) {
                *sum += weight * unit;
            }
        }
        let c_s = self.c[s];
        for (energy, &c_t) in self.energies[first..].iter_mut().zip(&self.c[first..]) {
            [*energy] = pair_energies(c_s, &[*energy], &[c_t]);
        }
    }

    /// The `n` best pairs in different places, best first.
    pub(super) fn rank(&mut self, model: &Model, n: usize) {
        self.order
            .sort_unstable_by(|a, b| b.energy.total_cmp(&a.energy).then(a.sites.cmp(&b.sites)));
        let x = model.sites.positions();
        let near = 1.2 * model.sites.spacing_m();
        let close = |i: usize, j: usize| (x[i] - x[j]).norm_squared() <= near * near;
        let is_same = |a: &SitePair, b: &SitePair| {
            let ([a0, a1], [b0, b1]) = (a.sites, b.sites);
            (close(a0, b0) && close(a1, b1)) || (close(a0, b1) && close(a1, b0))
        };
        self.pairs.clear();
        for pair in &self.order {
            if self.pairs.len() == n {
                break;
            }
            if self.pairs.iter().all(|other| !is_same(pair, other)) {
                self.pairs.push(*pair);
            }
        }
    }
}
