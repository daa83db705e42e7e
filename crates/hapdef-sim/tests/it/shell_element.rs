//! The shell triangle by itself: zero-energy modes, invariance, and its strain functional.

use hapdef_sim::{
    IsotropicMaterial, ShellElementProblem, ShellKind, ShellStrain, shell_pressure_load,
    shell_stiffness, shell_traction_load,
};
use nalgebra::{DMatrix, DVector, Matrix3, Point3, Rotation3, SymmetricEigen, Vector3};
use proptest::prelude::*;

const KINDS: [ShellKind; 2] = [ShellKind::Thin, ShellKind::Thick];

fn material() -> IsotropicMaterial {
    IsotropicMaterial::new(2.0e9, 0.3, 1000.0).expect("a valid material")
}

fn corners() -> [Point3<f64>; 3] {
    [[0.1, -0.2, 0.05], [1.3, 0.1, 0.3], [0.4, 0.9, -0.2]].map(Point3::from)
}

/// Directors that lean away from the facet's normal, each another way.
fn leaning(nodes: &[Point3<f64>; 3], lean: f64) -> [Vector3<f64>; 3] {
    let normal = (nodes[1] - nodes[0]).cross(&(nodes[2] - nodes[0]));
    let centre = (nodes[0].coords + nodes[1].coords + nodes[2].coords) / 3.0;
    nodes.map(|p| {
        let d = normal / normal.norm() + (p.coords - centre) * lean;
        d / d.norm()
    })
}

fn stiffness_of(
    kind: ShellKind,
    nodes: &[Point3<f64>; 3],
    directors: Option<&[Vector3<f64>; 3]>,
    thickness_m: &[f64; 3],
) -> DMatrix<f64> {
    let k = shell_stiffness(kind, nodes, directors, thickness_m, &material()).expect("valid");
    DMatrix::from_fn(18, 18, |i, j| k[i][j])
}

fn eigenvalues(k: &DMatrix<f64>) -> Vec<f64> {
    let mut values: Vec<f64> = SymmetricEigen::new(k.clone()).eigenvalues.iter().copied().collect();
    values.sort_by(f64::total_cmp);
    values
}

/// The six rigid motions: unit translations, and unit rotations about the origin.
fn rigid(nodes: &[Point3<f64>; 3]) -> Vec<DVector<f64>> {
    let motion = |u: &dyn Fn(&Point3<f64>) -> Vector3<f64>, r: Vector3<f64>| {
        let values = nodes.iter().flat_map(|p| {
            let u = u(p);
            [u.x, u.y, u.z, r.x, r.y, r.z]
        });
        DVector::from_iterator(18, values)
    };
    let mut all = Vec::new();
    for axis in 0..3 {
        let e = Vector3::ith(axis, 1.0);
        all.push(motion(&|_| e, Vector3::zeros()));
        all.push(motion(&|p| e.cross(&p.coords), e));
    }
    all
}

#[test]
fn six_modes_cost_no_energy() {
    let nodes = corners();
    for kind in KINDS {
        for lean in [0.0, 0.4] {
            let k = stiffness_of(kind, &nodes, Some(&leaning(&nodes, lean)), &[0.05, 0.06, 0.04]);
            let values = eigenvalues(&k);
            let largest = values[17];
            assert!(values[0] > -1e-12 * largest, "{kind:?}: {:e}", values[0]);
            assert!(values[5] < 1e-12 * largest, "{kind:?}: sixth {:e}", values[5]);
            assert!(
                values[6] > 1e-8 * largest,
                "{kind:?}, lean {lean}: seventh {:e} of {largest:e}",
                values[6]
            );
            for mode in rigid(&nodes) {
                let force = (&k * mode).amax();
                assert!(force < 1e-12 * largest, "{kind:?}: force {force:e} of {largest:e}");
            }
        }
    }
}

#[test]
fn stiffness_turns_with_the_element() {
    let rotation = Rotation3::from_euler_angles(0.3, -1.1, 2.0);
    let nodes = corners();
    let directors = leaning(&nodes, 0.3);
    let turned = nodes.map(|p| rotation * p + Vector3::new(5.0, -3.0, 2.0));
    let q = DMatrix::from_fn(
        18,
        18,
        |i, j| {
            if i / 3 == j / 3 { rotation[(i % 3, j % 3)] } else { 0.0 }
        },
    );
    for kind in KINDS {
        let k = stiffness_of(kind, &nodes, Some(&directors), &[0.05; 3]);
        let found = stiffness_of(kind, &turned, Some(&directors.map(|d| rotation * d)), &[0.05; 3]);
        let expected = &q * k * q.transpose();
        assert!((&found - &expected).amax() < 1e-12 * expected.amax(), "{kind:?}");
    }
}

#[test]
fn stiffness_does_not_depend_on_node_order() {
    let order = [1, 2, 0];
    let (nodes, thickness) = (corners(), [0.05, 0.07, 0.04]);
    let directors = leaning(&nodes, 0.3);
    for kind in KINDS {
        let k = stiffness_of(kind, &nodes, Some(&directors), &thickness);
        let found = stiffness_of(
            kind,
            &order.map(|i| nodes[i]),
            Some(&order.map(|i| directors[i])),
            &order.map(|i| thickness[i]),
        );
        let at = |i: usize| 6 * order[i / 6] + i % 6;
        let expected = DMatrix::from_fn(18, 18, |i, j| k[(at(i), at(j))]);
        let miss = (&found - &expected).amax() / expected.amax();
        assert!(miss < 1e-10, "{kind:?}: {miss:e}");
    }
}

