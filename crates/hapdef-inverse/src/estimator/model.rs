//! The response map in whitened readings, and its atoms at the scan sites.

use std::sync::{Arc, OnceLock};

use crate::dense::{cholesky, dot, padded, solve_lower};
use crate::error::{InverseError, check_length};
use crate::estimator::map_error::site_errors;
use crate::interpolant::Interpolant;
use crate::noise::NoiseParams;
use crate::response::ResponseMap;
use crate::sites::ScanSites;
use crate::skin::Skin;
use crate::skin_point::SkinPoint;

/// Everything that depends on the map, the noise and the live gauges, not on the frame.
///
/// Readings y of the live gauges become z = L⁻¹ y with L Lᵀ = R + A² C̄, R the noise and the loads that
/// are no contacts, C̄ the map's mean error at a typical force A; without map error z has unit covariance.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) map: Arc<ResponseMap>,
    pub(crate) sites: Arc<ScanSites>,
    /// Gauges whose readings count, ascending.
    pub(crate) live: Vec<usize>,
    /// Live gauges.
    pub(crate) m: usize,
    pub(crate) width: usize,
    /// `[m, m]`.
    pub(crate) l: Vec<f64>,
    /// Whitened control values `[n_rows, width]`.
    rows: Vec<f64>,
    /// Whitened control values for forces along x, y, z `[n_rows, 3, width]`.
    vector_rows: Vec<f64>,
    /// Whitened atoms of unit length `[n_sites, width]`; zero where a site moves no gauge.
    pub(crate) atoms: Vec<f64>,
    /// Their length before `[n_sites]`, per newton.
    pub(crate) lengths: Vec<f64>,
    gram: OnceLock<Vec<f32>>,
    /// Whitened noise covariance `[m, m]`; `None` where it is the unit matrix and the map exact.
    pub(crate) base: Option<Vec<f64>>,
    /// Whitened map error per N² `[n_sites, m, m]`.
    errors: Vec<f64>,
    /// The map's error counts for no larger force than this, N.
    pub(crate) max_force_n: f64,
    /// See [`crate::ModelError::place_factor`].
    pub(crate) place_factor: f64,
}

impl Model {
    pub(crate) fn new(
        map: Arc<ResponseMap>,
        sites: Arc<ScanSites>,
        noise: &NoiseParams,
        live: &[bool],
    ) -> Result<Self, InverseError> {
        check_length("the mask of live gauges", map.n_gauges(), live.len())?;
        noise.check(map.n_gauges(), sites.len())?;
        let live: Vec<usize> = (0..live.len()).filter(|&g| live[g]).collect();
        let m = live.len();
        if m < 3 {
            let (n_live, needed) = (m, 3);
            return Err(InverseError::TooFewGauges { n_live, needed });
        }
        let errors = site_errors(&map, &sites, &noise.model_error, &live);
        let r = noise.covariance(&live);
        let mut l = r.clone();
        for error in errors.chunks_exact(m * m) {
            let scale = noise.typical_force_n.powi(2) / sites.len() as f64;
            for (l, e) in l.iter_mut().zip(error) {
                *l += scale * e;
            }
        }
        if !cholesky(&mut l, m, 1e-14) {
            let what = "the noise with the map's error";
            return Err(InverseError::NotPositiveDefinite { what });
        }
        let mut model = Self {
            width: padded(m),
            rows: Vec::new(),
            vector_rows: Vec::new(),
            atoms: Vec::new(),
            lengths: Vec::new(),
            gram: OnceLock::new(),
            base: None,
            errors: Vec::new(),
            max_force_n: f64::INFINITY,
            place_factor: noise.model_error.place_factor,
            map,
            sites,
            live,
            m,
            l,
        };
        let full = padded(model.map.n_gauges());
        model.rows = model.whitened_rows(model.map.normal_rows(), full);
        model.vector_rows = model.whitened_rows(model.map.vector_rows(), full);
        if !noise.model_error.is_none() {
            model.base = Some(model.whitened_covariance(&r));
            model.errors = errors
                .chunks_exact(m * m)
                .flat_map(|error| model.whitened_covariance(error))
                .collect();
        }
        model.set_atoms();
        Ok(model)
    }

    /// Turns the covariance of places and forces `[n, n]`, three numbers a contact with its force last,
    /// into what is reported.
    pub(crate) fn scale_places(&self, covariance: &mut [f64], n: usize) {
        let scale = |p: usize| match p % 3 {
            2 => 1.0,
            _ => self.place_factor.sqrt(),
        };
        for (k, entry) in covariance.iter_mut().enumerate() {
            *entry *= scale(k / n) * scale(k % n);
        }
    }

    pub(crate) fn skin(&self) -> &Skin {
        self.map.skin()
    }

    pub(crate) fn interpolant(&self) -> &Interpolant {
        self.map.interpolant()
    }

    pub(crate) fn rows(&self) -> &[f64] {
        &self.rows
    }

    pub(crate) fn vector_rows(&self) -> &[f64] {
        &self.vector_rows
    }

    pub(crate) fn n_sites(&self) -> usize {
        self.sites.len()
    }

    pub(crate) fn atom(&self, site: usize) -> &[f64] {
        &self.atoms[site * self.width..(site + 1) * self.width]
    }

