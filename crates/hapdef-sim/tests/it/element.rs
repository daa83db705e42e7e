//! The ten-node tetrahedron by itself.

use crate::common;

use common::{close, material};
use hapdef_mesh::{TET10_EDGES, tet10};
use hapdef_sim::{ElementMatrix, element_mass_kg, space_gradients, stiffness, strain};
use nalgebra::{DMatrix, DVector, Matrix3, Point3, Rotation3, SymmetricEigen, Vector3};
use proptest::prelude::*;

fn curved_element() -> [Point3<f64>; 10] {
    let corners = [[0.0, 0.0, 0.0], [1.1, 0.1, -0.1], [0.2, 0.9, 0.1], [0.1, 0.2, 1.2]];
    let bulge = [
        [0.04, -0.05, 0.02],
        [0.03, 0.05, -0.04],
        [-0.06, 0.02, 0.01],
        [0.0, -0.03, 0.05],
        [0.05, 0.01, 0.03],
        [-0.02, 0.04, 0.02],
    ];
    let corner = |i: usize| Point3::from(corners[i]);
    std::array::from_fn(|i| match i {
        0..4 => corner(i),
        _ => {
            let [a, b] = TET10_EDGES[i - 4];
            nalgebra::center(&corner(a), &corner(b)) + Vector3::from(bulge[i - 4])
        }
    })
}

fn dense(k: &ElementMatrix) -> DMatrix<f64> {
    DMatrix::from_fn(30, 30, |i, j| k[i][j])
}

fn stiffness_of(nodes: &[Point3<f64>; 10]) -> DMatrix<f64> {
    dense(&stiffness(nodes, &material()).expect("a valid element"))
}

fn nodal(nodes: &[Point3<f64>; 10], field: impl Fn(&Point3<f64>) -> Vector3<f64>) -> DVector<f64> {
    DVector::from_iterator(30, nodes.iter().flat_map(|p| <[f64; 3]>::from(field(p))))
}

#[test]
fn stiffness_is_symmetric_with_six_zero_energy_modes() {
    let k = stiffness_of(&curved_element());
    assert_eq!(k, k.transpose());
    let mut values: Vec<f64> = SymmetricEigen::new(k.clone()).eigenvalues.iter().copied().collect();
    values.sort_by(f64::total_cmp);
    let largest = values[29];
    // four Gauss points give 24 strains: 24 modes carry energy, six don't
    assert!(values[5].abs() < 1e-12 * largest, "sixth eigenvalue {:e}", values[5]);
    assert!(values[6] > 1e-5 * largest, "seventh eigenvalue {:e} of {largest:e}", values[6]);
    for axis in 0..3 {
        let e = Vector3::ith(axis, 1.0);
        for mode in
            [nodal(&curved_element(), |_| e), nodal(&curved_element(), |p| e.cross(&p.coords))]
        {
            let force = (&k * &mode).amax();
            assert!(force < 1e-12 * largest, "a rigid motion along {axis} gives {force:e}");
        }
    }
}

#[test]
fn stiffness_of_constant_strain_is_energy_density_times_volume() {
    // straight sides: the four-point rule is exact
    let mut nodes = curved_element();
    for (i, [a, b]) in TET10_EDGES.into_iter().enumerate() {
        nodes[4 + i] = nalgebra::center(&nodes[a], &nodes[b]);
    }
    let g = Matrix3::new(1.0, 0.2, -0.4, 0.5, -0.3, 0.1, 0.7, 0.6, 0.9);
    let eps = (g + g.transpose()) * 0.5;
    let (lambda, mu) = (material().lame_lambda_pa(), material().shear_modulus_pa());
    let density = 0.5 * lambda * f64::powi(eps.trace(), 2) + mu * eps.component_mul(&eps).sum();
    let u = nodal(&nodes, |p| g * p.coords);
    let energy = 0.5 * u.dot(&(stiffness_of(&nodes) * &u));
    close(energy, density * tet10::volume(&nodes), 1e-12);
}

