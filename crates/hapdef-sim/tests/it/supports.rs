//! Which supports are refused, and what the refusal says.

use crate::common;

use common::{nodes_where, params, straight_box};
use hapdef_mesh::{FeNodeId, Tet10Mesh};
use hapdef_sim::{ElasticModel, FloatingBody, SimError};
use nalgebra::{Point3, Vector3};

fn refused(mesh: &Tet10Mesh, clamped: Vec<FeNodeId>) -> (usize, Vec<FloatingBody>) {
    match ElasticModel::build(mesh, &params(clamped)).expect_err("refused") {
        SimError::FreeRigidModes { n_bodies, bodies } => (n_bodies, bodies),
        other => panic!("{other}"),
    }
}

/// `a` and a copy moved by `offset`; nodes that coincide are joined.
fn with_copy(a: &Tet10Mesh, offset: Vector3<f64>) -> Tet10Mesh {
    let mut nodes = a.nodes().to_vec();
    let ids: Vec<FeNodeId> = a
        .nodes()
        .iter()
        .map(|p| {
            let moved = p + offset;
            let same = a.nodes().iter().position(|q| (q - moved).norm() < 1e-9);
            FeNodeId::from_index(same.unwrap_or_else(|| {
                nodes.push(moved);
                nodes.len() - 1
            }))
        })
        .collect();
    let copy = a.elements().iter().map(|e| e.map(|n| ids[n.index()]));
    let elements = a.elements().iter().copied().chain(copy).collect();
    Tet10Mesh::new(nodes, elements).expect("two valid boxes")
}

#[test]
fn no_clamped_node_leaves_six_motions() {
    let mesh = straight_box([1; 3], [1.0; 3]);
    let (n_bodies, bodies) = refused(&mesh, vec![]);
    assert_eq!((n_bodies, bodies.len()), (1, 1));
    assert_eq!(bodies[0].free.len(), 6);
    let text = bodies[0].to_string();
    for part in ["translation along (1.000, 0.000, 0.000)", "rotation about (0.000, 0.000, 1.000)"]
    {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn one_clamped_node_leaves_three_rotations_about_it() {
    let mesh = straight_box([1; 3], [1.0; 3]);
    let corner = nodes_where(&mesh, |p| p.x == 1.0 && p.y == 1.0 && p.z == 0.0);
    let (_, bodies) = refused(&mesh, corner);
    assert_eq!(bodies[0].free.len(), 3);
    assert_eq!(bodies[0].n_held, 1);
    for motion in &bodies[0].free {
        let at = motion.translation
            + motion.rotation.cross(&(Point3::new(1.0, 1.0, 0.0) - motion.centre_m));
        assert!(at.norm() < 1e-9, "the clamped node moves by {at}");
    }
}

#[test]
fn clamped_nodes_on_a_line_leave_the_rotation_about_it() {
    let mesh = straight_box([2; 3], [1.0; 3]);
    let edge = nodes_where(&mesh, |p| p.x == 0.0 && p.z == 1.0);
    assert_eq!(edge.len(), 5);
    let (_, bodies) = refused(&mesh, edge);
    assert_eq!(bodies[0].free.len(), 1);
    let text = bodies[0].to_string();
    assert!(text.contains("rotation about (0.000, 1.000, 0.000) through (0.0000,"), "{text}");
}

#[test]
fn three_clamped_nodes_off_a_line_hold_a_body() {
    let mesh = straight_box([1; 3], [1.0; 3]);
    let corners = nodes_where(&mesh, |p| p.z == 0.0 && p.x != 0.5 && p.y != 0.5 && p.x + p.y < 1.5);
    assert_eq!(corners.len(), 3);
    ElasticModel::build(&mesh, &params(corners)).expect("held");
}

#[test]
fn a_floating_second_body_is_named() {
    let first = straight_box([1; 3], [1.0; 3]);
    let mesh = with_copy(&first, Vector3::new(3.0, 0.0, 0.0));
    let (n_bodies, bodies) = refused(&mesh, nodes_where(&mesh, |p| p.x == 0.0));
    assert_eq!((n_bodies, bodies.len()), (2, 1));
    assert_eq!((bodies[0].first_element, bodies[0].n_elements), (6, 6));
    assert_eq!(bodies[0].free.len(), 6);
    assert!((bodies[0].centre_m - Point3::new(3.5, 0.5, 0.5)).norm() < 1e-9);
}

#[test]
fn a_hinge_is_found_and_a_clamped_far_side_holds_it() {
    let first = straight_box([1; 3], [1.0; 3]);
    let mesh = with_copy(&first, Vector3::new(1.0, 0.0, 1.0));
    let base = nodes_where(&mesh, |p| p.x == 0.0);
    let (n_bodies, bodies) = refused(&mesh, base.clone());
    assert_eq!((n_bodies, bodies.len()), (1, 1));
    let text = bodies[0].to_string();
    assert!(text.contains("rotation about (0.000, 1.000, 0.000) through (1.0000,"), "{text}");
    let far = nodes_where(&mesh, |p| p.x == 0.0 || p.x == 2.0);
    ElasticModel::build(&mesh, &params(far)).expect("held on both sides");
}

#[test]
fn clamping_everything_or_nodes_that_are_not_there_is_refused() {
    let mesh = straight_box([1; 3], [1.0; 3]);
    let all = nodes_where(&mesh, |_| true);
    let error = ElasticModel::build(&mesh, &params(all)).expect_err("refused");
    assert!(matches!(error, SimError::AllClamped { n_nodes: 27 }), "{error}");
    let error = ElasticModel::build(&mesh, &params(vec![FeNodeId(27)])).expect_err("refused");
    assert!(matches!(error, SimError::NodeOutOfRange { node: 27, n_nodes: 27, .. }), "{error}");
}
