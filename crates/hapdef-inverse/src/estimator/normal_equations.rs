//! An explanation's residual, forces and normal equations, in buffers that are used again.

use hapdef_contact::MAX_CONTACTS;
use nalgebra::Vector3;

use crate::dense::{add_scaled, dot, log_det, set_columns, solve_columns, solve_lower};
use crate::estimator::Model;
use crate::estimator::explanation::Explanation;
use crate::estimator::forces::non_negative;

/// Unknowns at most: two on the surface and a force for each contact.
pub(crate) const MAX_UNKNOWNS: usize = 3 * MAX_CONTACTS;

/// Buffers of the linearised problem at one explanation. Unknowns go contact by contact: along
/// tangent 1, along tangent 2 (m), force (N).
#[derive(Clone, Debug)]
pub(crate) struct Linear {
    /// The frame, whitened for the scan `[width]`.
    pub(crate) z: Vec<f64>,
    /// L_S⁻¹ z `[width]`, S the covariance at the explanation.
    z_s: Vec<f64>,
    /// Rows ∂₁g, ∂₂g, g of each contact, whitened by S `[3 n, width]`.
    rows: Vec<f64>,
    /// Residual, whitened by S `[width]`.
    r: Vec<f64>,
    /// L_S `[m, m]`.
    s: Vec<f64>,
    /// L_S by columns `[m, width]`, and one over its diagonal `[m]`.
    columns: Vec<f64>,
    inverses: Vec<f64>,
    pub(crate) tangents: [[Vector3<f64>; 2]; MAX_CONTACTS],
    /// JᵀJ `[3 n, 3 n]`.
    pub(crate) a: [f64; MAX_UNKNOWNS * MAX_UNKNOWNS],
    /// Jᵀr `[3 n]`.
    pub(crate) b: [f64; MAX_UNKNOWNS],
}

impl Linear {
    pub(crate) fn new(model: &Model) -> Self {
        let zeros = vec![0.0; model.width];
        Self {
            z: zeros.clone(),
            z_s: zeros.clone(),
            rows: vec![0.0; MAX_UNKNOWNS * model.width],
            r: zeros,
            s: vec![0.0; model.m * model.m],
            columns: vec![0.0; model.m * model.width],
            inverses: vec![0.0; model.m],
            tangents: [[Vector3::zeros(); 2]; MAX_CONTACTS],
            a: [0.0; MAX_UNKNOWNS * MAX_UNKNOWNS],
            b: [0.0; MAX_UNKNOWNS],
        }
    }

    pub(crate) fn has_gauges(&self, m: usize) -> bool {
        self.s.len() == m * m
    }

    /// S = R + Σ A² C(p) at `e`, and ln det S into it. S stays until the next call.
    pub(crate) fn set_covariance(&mut self, model: &Model, e: &mut Explanation) {
        self.z_s.copy_from_slice(&self.z);
        e.log_det_s = 0.0;
        let m = model.m;
        let contacts = e.points[..e.n].iter().zip(e.forces);
        if !model.set_covariance(contacts, &mut self.s) {
            return;
        }
        e.log_det_s = log_det(&self.s, m);
        solve_lower(&self.s, m, &mut self.z_s[..m]);
        set_columns(&self.s, m, model.width, &mut self.columns, &mut self.inverses);
    }

    /// Forces, residual and χ² at the points of `e`.
    pub(crate) fn evaluate(&mut self, model: &Model, e: &mut Explanation) {
        let width = model.width;
        for i in 0..e.n {
            self.fill_rows(model, e, i);
        }
        let row = |q: usize| &self.rows[q * width..(q + 1) * width];
        let mut h = [0.0; MAX_CONTACTS * MAX_CONTACTS];
        let mut c = [0.0; MAX_CONTACTS];
        for i in 0..e.n {
            c[i] = dot(row(3 * i + 2), &self.z_s);
            for j in 0..=i {
                let product = dot(row(3 * i + 2), row(3 * j + 2));
                h[i * e.n + j] = product;
                h[j * e.n + i] = product;
            }
        }
        e.forces = non_negative(&h, &c, e.n);
        self.r.copy_from_slice(&self.z_s);
        for i in 0..e.n {
            let at = (3 * i + 2) * width;
            add_scaled(&mut self.r, -e.forces[i], &self.rows[at..at + width]);
        }
        e.chi2 = dot(&self.r, &self.r);
    }

    fn fill_rows(&mut self, model: &Model, e: &Explanation, i: usize) {
        let width = model.width;
        let point = &e.points[i];
        let frame = model.skin().frame(point);
        let weights = model.interpolant().weights(&point.bary(), &frame);
        self.tangents[i] = frame.tangents;
        let rows = &mut self.rows[3 * i * width..(3 * i + 3) * width];
        let all = [&weights.slope[0], &weights.slope[1], &weights.value];
        for (row, weights) in rows.chunks_exact_mut(width).zip(all) {
            model.interpolant().combine(model.rows(), point, weights, row);
        }
        if model.base.is_some() {
            solve_columns::<3>(&self.columns, &self.inverses, rows);
        }
    }

    /// JᵀJ at the points and forces of `e`, whatever the frame.
    pub(crate) fn inform(&mut self, model: &Model, e: &mut Explanation) {
        self.set_covariance(model, e);
        for i in 0..e.n {
            self.fill_rows(model, e, i);
        }
        self.linearise(model, e);
    }

    /// JᵀJ and Jᵀr where [`Linear::evaluate`] was called last.
    pub(crate) fn linearise(&mut self, model: &Model, e: &Explanation) {
        let (width, n) = (model.width, 3 * e.n);
        let row = |q: usize| &self.rows[q * width..(q + 1) * width];
        let scale = |q: usize| if q % 3 == 2 { 1.0 } else { e.forces[q / 3] };
        for p in 0..n {
            self.b[p] = scale(p) * dot(row(p), &self.r);
            for q in 0..=p {
                let product = scale(p) * scale(q) * dot(row(p), row(q));
                self.a[p * n + q] = product;
                self.a[q * n + p] = product;
            }
        }
    }
}
