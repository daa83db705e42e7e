//! Shape functions, geometry and quadrature of the six-node triangle.
//!
//! Parent coordinates (ξ, η) run over the triangle (0,0), (1,0), (0,1), the corners 0, 1, 2;
//! ζ = 1 − ξ − η. Mid-side nodes 3, 4, 5 lie between corners 0–1, 1–2, 2–0
//! (Zienkiewicz, Taylor and Zhu, The Finite Element Method, 6th ed., section 4.7).

use nalgebra::{Point3, Vector3};

/// Nᵢ(ξ, η) of the six nodes; they sum to 1.
#[must_use]
pub fn shape(xi: f64, eta: f64) -> [f64; 6] {
    let zeta = 1.0 - xi - eta;
    [
        zeta * (2.0 * zeta - 1.0),
        xi * (2.0 * xi - 1.0),
        eta * (2.0 * eta - 1.0),
        4.0 * zeta * xi,
        4.0 * xi * eta,
        4.0 * eta * zeta,
    ]
}

/// (∂Nᵢ/∂ξ, ∂Nᵢ/∂η) of the six nodes.
#[must_use]
pub fn shape_gradient(xi: f64, eta: f64) -> [[f64; 2]; 6] {
    let zeta = 1.0 - xi - eta;
    [
        [1.0 - 4.0 * zeta, 1.0 - 4.0 * zeta],
        [4.0 * xi - 1.0, 0.0],
        [0.0, 4.0 * eta - 1.0],
        [4.0 * (zeta - xi), -4.0 * xi],
        [4.0 * eta, 4.0 * xi],
        [-4.0 * eta, 4.0 * (zeta - eta)],
    ]
}

/// The point x(ξ, η) = Σ Nᵢ xᵢ of the face with node positions `nodes`, m.
#[must_use]
pub fn position(nodes: &[Point3<f64>; 6], xi: f64, eta: f64) -> Point3<f64> {
    let n = shape(xi, eta);
    Point3::from(nodes.iter().zip(n).map(|(p, n)| p.coords * n).sum::<Vector3<f64>>())
}

/// (∂x/∂ξ, ∂x/∂η), m per unit parent coordinate: two tangents of the face.
#[must_use]
pub fn tangents(nodes: &[Point3<f64>; 6], xi: f64, eta: f64) -> [Vector3<f64>; 2] {
    let d = shape_gradient(xi, eta);
    let sum = |k: usize| nodes.iter().zip(d).map(|(p, d)| p.coords * d[k]).sum();
    [sum(0), sum(1)]
}

/// ∂x/∂ξ × ∂x/∂η, m²: the outward normal whose length is the ratio of face area to parent area,
/// so that ∫ f dA = Σ w f |area_vector| over a [`QuadraturePoint`] rule.
#[must_use]
pub fn area_vector(nodes: &[Point3<f64>; 6], xi: f64, eta: f64) -> Vector3<f64> {
    let [a, b] = tangents(nodes, xi, eta);
    a.cross(&b)
}

/// A point of a quadrature rule on the parent triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraturePoint {
    /// ξ.
    pub xi: f64,
    /// η.
    pub eta: f64,
    /// Weight; the weights of a rule sum to ½, the area of the parent triangle.
    pub weight: f64,
}

const A7: f64 = 0.470_142_064_105_115_1;
const B7: f64 = 0.101_286_507_323_456_34;
const WA7: f64 = 0.066_197_076_394_253_1;
const WB7: f64 = 0.062_969_590_272_413_58;

/// The seven-point rule, exact for polynomials of degree 5 (Radon 1948; Dunavant, Int. J. Numer.
/// Meth. Eng. 21, 1985, table II, p = 5). A constant traction on a curved face is integrated
/// exactly: the integrand Nᵢ · area_vector has degree 4.
pub const QUADRATURE: [QuadraturePoint; 7] = [
    QuadraturePoint { xi: 1.0 / 3.0, eta: 1.0 / 3.0, weight: 9.0 / 80.0 },
    QuadraturePoint { xi: A7, eta: A7, weight: WA7 },
    QuadraturePoint { xi: 1.0 - 2.0 * A7, eta: A7, weight: WA7 },
    QuadraturePoint { xi: A7, eta: 1.0 - 2.0 * A7, weight: WA7 },
    QuadraturePoint { xi: B7, eta: B7, weight: WB7 },
    QuadraturePoint { xi: 1.0 - 2.0 * B7, eta: B7, weight: WB7 },
    QuadraturePoint { xi: B7, eta: 1.0 - 2.0 * B7, weight: WB7 },
];

/// Parent coordinates of the six nodes.
pub const NODE_COORDINATES: [[f64; 2]; 6] =
    [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];

/// The face's area, m² ([`QUADRATURE`]; exact on flat faces with straight edges).
#[must_use]
pub fn area(nodes: &[Point3<f64>; 6]) -> f64 {
    QUADRATURE.iter().map(|q| q.weight * area_vector(nodes, q.xi, q.eta).norm()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shape_functions_are_one_at_their_node() {
        for (i, [xi, eta]) in NODE_COORDINATES.into_iter().enumerate() {
            for (j, n) in shape(xi, eta).into_iter().enumerate() {
                assert!((n - f64::from(u8::from(i == j))).abs() < 1e-15, "N{j} at node {i} is {n}");
            }
        }
    }

    #[test]
    fn gradients_are_central_differences() {
        let (xi, eta, h) = (0.23, 0.41, 1e-5);
        let gradient = shape_gradient(xi, eta);
        for i in 0..6 {
            let by_xi = (shape(xi + h, eta)[i] - shape(xi - h, eta)[i]) / (2.0 * h);
            let by_eta = (shape(xi, eta + h)[i] - shape(xi, eta - h)[i]) / (2.0 * h);
            assert!(
                (gradient[i][0] - by_xi).abs() < 1e-9 && (gradient[i][1] - by_eta).abs() < 1e-9
            );
        }
    }

    /// ∫ ξᵃ ηᵇ over the triangle is a! b! / (a + b + 2)!.
    #[test]
    fn the_rule_is_exact_to_degree_five_and_not_six() {
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        let error = |a: i32, b: i32| {
            let sum: f64 = QUADRATURE.iter().map(|q| q.weight * q.xi.powi(a) * q.eta.powi(b)).sum();
            (sum - factorial(a) * factorial(b) / factorial(a + b + 2)).abs()
        };
        for a in 0..=5 {
            for b in 0..=5 - a {
                assert!(error(a, b) < 1e-15, "ξ^{a} η^{b}: {:e}", error(a, b));
            }
        }
        assert!(error(6, 0) > 1e-6);
    }

    #[test]
    fn a_flat_face_has_its_area_and_normal() {
        let corners =
            [Point3::new(1.0, 0.0, 0.0), Point3::new(1.0, 3.0, 0.0), Point3::new(1.0, 0.0, 2.0)];
        let mid = |a: usize, b: usize| nalgebra::center(&corners[a], &corners[b]);
        let face = [corners[0], corners[1], corners[2], mid(0, 1), mid(1, 2), mid(2, 0)];
        assert!((area(&face) - 3.0).abs() < 1e-14);
        assert!((area_vector(&face, 0.2, 0.3) - Vector3::new(6.0, 0.0, 0.0)).norm() < 1e-14);
        assert!((position(&face, 0.5, 0.25) - Point3::new(1.0, 1.5, 0.5)).norm() < 1e-14);
    }
}
