//! Bending of thin shells: the discrete Kirchhoff triangle.
//!
//! Source: J.-L. Batoz, K.-J. Bathe and L.-W. Ho, A study of three-node triangular plate bending
//! elements, Int. J. Numer. Methods Eng. 15 (1980) 1771–1812, section 3.3, rewritten for tilts
//! relative to the facet's rotation, so that the three deflections are zero.

use nalgebra::{SMatrix, Vector2};

use super::facet::{Facet, strain_column};

/// Curvature (κ₁₁, κ₂₂, 2κ₁₂) by the six tilts, 1/m.
pub(super) type Curvature = SMatrix<f64, 3, 6>;

/// The curvature at the barycentric point `at`.
///
/// β = Σ λᵢ βᵢ − 3 Σ λᵢ λⱼ sₖ (sₖ·(βᵢ + βⱼ)) over the sides k = ij with unit direction s: the tilt
/// is quadratic, linear along each side across it, and at mid-side −¼(β_sᵢ + β_sⱼ) along it, the
/// slope of a cubic deflection that vanishes at both ends.
pub(super) fn curvature(facet: &Facet, at: &[f64; 3]) -> Curvature {
    let mut b = Curvature::zeros();
    let g = &facet.gradients;
    for i in 0..3 {
        let j = (i + 1) % 3;
        let s = facet.side(i);
        let product: Vector2<f64> = g[i] * at[j] + g[j] * at[i];
        let factor = -3.0 / s.norm_squared();
        for axis in 0..2 {
            let own = strain_column(&g[i], axis);
            let mut column = b.column_mut(2 * i + axis);
            column += own;
            let along = (strain_column(&product, 0) * s.x + strain_column(&product, 1) * s.y)
                * (factor * s[axis]);
            for end in [i, j] {
                let mut column = b.column_mut(2 * end + axis);
                column += along;
            }
        }
    }
    b
}