#[test]
fn turning_a_flat_element_over_changes_nothing() {
    let order = [0, 2, 1];
    let nodes = corners();
    for kind in KINDS {
        let k = stiffness_of(kind, &nodes, None, &[0.05; 3]);
        let found = stiffness_of(kind, &order.map(|i| nodes[i]), None, &[0.05; 3]);
        let at = |i: usize| 6 * order[i / 6] + i % 6;
        let expected = DMatrix::from_fn(18, 18, |i, j| k[(at(i), at(j))]);
        let miss = (&found - &expected).amax() / expected.amax();
        assert!(miss < 1e-10, "{kind:?}: {miss:e}");
    }
}

#[test]
fn strain_of_a_constant_field_is_that_field() {
    // membrane G x, and bending w = −½ xᵀ C x with rotations that follow it: ε = sym G + z C
    let g = Matrix3::new(0.3, -0.2, 0.0, 0.7, 0.4, 0.0, 0.0, 0.0, 0.0) * 1e-3;
    let c = Matrix3::new(0.5, 0.2, 0.0, 0.2, -0.3, 0.0, 0.0, 0.0, 0.0);
    let nodes = [[0.0, 0.1, 0.0], [0.9, 0.1, 0.0], [0.3, 0.8, 0.0]].map(Point3::from);
    let mut values = [0.0; 18];
    for (i, p) in nodes.iter().enumerate() {
        let slope = -(c * p.coords);
        let u = g * p.coords;
        let w = -0.5 * p.coords.dot(&(c * p.coords));
        let dofs = [u.x, u.y, w, slope.y, -slope.x, 0.5 * (g[(1, 0)] - g[(0, 1)])];
        values[6 * i..6 * i + 6].copy_from_slice(&dofs);
    }
    for (at, z) in [([0.2, 0.3, 0.5], 0.004), ([1.0, 0.0, 0.0], -0.01)] {
        let s = ShellStrain::new(ShellKind::Thin, &nodes, None, &[0.02; 3], &material(), &at)
            .expect("valid");
        let expected = (g + g.transpose()) * 0.5 + c * z;
        let found = s.tensor(&values, z);
        assert!((found - expected).amax() < 1e-15, "{found} against {expected}");
        let axis = Vector3::new(0.6, 0.8, 0.0);
        let along: f64 = s.along(&axis, z).iter().zip(values).map(|(a, v)| a * v).sum();
        assert!((along - axis.dot(&(expected * axis))).abs() < 1e-15);
        let r = s.resultants(&values, 0.02, &material());
        let d = 2.0e9 * 0.02_f64.powi(3) / 12.0 / (1.0 - 0.09);
        assert!((r.moment_n[0] - d * (0.5 - 0.3 * 0.3)).abs() < 1e-9 * d, "{r:?}");
    }
}

#[test]
fn loads_sum_to_pressure_times_area() {
    let nodes = corners();
    let area = (nodes[1] - nodes[0]).cross(&(nodes[2] - nodes[0])) * 0.5;
    let sum: Vector3<f64> = shell_pressure_load(&nodes, 3.0).iter().sum();
    assert!((sum + area * 3.0).amax() < 1e-15);
    let tractions = [Vector3::x(), Vector3::y() * 2.0, Vector3::z() * 3.0];
    let forces = shell_traction_load(&nodes, &tractions);
    let sum: Vector3<f64> = forces.iter().sum();
    let expected = Vector3::new(1.0, 2.0, 3.0) * (area.norm() / 3.0);
    assert!((sum - expected).amax() < 1e-15);
    assert!((forces[0].x - area.norm() / 6.0).abs() < 1e-15);
}

#[test]
fn unusable_elements_are_refused_with_their_numbers() {
    let k = |nodes: &[Point3<f64>; 3], directors: Option<&[Vector3<f64>; 3]>, t: f64| {
        shell_stiffness(ShellKind::Thin, nodes, directors, &[0.01, t, 0.01], &material())
    };
    let line = [[0.0; 3], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]].map(Point3::from);
    assert!(matches!(k(&line, None, 0.01), Err(ShellElementProblem::Flat { .. })));
    let nodes = corners();
    let mut directors = leaning(&nodes, 0.0);
    directors[2] = -directors[2];
    let found = k(&nodes, Some(&directors), 0.01);
    assert!(matches!(found, Err(ShellElementProblem::Director { corner: 2, .. })), "{found:?}");
    let found = k(&nodes, None, -0.01).expect_err("a negative thickness");
    assert_eq!(found, ShellElementProblem::Thickness { corner: 1, thickness_m: -0.01 });
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the triangle, the wall and the directors, energy is never negative.
    #[test]
    fn stiffness_is_positive_semidefinite(
        at in prop::array::uniform6(-1.0..1.0_f64),
        lean in -0.3..0.3,
        log_t in -4.0..-0.3,
        thick in any::<bool>(),
    ) {
        let nodes = [
            Point3::origin(),
            Point3::new(1.5 + at[0], at[1], at[2]),
            Point3::new(at[3], 1.5 + at[4], at[5]),
        ];
        let kind = if thick { ShellKind::Thick } else { ShellKind::Thin };
        let t = 10.0_f64.powf(log_t);
        let directors = leaning(&nodes, lean);
        let k = stiffness_of(kind, &nodes, Some(&directors), &[t, 1.2 * t, 0.9 * t]);
        prop_assert_eq!(&k, &k.transpose());
        let values = eigenvalues(&k);
        prop_assert!(values[0] > -1e-12 * values[17], "{:?}", values);
    }
}
