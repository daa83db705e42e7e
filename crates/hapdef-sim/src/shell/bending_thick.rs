//! Bending and transverse shear of thick shells: MITC3+.
//!
//! Source: Y. Lee, P.-S. Lee and K.-J. Bathe, The MITC3+ shell element and its performance, Comput.
//! Struct. 138 (2014) 12–23: a cubic bubble in the tilt, condensed, and an assumed covariant
//! transverse shear strain tied at six inner points.

use nalgebra::{Matrix2, SMatrix, SVector, Vector2};

use super::facet::{Facet, strain_column};

/// Distance of the tying points D, E, F from the centroid in parent coordinates. Lee et al. (2014),
/// section 2.3, take 1e-4, which leaves the element a seventh mode of 1e-10 of its stiffness; at 1e-2
/// that is 1e-6, and results change in the fourth digit on the coarsest meshes.
const TYING_OFFSET: f64 = 1e-2;

/// Six nodal tilts and the two of the bubble, relative to the mean of the three nodes.
pub(super) type Curvature = SMatrix<f64, 3, 8>;
/// Transverse shear strain (γ₁₃, γ₂₃) by the same eight tilts.
pub(super) type Shear = SMatrix<f64, 2, 8>;

/// The curvature at the barycentric point `at`: ∇ of β = Σ λᵢ βᵢ + f b with the bubble
/// f = 27 λ₁ λ₂ λ₃.
pub(super) fn curvature(facet: &Facet, at: &[f64; 3]) -> Curvature {
    let g = &facet.gradients;
    let [l1, l2, l3] = *at;
    let bubble = (g[0] * (l2 * l3) + g[1] * (l1 * l3) + g[2] * (l1 * l2)) * 27.0;
    let mut b = Curvature::zeros();
    for (i, g) in [g[0], g[1], g[2], bubble].iter().enumerate() {
        for axis in 0..2 {
            b.set_column(2 * i + axis, &strain_column(g, axis));
        }
    }
    b
}

/// The assumed shear strain at the barycentric point `at`, equations (17)–(19).
pub(super) fn shear(facet: &Facet, at: &[f64; 3]) -> Shear {
    let [r, s] = [at[1], at[2]];
    // the parent axes r and s run along the sides to the second and the third corner
    let (g_r, g_s) = (facet.side(0), -facet.side(2));
    let along = |axis: &Vector2<f64>, r: f64, s: f64| tilt_along(axis, r, s);
    let d = TYING_OFFSET;
    let third = 1.0 / 3.0;
    let (a, b, c) = ([1.0 / 6.0, 2.0 / 3.0], [2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0; 2]);
    let (pd, pe, pf) = ([third + d, third - 2.0 * d], [third - 2.0 * d, third + d], [third + d; 2]);
    let e_rt = |p: [f64; 2]| along(&g_r, p[0], p[1]);
    let e_st = |p: [f64; 2]| along(&g_s, p[0], p[1]);
    let common = (e_rt(c) + e_st(c)) * third;
    let twist = (e_rt(pf) - e_rt(pd) - e_st(pf) + e_st(pe)) * third;
    let rt = (e_rt(b) - e_st(b) * 0.5) * (2.0 * third) + common + twist * (3.0 * s - 1.0);
    let st = (e_st(a) - e_rt(a) * 0.5) * (2.0 * third) + common + twist * (1.0 - 3.0 * r);
    // γ = Jᵀ⁻¹ (e_rt, e_st) with the rows of Jᵀ along r and s
    let det = g_r.x * g_s.y - g_r.y * g_s.x;
    let inverse = Matrix2::new(g_s.y, -g_r.y, -g_s.x, g_r.x) / det;
    inverse * SMatrix::<f64, 2, 8>::from_rows(&[rt.transpose(), st.transpose()])
}

/// β·axis at the parent point (r, s), by the eight tilts: the facet's deflection is zero.
fn tilt_along(axis: &Vector2<f64>, r: f64, s: f64) -> SVector<f64, 8> {
    let l = [1.0 - r - s, r, s];
    let weights = [l[0], l[1], l[2], 27.0 * l[0] * l[1] * l[2]];
    SVector::from_fn(|i, _| weights[i / 2] * axis[i % 2])
}

/// `[8, 8]` condensed to `[6, 6]`, and the bubble by the nodal tilts, `[2, 6]`.
pub(super) fn condense(k: &SMatrix<f64, 8, 8>) -> (SMatrix<f64, 6, 6>, SMatrix<f64, 2, 6>) {
    let inner = k.fixed_view::<2, 2>(6, 6);
    let coupling = k.fixed_view::<2, 6>(6, 0);
    let det = inner[(0, 0)] * inner[(1, 1)] - inner[(0, 1)] * inner[(1, 0)];
    let inverse = Matrix2::new(inner[(1, 1)], -inner[(0, 1)], -inner[(1, 0)], inner[(0, 0)]) / det;
    let bubble = -(inverse * coupling);
    let nodal = k.fixed_view::<6, 6>(0, 0) + coupling.transpose() * bubble;
    (nodal, bubble)
}
