//! The standardised normal equations through their eigenvalues.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par, Side};

use super::LinearParams;
use crate::error::ReproError;

/// W = V (Λ + ridge)⁻¹ Vᵀ B over the eigenvalues above the tolerance, and the rank.
pub(super) fn pseudo_solve(
    C: &Mat<f64>,
    B: &Mat<f64>,
    params: &LinearParams,
    n_samples: usize,
) -> Result<(Mat<f64>, usize), ReproError> {
    let (p, q) = (B.nrows(), B.ncols());
    let eigen = C.self_adjoint_eigen(Side::Lower).map_err(|_| ReproError::Eigen { n: p })?;
    let (V, lambda) = (eigen.U(), eigen.S().column_vector());
    let largest = lambda.iter().copied().fold(0.0, f64::max);
    if largest <= 0.0 {
        return Err(ReproError::NoVariance { n_inputs: p, n_samples });
    }
    let kept: Vec<usize> =
        (0..p).filter(|&i| lambda[i] > params.relative_tolerance * largest).collect();
    let basis = Mat::from_fn(p, kept.len(), |i, j| V[(i, kept[j])]);
    let mut projected = Mat::<f64>::zeros(kept.len(), q);
    matmul(projected.as_mut(), Accum::Replace, basis.transpose(), B.as_ref(), 1.0, Par::Seq);
    for j in 0..q {
        for (i, &k) in kept.iter().enumerate() {
            projected[(i, j)] /= lambda[k] + params.ridge;
        }
    }
    let mut W = Mat::<f64>::zeros(p, q);
    matmul(W.as_mut(), Accum::Replace, basis.as_ref(), projected.as_ref(), 1.0, Par::Seq);
    Ok((W, kept.len()))
}

/// ‖(C + ridge) W − B‖ / ‖B‖, 0 where B is 0.
pub(super) fn normal_residual(C: &Mat<f64>, W: &Mat<f64>, B: &Mat<f64>, ridge: f64) -> f64 {
    let mut r = Mat::from_fn(B.nrows(), B.ncols(), |i, j| ridge * W[(i, j)] - B[(i, j)]);
    matmul(r.as_mut(), Accum::Add, C.as_ref(), W.as_ref(), 1.0, Par::Seq);
    let norm = B.norm_l2();
    if norm > 0.0 { r.norm_l2() / norm } else { 0.0 }
}
