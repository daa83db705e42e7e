//! Shape functions, Jacobian and volume of the ten-node tetrahedron.
//!
//! Parent coordinates (ξ, η, ζ) run over the tetrahedron (0,0,0), (1,0,0), (0,1,0), (0,0,1), the
//! corners 0 to 3; mid-side nodes follow [`crate::TET10_EDGES`]
//! (Zienkiewicz, Taylor and Zhu, The Finite Element Method, 6th ed., section 4.10).

use nalgebra::{Matrix3, Point3, Vector3};

/// The mid-side nodes 4..10 of a ten-node tetrahedron and the corner pair each lies between:
/// the order of C3D10 (CalculiX 2.20 manual, section 6.2.6) and SOLID187 (ANSYS element reference).
pub const TET10_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Volume coordinates (L₀, L₁, L₂, L₃) of the corners at (ξ, η, ζ).
fn volume_coordinates(r: [f64; 3]) -> [f64; 4] {
    [1.0 - r[0] - r[1] - r[2], r[0], r[1], r[2]]
}

/// ∂Lᵢ/∂(ξ, η, ζ).
const DL: [[f64; 3]; 4] = [[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Nᵢ at parent coordinates `r` = (ξ, η, ζ): Lᵢ(2Lᵢ − 1) at corners, 4LᵢLⱼ at mid-side nodes.
#[must_use]
pub fn shape(r: [f64; 3]) -> [f64; 10] {
    let l = volume_coordinates(r);
    std::array::from_fn(|i| match i {
        0..4 => l[i] * (2.0 * l[i] - 1.0),
        _ => 4.0 * l[TET10_EDGES[i - 4][0]] * l[TET10_EDGES[i - 4][1]],
    })
}

/// ∂Nᵢ/∂(ξ, η, ζ) at parent coordinates `r`.
#[must_use]
pub fn shape_gradient(r: [f64; 3]) -> [[f64; 3]; 10] {
    let l = volume_coordinates(r);
    std::array::from_fn(|i| {
        std::array::from_fn(|k| match i {
            0..4 => (4.0 * l[i] - 1.0) * DL[i][k],
            _ => {
                let [a, b] = TET10_EDGES[i - 4];
                4.0 * (l[a] * DL[b][k] + l[b] * DL[a][k])
            }
        })
    })
}

/// The point x(r) = Σ Nᵢ xᵢ, m.
#[must_use]
pub fn position(nodes: &[Point3<f64>; 10], r: [f64; 3]) -> Point3<f64> {
    Point3::from(nodes.iter().zip(shape(r)).map(|(p, n)| p.coords * n).sum::<Vector3<f64>>())
}

/// J = ∂x/∂(ξ, η, ζ), m: column k holds ∂x/∂rₖ.
#[must_use]
pub fn jacobian(nodes: &[Point3<f64>; 10], r: [f64; 3]) -> Matrix3<f64> {
    let d = shape_gradient(r);
    let column = |k: usize| nodes.iter().zip(d).map(|(p, d)| p.coords * d[k]).sum::<Vector3<f64>>();
    Matrix3::from_columns(&[column(0), column(1), column(2)])
}

const A4: f64 = 0.138_196_601_125_010_5;
const B4: f64 = 0.585_410_196_624_968_5;

/// The four-point rule, exact for degree 2: (ξ, η, ζ) and weight; the weights sum to ⅙
/// (Zienkiewicz, Taylor and Zhu, table 5.4; A = (5 − √5)/20, B = (5 + 3√5)/20).
pub const QUADRATURE4: [([f64; 3], f64); 4] = [
    ([A4, A4, A4], 1.0 / 24.0),
    ([B4, A4, A4], 1.0 / 24.0),
    ([A4, B4, A4], 1.0 / 24.0),
    ([A4, A4, B4], 1.0 / 24.0),
];

/// The smallest det J over the four Gauss points, m³: positive where the element is usable.
#[must_use]
pub fn min_gauss_jacobian(nodes: &[Point3<f64>; 10]) -> f64 {
    QUADRATURE4
        .iter()
        .map(|&(r, _)| jacobian(nodes, r).determinant())
        .min_by(f64::total_cmp)
        .unwrap_or(f64::NAN)
}

/// The element's volume, m³, exact on the curved geometry.
///
/// det J has degree 3, so the volume is summed over the four faces by the divergence theorem,
/// V = ⅓ ∮ x · n dA, with [`crate::solid::tri6::QUADRATURE`].
#[must_use]
pub fn volume(nodes: &[Point3<f64>; 10]) -> f64 {
    let origin = nodes[0];
    crate::TET10_FACES
        .iter()
        .map(|local| {
            let face = local.map(|i| Point3::from(nodes[i] - origin));
            crate::solid::tri6::QUADRATURE
                .iter()
                .map(|q| {
                    let x = crate::solid::tri6::position(&face, q.xi, q.eta);
                    q.weight * x.coords.dot(&crate::solid::tri6::area_vector(&face, q.xi, q.eta))
                        / 3.0
                })
                .sum::<f64>()
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODES: [[f64; 3]; 4] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    fn parent_nodes() -> [Point3<f64>; 10] {
        std::array::from_fn(|i| match i {
            0..4 => Point3::from(NODES[i]),
            _ => {
                let [a, b] = TET10_EDGES[i - 4];
                nalgebra::center(&Point3::from(NODES[a]), &Point3::from(NODES[b]))
            }
        })
    }

    #[test]
    fn shape_functions_are_one_at_their_node() {
        for (i, node) in parent_nodes().iter().enumerate() {
            for (j, n) in shape(node.coords.into()).into_iter().enumerate() {
                assert!((n - f64::from(u8::from(i == j))).abs() < 1e-15, "N{j} at node {i} is {n}");
            }
        }
    }

    #[test]
    fn gradients_are_central_differences() {
        let (r, h) = ([0.17, 0.29, 0.31], 1e-5);
        let gradient = shape_gradient(r);
        for k in 0..3 {
            let moved =
                |by: f64| shape(std::array::from_fn(|i| r[i] + if i == k { by } else { 0.0 }));
            let (up, down) = (moved(h), moved(-h));
            for i in 0..10 {
                assert!((gradient[i][k] - (up[i] - down[i]) / (2.0 * h)).abs() < 1e-9);
            }
        }
    }

    /// x(r) = r + e₁ c ξ(1 − ξ) is quadratic, with det J = 1 + c(1 − 2ξ); over the parent
    /// tetrahedron ∫ 1 = 1/6 and ∫ ξ = 1/24.
    #[test]
    fn a_bent_tetrahedron_has_its_volume_and_jacobian() {
        let c = 0.3;
        let nodes = parent_nodes().map(|p| Point3::new(p.x + c * p.x * (1.0 - p.x), p.y, p.z));
        let exact = 1.0 / 6.0 + c * (1.0 / 6.0 - 2.0 / 24.0);
        assert!((volume(&nodes) - exact).abs() < 1e-15, "{} {exact}", volume(&nodes));
        let r = [0.2, 0.3, 0.1];
        assert!((jacobian(&nodes, r).determinant() - (1.0 + c * 0.6)).abs() < 1e-14);
        let at_gauss = 1.0 + c * (1.0 - 2.0 * B4);
        assert!((min_gauss_jacobian(&nodes) - at_gauss).abs() < 1e-14);
    }
}
