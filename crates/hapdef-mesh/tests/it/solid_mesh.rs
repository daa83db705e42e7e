//! Solid meshes: what is refused, the boundary, and refinement.

use crate::solid_common;

use hapdef_mesh::{
    BoundarySurface, FeNodeId, MeshError, SolidFault, Tet10Mesh, face_positions, kuhn_block, tet10,
    tri6,
};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use solid_common::tube;

fn one_tet() -> (Vec<Point3<f64>>, [FeNodeId; 10]) {
    let corners = [
        Point3::origin(),
        Point3::new(1.0, 0.0, 0.0),
        Point3::new(0.0, 1.0, 0.0),
        Point3::new(0.0, 0.0, 1.0),
    ];
    let mut nodes = corners.to_vec();
    nodes.extend(hapdef_mesh::TET10_EDGES.map(|[a, b]| nalgebra::center(&corners[a], &corners[b])));
    (nodes, std::array::from_fn(FeNodeId::from_index))
}

fn total_volume(mesh: &Tet10Mesh) -> f64 {
    (0..mesh.elements().len()).map(|e| tet10::volume(&mesh.element_positions(e))).sum()
}

/// ∮ dA over the boundary; exact, since area vectors are quadratic.
fn closure(mesh: &Tet10Mesh, boundary: &BoundarySurface) -> Vector3<f64> {
    let of_face = |face: &hapdef_mesh::Tri6Face| -> Vector3<f64> {
        let nodes = face_positions(mesh, face);
        tri6::QUADRATURE.iter().map(|q| tri6::area_vector(&nodes, q.xi, q.eta) * q.weight).sum()
    };
    boundary.faces.iter().map(of_face).sum()
}

#[track_caller]
fn refused(nodes: Vec<Point3<f64>>, elements: Vec<[FeNodeId; 10]>, expected: &SolidFault) {
    match Tet10Mesh::new(nodes, elements) {
        Err(MeshError::Solid(fault)) => assert_eq!(&fault, expected),
        other => panic!("expected {expected:?}, got {other:?}"),
    }
}

#[test]
fn broken_meshes_are_refused_with_the_place() {
    let (nodes, ids) = one_tet();
    refused(nodes.clone(), vec![], &SolidFault::NoElements { n_nodes: 10 });

    let mut bad = ids;
    bad[9] = FeNodeId(10);
    refused(
        nodes.clone(),
        vec![bad],
        &SolidFault::NodeOutOfRange { element: 0, node: 10, n_nodes: 10 },
    );
    bad[9] = FeNodeId(8);
    refused(nodes.clone(), vec![bad], &SolidFault::NodeTwice { element: 0, node: 8 });

    let mut inside_out = ids;
    inside_out.swap(1, 2);
    let fault = SolidFault::CornerVolume { element: 0, volume_m3: -1.0 / 6.0 };
    refused(nodes.clone(), vec![inside_out], &fault);

    let mut extra = nodes.clone();
    extra.push(Point3::new(2.0, 0.0, 0.0));
    refused(extra, vec![ids], &SolidFault::NodeWithoutElement { node: 10 });

    let mut infinite = nodes.clone();
    infinite[3].z = f64::INFINITY;
    let fault = SolidFault::NodeNotFinite { node: 3, position: [0.0, 0.0, f64::INFINITY] };
    refused(infinite, vec![ids], &fault);

    // the same corners with mid-side nodes of their own: a crack along every edge
    let mut doubled = nodes.clone();
    doubled.extend_from_slice(&nodes[4..]);
    let mut twin = ids;
    for (i, id) in twin.iter_mut().enumerate().skip(4) {
        *id = FeNodeId::from_index(i + 6);
    }
    refused(doubled, vec![ids, twin], &SolidFault::EdgeMidsDiffer { ends: [0, 1], mids: [4, 10] });

    let fault = SolidFault::FaceShared { corners: [0, 1, 2], found: 3 };
    refused(nodes, vec![ids; 3], &fault);
}

#[test]
fn a_tetrahedron_s_faces_look_outward() {
    let (nodes, ids) = one_tet();
    let mesh = Tet10Mesh::new(nodes, vec![ids]).unwrap();
    let boundary = mesh.boundary();
    assert_eq!(boundary.faces.len(), 4);
    let inside = Point3::new(0.25, 0.25, 0.25);
    for face in &boundary.faces {
        let p = face_positions(&mesh, face);
        let third = 1.0 / 3.0;
        let outward = tri6::position(&p, third, third) - inside;
        assert!(tri6::area_vector(&p, third, third).dot(&outward) > 0.0, "{face:?}");
        for (k, [a, b]) in [[0, 1], [1, 2], [2, 0]].into_iter().enumerate() {
            assert_eq!(p[3 + k], nalgebra::center(&p[a], &p[b]), "{face:?}");
        }
    }
}

