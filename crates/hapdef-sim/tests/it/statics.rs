//! Laws that every linear-elastic model obeys, and exact solutions.

use crate::common;

use common::{
    cantilever, close, distorted_box, faces_where, material, nodes_where, params, straight_box,
};
use hapdef_mesh::{FaceTraction, FeNodeId};
use hapdef_sim::{
    ComplianceParams, ElasticModel, ElasticParams, IsotropicMaterial, NodalLoad, SimError,
    SolveParams,
};
use nalgebra::{Matrix3, Point3, Vector3};
use proptest::prelude::*;

fn stress(material: &IsotropicMaterial, eps: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * (material.lame_lambda_pa() * eps.trace())
        + eps * (2.0 * material.shear_modulus_pa())
}

/// u = x (a, b, c) is linear and vanishes on the clamped face: tractions σ n reproduce it exactly.
#[test]
fn patch_test_on_a_distorted_mesh() {
    let mesh = distorted_box(3);
    let slope = Vector3::new(1e-3, -2e-3, 0.7e-3);
    let grad = slope * Vector3::x().transpose();
    let sigma = stress(&material(), &((grad + grad.transpose()) * 0.5));
    let mut tractions = Vec::new();
    for (axis, at) in [(0, 1.0), (1, 0.0), (1, 1.0), (2, 0.0), (2, 1.0)] {
        let normal = Vector3::ith(axis, 2.0 * at - 1.0);
        let on = |p: &Point3<f64>| (p[axis] - at).abs() < 1e-12;
        let faces = faces_where(&mesh, on);
        assert_eq!(faces.len(), 18);
        let traction_pa = sigma * normal;
        tractions.extend(faces.iter().map(|f| FaceTraction { nodes: f.nodes, traction_pa }));
    }
    let load = NodalLoad::traction(&mesh, &tractions).expect("valid faces");
    let clamped = nodes_where(&mesh, |p| p.x == 0.0);
    let model = ElasticModel::build(&mesh, &params(clamped)).expect("clamped");
    let (u, _) = model.solve(&load).expect("solved");
    let worst =
        mesh.nodes().iter().zip(&u).map(|(p, u)| (u - slope * p.x).norm()).fold(0.0, f64::max);
    assert!(worst < 1e-10 * slope.norm(), "the patch test misses by {worst:e}");
}

#[test]
fn results_are_the_same_bit_for_bit_on_any_number_of_threads() {
    let mesh = straight_box([12, 3, 2], [0.1, 0.02, 0.01]);
    let clamped = nodes_where(&mesh, |p| p.x == 0.0);
    let free = nodes_where(&mesh, |p| p.x > 0.0);
    let loads: Vec<NodalLoad> =
        free.iter().map(|&n| NodalLoad::nodal(n, Vector3::new(0.3, -1.0, 0.5))).collect();
    assert!(loads.len() > 300, "several blocks");
    let solve = |n_threads: usize| {
        let params = ElasticParams { n_threads, ..params(clamped.clone()) };
        let model = ElasticModel::build(&mesh, &params).expect("clamped");
        model.compliance(&loads, &free, &ComplianceParams::default()).expect("solved").0
    };
    let one = solve(1);
    assert!(one == solve(2), "two threads differ from one");
    assert!(one == solve(3), "three threads differ from one");
}

#[test]
fn compliance_and_rigidity_agree_with_single_solves() {
    let (mesh, model) = cantilever([8, 2, 2]);
    let nodes = nodes_where(&mesh, |p| p.z == 0.01 && p.x > 0.0);
    let loads: Vec<NodalLoad> =
        nodes.iter().map(|&n| NodalLoad::nodal(n, Vector3::new(0.0, 0.0, -1.0))).collect();
    let (compliance, info) =
        model.compliance(&loads, &nodes, &ComplianceParams::default()).expect("solved");
    assert_eq!((compliance.n_loads(), compliance.n_wanted()), (nodes.len(), nodes.len()));
    assert!(info.worst_backward_error < 1e-14, "{info:?}");
    let (own, _) = model.rigidity_map(&nodes, &loads, &SolveParams::default()).expect("solved");
    for i in (0..nodes.len()).step_by(7) {
        let (u, _) = model.solve(&loads[i]).expect("solved");
        for (j, node) in nodes.iter().enumerate() {
            let miss = (compliance.displacement(i, j) - u[node.index()]).norm();
            assert!(miss < 1e-12 * u[nodes[i].index()].norm(), "load {i}, node {j}: {miss:e}");
        }
        close(own[i], u[nodes[i].index()].norm(), 1e-12);
    }
}

#[test]
fn stiffness_scale_divides_displacement() {
    let (mesh, model) = cantilever([4, 1, 1]);
    let scale = vec![4.0; mesh.elements().len()];
    let stiffer = model.with_stiffness(&mesh, &material(), Some(&scale)).expect("same mesh");
    let load = NodalLoad::nodal(nodes_where(&mesh, |p| p.x == 0.1)[0], Vector3::new(1.0, 2.0, 3.0));
    let (u, _) = model.solve(&load).expect("solved");
    let (v, _) = stiffer.solve(&load).expect("solved");
    for (u, v) in u.iter().zip(&v) {
        assert!((u - v * 4.0).norm() <= 1e-12 * u.norm());
    }
    assert_eq!(stiffer.info().order_s, 0.0);
}