    /// Products of unit atoms `[n_sites, n_sites]`, which pairs are weighed by: made the first time
    /// that they are asked for, since single contacts need none.
    pub(crate) fn gram(&self) -> &[f32] {
        self.gram.get_or_init(|| {
            let n = self.n_sites();
            let mut gram = vec![0.0; n * n];
            for s in 0..n {
                for t in s..n {
                    let product = dot(self.atom(s), self.atom(t)) as f32;
                    gram[s * n + t] = product;
                    gram[t * n + s] = product;
                }
            }
            gram
        })
    }

    /// L_S `[m, m]` of S = R + Σ A² C(p) for contacts at p with a force A (N); `false`, and `s` as it
    /// was, where S is the unit matrix.
    pub(crate) fn set_covariance<'a>(
        &self,
        contacts: impl Iterator<Item = (&'a SkinPoint, f64)>,
        s: &mut [f64],
    ) -> bool {
        let Some(base) = &self.base else {
            return false;
        };
        s.copy_from_slice(base);
        for (point, force_n) in contacts {
            let scale = force_n.min(self.max_force_n).powi(2);
            for (s, c) in s.iter_mut().zip(self.error_at(point)) {
                *s += scale * c;
            }
        }
        if !cholesky(s, self.m, 0.0) {
            // rounding at huge forces: the scan's own whitening stands in
            s.fill(0.0);
            (0..self.m).for_each(|i| s[i * self.m + i] = 1.0);
        }
        true
    }

    /// Whether the map has no error.
    pub(crate) fn is_exact(&self) -> bool {
        self.base.is_none()
    }

    /// Whitened map error per N² near `point` `[m, m]`.
    pub(crate) fn error_at(&self, point: &SkinPoint) -> &[f64] {
        let site = self.sites.of_point(self.skin(), point);
        let size = self.m * self.m;
        &self.errors[site * size..(site + 1) * size]
    }

    /// Whitened map error per N², mean over the sites `[m, m]`; empty if the map is exact.
    pub(crate) fn mean_error(&self) -> Vec<f64> {
        let size = self.m * self.m;
        let mut mean = vec![0.0; self.errors.len().min(size)];
        for error in self.errors.chunks_exact(size) {
            for (mean, e) in mean.iter_mut().zip(error) {
                *mean += e / self.n_sites() as f64;
            }
        }
        mean
    }

    /// z of all gauges' readings, into `z` `[width]`.
    ///
    /// # Errors
    /// [`InverseError::Length`]; [`InverseError::Reading`] naming a live gauge.
    pub(crate) fn whiten(&self, readings: &[f64], z: &mut [f64]) -> Result<(), InverseError> {
        check_length("the readings", self.map.n_gauges(), readings.len())?;
        z.fill(0.0);
        for (z, &gauge) in z.iter_mut().zip(&self.live) {
            let found = readings[gauge];
            if !found.is_finite() {
                return Err(InverseError::Reading { gauge, found });
            }
            *z = found;
        }
        solve_lower(&self.l, self.m, &mut z[..self.m]);
        match z.iter().position(|v| v.is_nan() || v.abs() >= 1e100) {
            Some(place) => {
                let gauge = self.live[place.min(self.m - 1)];
                let found = readings[gauge];
                Err(InverseError::Reading { gauge, found })
            }
            None => Ok(()),
        }
    }

    fn whitened_rows(&self, rows: &[f64], full: usize) -> Vec<f64> {
        let mut out = vec![0.0; rows.len() / full * self.width];
        for (row, out) in rows.chunks_exact(full).zip(out.chunks_exact_mut(self.width)) {
            for (out, &gauge) in out.iter_mut().zip(&self.live) {
                *out = row[gauge];
            }
            solve_lower(&self.l, self.m, &mut out[..self.m]);
        }
        out
    }

    /// L⁻¹ C L⁻ᵀ.
    fn whitened_covariance(&self, c: &[f64]) -> Vec<f64> {
        let m = self.m;
        let half = |c: &[f64]| {
            let mut out = vec![0.0; m * m];
            for j in 0..m {
                let mut column: Vec<f64> = (0..m).map(|i| c[i * m + j]).collect();
                solve_lower(&self.l, m, &mut column);
                // transposed on the way out
                out[j * m..(j + 1) * m].copy_from_slice(&column);
            }
            out
        };
        half(&half(c))
    }

    fn set_atoms(&mut self) {
        let (n, width) = (self.n_sites(), self.width);
        let mut atoms = vec![0.0; n * width];
        let mut lengths = vec![0.0; n];
        for (site, atom) in atoms.chunks_exact_mut(width).enumerate() {
            let point = &self.sites.points()[site];
            let weights = self.interpolant().value_weights(&point.bary());
            self.interpolant().combine(&self.rows, point, &weights, atom);
            lengths[site] = dot(atom, atom).sqrt();
        }
        let longest = lengths.iter().fold(0.0, |a: f64, &b| a.max(b));
        for (site, atom) in atoms.chunks_exact_mut(width).enumerate() {
            let is_blind = lengths[site] <= 1e-9 * longest;
            let scale = if is_blind { 0.0 } else { 1.0 / lengths[site] };
            atom.iter_mut().for_each(|v| *v *= scale);
        }
        (self.atoms, self.lengths) = (atoms, lengths);
    }
}