#[test]
fn a_tube_has_the_boundary_and_volume_of_a_tube() {
    let (n, radii_m, height_m) = ([24, 3, 2], [0.034, 0.036], 0.05);
    let mesh = tube(n, radii_m, height_m);
    let boundary = mesh.boundary();
    // two triangles a cell: inside and outside 24 × 3, both ends 24 × 2
    assert_eq!(boundary.faces.len(), 2 * (2 * 24 * 3 + 2 * 24 * 2));
    assert!(closure(&mesh, &boundary).norm() < 1e-15);
    let exact = std::f64::consts::PI * (0.036_f64.powi(2) - 0.034_f64.powi(2)) * height_m;
    let relative = total_volume(&mesh) / exact - 1.0;
    assert!(relative.abs() < 2e-5, "volume off by {relative:e}");
}

#[test]
fn refinement_keeps_geometry_and_ids() {
    let mesh = tube([12, 2, 1], [0.034, 0.036], 0.03);
    let fine = mesh.refine();
    assert_eq!(fine.elements().len(), 8 * mesh.elements().len());
    assert_eq!(fine.nodes()[..mesh.nodes().len()], *mesh.nodes());
    assert_eq!(fine, mesh.refine());
    // conforming: at most two elements a face, one mid-side node an edge, no loose node
    assert_eq!(Tet10Mesh::new(fine.nodes().to_vec(), fine.elements().to_vec()).unwrap(), fine);

    let (coarse_faces, fine_faces) = (mesh.boundary(), fine.boundary());
    assert_eq!(fine_faces.faces.len(), 4 * coarse_faces.faces.len());
    assert!(closure(&fine, &fine_faces).norm() < 1e-15);
    assert!((total_volume(&fine) / total_volume(&mesh) - 1.0).abs() < 1e-12);
    for element in 0..fine.elements().len() {
        let jacobian = tet10::min_gauss_jacobian(&fine.element_positions(element));
        assert!(jacobian > 0.0, "element {element}: {jacobian:e}");
    }
}

/// Where boundary nodes of the parent lie on x² + z² = r², the quadratic faces deviate by order 3:
/// children's mid-side nodes stay on those faces and don't cut the chord.
#[test]
fn refined_nodes_lie_on_the_curved_faces() {
    let mesh = tube([12, 1, 1], [0.034, 0.036], 0.03);
    let fine = mesh.refine();
    let sagitta_m = 0.036 * (1.0 - (std::f64::consts::TAU / 48.0).cos());
    let mut n_outer = 0;
    for node in fine.boundary().nodes() {
        let p = fine.position(node);
        let radius_m = p.x.hypot(p.z);
        if radius_m > 0.0358 {
            n_outer += 1;
            assert!(
                (radius_m - 0.036).abs() < 0.1 * sagitta_m,
                "{} µm off",
                1e6 * (radius_m - 0.036)
            );
        }
    }
    // 48 lines around, 5 along the mid-side nodes included
    assert_eq!(n_outer, 48 * 5);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Eight children fill their parent, however its mid-side nodes bend it.
    #[test]
    fn children_fill_their_parent(bend in proptest::collection::vec(-0.03..0.03_f64, 6)) {
        let mesh = kuhn_block([2, 1, 1], |p| {
            let [x, y, z] = p.into();
            Point3::new(
                x + bend[0] * y * y + bend[1] * z * x,
                y + bend[2] * x * x + bend[3] * z * z,
                z + bend[4] * x * y + bend[5] * y * y,
            )
        })
        .unwrap();
        let fine = mesh.refine();
        for element in 0..mesh.elements().len() {
            let parent = tet10::volume(&mesh.element_positions(element));
            let children: f64 = (8 * element..8 * element + 8)
                .map(|child| tet10::volume(&fine.element_positions(child)))
                .sum();
            prop_assert!((children / parent - 1.0).abs() < 1e-12, "{parent:e} {children:e}");
        }
        prop_assert!(closure(&fine, &fine.boundary()).norm() < 1e-14);
    }
}