#[test]
fn stiffness_turns_with_the_element() {
    let rotation = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    let nodes = curved_element();
    let turned = nodes.map(|p| rotation * p + Vector3::new(5.0, -3.0, 2.0));
    let q = DMatrix::from_fn(
        30,
        30,
        |i, j| {
            if i / 3 == j / 3 { rotation[(i % 3, j % 3)] } else { 0.0 }
        },
    );
    let expected = &q * stiffness_of(&nodes) * q.transpose();
    let found = stiffness_of(&turned);
    assert!((&found - &expected).amax() < 1e-12 * expected.amax());
}

#[test]
fn stiffness_does_not_depend_on_node_order() {
    // corners 0 1 2 3 → 1 2 0 3, and the mid-side nodes with them
    let order = [1, 2, 0, 3, 5, 6, 4, 8, 9, 7];
    let nodes = curved_element();
    let (k, reordered) = (stiffness_of(&nodes), stiffness_of(&order.map(|i| nodes[i])));
    let at = |i: usize| 3 * order[i / 3] + i % 3;
    let expected = DMatrix::from_fn(30, 30, |i, j| k[(at(i), at(j))]);
    assert!((&reordered - &expected).amax() < 1e-12 * expected.amax());
}

#[test]
fn an_inverted_element_is_refused() {
    let mut nodes = curved_element();
    nodes.swap(0, 1);
    nodes.swap(5, 6);
    nodes.swap(7, 8);
    let point = stiffness(&nodes, &material()).expect_err("inside out");
    assert!(point.det_j_m3 < 0.0, "{point:?}");
}

#[test]
fn mass_is_density_times_volume_and_symmetric() {
    let nodes = curved_element();
    let m = element_mass_kg(&nodes, 700.0);
    let total: f64 = m.iter().flatten().sum();
    close(total, 700.0 * tet10::volume(&nodes), 1e-12);
    for i in 0..10 {
        for j in 0..10 {
            assert!((m[i][j] - m[j][i]).abs() < 1e-15 * total);
        }
    }
}

proptest! {
    #![proptest_config(common::cases(64))]

    /// ε and ∇N against central differences of the interpolated displacement in space.
    #[test]
    fn strain_is_the_derivative_of_displacement(
        r in [0.05..0.3, 0.05..0.3, 0.05..0.3],
        values in prop::array::uniform30(-1.0..1.0),
    ) {
        let nodes = curved_element();
        let u: [Vector3<f64>; 10] =
            std::array::from_fn(|i| Vector3::new(values[3 * i], values[3 * i + 1], values[3 * i + 2]));
        let displacement = |r: [f64; 3]| -> Vector3<f64> {
            u.iter().zip(tet10::shape(r)).map(|(u, n)| u * n).sum()
        };
        let j = tet10::jacobian(&nodes, r);
        let inverse = j.try_inverse().expect("a valid element");
        let h = 1e-5;
        let mut grad = Matrix3::zeros();
        for k in 0..3 {
            // a step along space axis k, seen in parent coordinates to second order by Newton
            let at = |sign: f64| {
                let target = tet10::position(&nodes, r) + Vector3::ith(k, sign * h);
                let mut s = Vector3::from(r) + inverse.column(k) * (sign * h);
                for _ in 0..3 {
                    let miss = tet10::position(&nodes, s.into()) - target;
                    s -= inverse * miss;
                }
                displacement(s.into())
            };
            grad.set_column(k, &((at(1.0) - at(-1.0)) / (2.0 * h)));
        }
        let expected = (grad + grad.transpose()) * 0.5;
        let found = strain(&nodes, &u, r);
        prop_assert!((found - expected).amax() < 1e-7, "{found} against {expected}");
        let (det_j, gradients) = space_gradients(&nodes, r);
        prop_assert!((det_j - j.determinant()).abs() < 1e-14);
        let sum: Vector3<f64> = gradients.iter().sum();
        prop_assert!(sum.amax() < 1e-12, "gradients sum to {sum}");
    }
}
