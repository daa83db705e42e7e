//! The ten-node tetrahedron: shape gradients in space, strain and stiffness.

use hapdef_mesh::tet10;
use nalgebra::{Matrix3, Point3, Vector3};

use crate::IsotropicMaterial;

/// The stiffness of one element, N/m: row and column 3i + c belong to node i, direction c.
pub type ElementMatrix = [[f64; 30]; 30];

/// Where an element's map turns inside out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvertedPoint {
    /// Parent coordinates (ξ, η, ζ) of the point.
    pub parent: [f64; 3],
    /// det J there, m³: not positive, or not a number.
    pub det_j_m3: f64,
}

/// det J and ∇Nᵢ in space, 1/m, at parent coordinates `r` of the element at `nodes`.
///
/// ∇Nᵢ = J⁻ᵀ ∂Nᵢ/∂r with J = ∂x/∂r, written with the adjugate of J.
#[must_use]
pub fn space_gradients(nodes: &[Point3<f64>; 10], r: [f64; 3]) -> (f64, [Vector3<f64>; 10]) {
    let d = tet10::shape_gradient(r);
    let column = |k: usize| nodes.iter().zip(d).map(|(p, d)| p.coords * d[k]).sum::<Vector3<f64>>();
    let (a, b, c) = (column(0), column(1), column(2));
    let cofactors = [b.cross(&c), c.cross(&a), a.cross(&b)];
    let det_j = a.dot(&cofactors[0]);
    let gradients =
        d.map(|d| (cofactors[0] * d[0] + cofactors[1] * d[1] + cofactors[2] * d[2]) / det_j);
    (det_j, gradients)
}

/// ε = ½(∇u + ∇uᵀ) at parent coordinates `r`, formed directly from the displacements
/// `displacement` of the ten nodes, m.
#[must_use]
pub fn strain(
    nodes: &[Point3<f64>; 10],
    displacement: &[Vector3<f64>; 10],
    r: [f64; 3],
) -> Matrix3<f64> {
    let (_, gradients) = space_gradients(nodes, r);
    let grad_u: Matrix3<f64> =
        displacement.iter().zip(gradients).map(|(u, g)| u * g.transpose()).sum();
    (grad_u + grad_u.transpose()) * 0.5
}

/// The stiffness of the element at `nodes`, by the four-point Gauss rule.
///
/// Kᵢⱼ = Σ w det J (λ gᵢ gⱼᵀ + μ gⱼ gᵢᵀ + μ (gᵢ·gⱼ) I) with gᵢ = ∇Nᵢ: Bᵀ D B of an isotropic
/// material written out (Zienkiewicz, Taylor and Zhu, The Finite Element Method, 6th ed.,
/// section 2.2). Four points integrate straight-sided elements exactly, and on curved ones
/// reproduce the printed element stiffness of ANSYS SOLID187.
///
/// # Errors
/// [`InvertedPoint`] where det J is not positive at a Gauss point.
pub fn stiffness(
    nodes: &[Point3<f64>; 10],
    material: &IsotropicMaterial,
) -> Result<ElementMatrix, InvertedPoint> {
    let (lambda, mu) = (material.lame_lambda_pa(), material.shear_modulus_pa());
    let mut k = [[0.0; 30]; 30];
    for (r, weight) in tet10::QUADRATURE4 {
        let (det_j, g) = space_gradients(nodes, r);
        if det_j.is_nan() || det_j <= 0.0 {
            return Err(InvertedPoint { parent: r, det_j_m3: det_j });
        }
        add_point(&mut k, &g, lambda * weight * det_j, mu * weight * det_j);
    }
    for row in 0..30 {
        for column in 0..row {
            k[row][column] = k[column][row];
        }
    }
    Ok(k)
}

/// Adds one Gauss point's share to the blocks on and above the diagonal.
fn add_point(k: &mut ElementMatrix, g: &[Vector3<f64>; 10], lambda: f64, mu: f64) {
    for i in 0..10 {
        for j in i..10 {
            let mu_dot = mu * g[i].dot(&g[j]);
            for a in 0..3 {
                for b in 0..3 {
                    k[3 * i + a][3 * j + b] += lambda * g[i][a] * g[j][b] + mu * g[i][b] * g[j][a];
                }
                k[3 * i + a][3 * j + a] += mu_dot;
            }
        }
    }
}