#[test]
fn unusable_input_is_refused() {
    let (mesh, model) = cantilever([2, 1, 1]);
    let far = FeNodeId::from_index(mesh.nodes().len());
    let solve = |load: &NodalLoad| model.solve(load).expect_err("refused");
    let error = solve(&NodalLoad::nodal(far, Vector3::x()));
    assert!(matches!(error, SimError::NodeOutOfRange { .. }), "{error}");
    let error = solve(&NodalLoad::nodal(FeNodeId(0), Vector3::new(0.0, f64::NAN, 0.0)));
    assert!(matches!(error, SimError::LoadNotFinite { .. }), "{error}");

    let budget = ComplianceParams { max_bytes: 1000, ..ComplianceParams::default() };
    let loads = [NodalLoad::nodal(FeNodeId(0), Vector3::x())];
    let error = model.compliance(&loads, &[FeNodeId(0)], &budget).expect_err("over budget");
    assert!(matches!(error, SimError::OverBudget { allowed_bytes: 1000, .. }), "{error}");

    let build = |params: ElasticParams| ElasticModel::build(&mesh, &params).expect_err("refused");
    let clamped = nodes_where(&mesh, |p| p.x == 0.0);
    let error = build(ElasticParams { n_threads: 0, ..params(clamped.clone()) });
    assert!(matches!(error, SimError::Parameter { .. }), "{error}");
    let scale = Some(vec![1.0; 3]);
    let error = build(ElasticParams { element_stiffness_scale: scale, ..params(clamped.clone()) });
    assert!(matches!(error, SimError::Length { found: 3, .. }), "{error}");
    let mut scale = vec![1.0; mesh.elements().len()];
    scale[5] = -1.0;
    let error = build(ElasticParams { element_stiffness_scale: Some(scale), ..params(clamped) });
    assert!(matches!(error, SimError::StiffnessScale { element: 5, .. }), "{error}");
    for (e, nu, rho) in [(0.0, 0.3, 1.0), (1.0, 0.5, 1.0), (1.0, -1.0, 1.0), (1.0, 0.3, f64::NAN)] {
        let error = IsotropicMaterial::new(e, nu, rho).expect_err("refused");
        assert!(matches!(error, SimError::Material { .. }), "{error}");
    }
}

#[test]
fn a_stiffness_beyond_f64_is_refused() {
    let (mesh, model) = cantilever([4, 1, 1]);
    let scale = vec![1e304; mesh.elements().len()];
    let error = model.with_stiffness(&mesh, &material(), Some(&scale)).expect_err("refused");
    assert!(matches!(error, SimError::NotPositiveDefinite { .. }), "{error}");
}

#[test]
fn a_reused_analysis_refuses_another_mesh() {
    let (_, model) = cantilever([4, 1, 1]);
    let other = straight_box([1, 4, 1], [0.1, 0.02, 0.01]);
    let error = model.with_stiffness(&other, &material(), None).expect_err("refused");
    assert!(matches!(error, SimError::OtherMesh { .. }), "{error}");
    let larger = straight_box([5, 1, 1], [0.1, 0.02, 0.01]);
    let error = model.with_stiffness(&larger, &material(), None).expect_err("refused");
    assert!(matches!(error, SimError::Length { expected: 81, found: 99, .. }), "{error}");
}

#[test]
fn a_backward_error_above_the_limit_is_refused() {
    let (mesh, model) = cantilever([6, 2, 2]);
    let nodes = nodes_where(&mesh, |p| p.x == 0.1);
    let loads = [NodalLoad::nodal(nodes[0], Vector3::new(1.0, 2.0, 3.0))];
    let strict = SolveParams {
        refine_above: 0.0,
        max_refinements: 1,
        fail_above: 0.0,
        ..SolveParams::default()
    };
    let error = model.rigidity_map(&nodes[..1], &loads, &strict).expect_err("refused");
    assert!(matches!(error, SimError::Residual { n_refinements: 1, .. }), "{error}");
}

proptest! {
    #![proptest_config(common::cases(24))]

    #[test]
    fn solutions_superpose_and_are_reciprocal(
        picks in prop::array::uniform2(0_usize..10_000),
        forces in prop::array::uniform6(-5.0..5.0),
        factor in -3.0..3.0,
    ) {
        let (mesh, model) = cantilever([6, 2, 1]);
        let node = |pick: usize| FeNodeId::from_index(pick % mesh.nodes().len());
        let f = NodalLoad::nodal(node(picks[0]), Vector3::new(forces[0], forces[1], forces[2]));
        let g = NodalLoad::nodal(node(picks[1]), Vector3::new(forces[3], forces[4], forces[5]));
        let (u, _) = model.solve(&f).expect("solved");
        let (v, _) = model.solve(&g).expect("solved");
        let (both, _) = model.solve(&f.plus(&g.scaled(factor))).expect("solved");
        let size = u.iter().chain(&v).map(|u| u.norm()).fold(0.0, f64::max);
        for ((u, v), both) in u.iter().zip(&v).zip(&both) {
            prop_assert!((u + v * factor - both).norm() <= 1e-11 * size);
        }
        let (fv, gu) = (f.work_j(&v).expect("own"), g.work_j(&u).expect("own"));
        prop_assert!((fv - gu).abs() <= 1e-11 * 10.0 * size, "{fv:e} against {gu:e}");
        let energy = model.strain_energy_j(&u).expect("full field");
        prop_assert!((energy - 0.5 * f.work_j(&u).expect("own")).abs() <= 1e-11 * energy);
    }
}
