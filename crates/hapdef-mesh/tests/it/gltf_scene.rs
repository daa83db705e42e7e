//! Where the scene puts its meshes, and how primitives become triangles.

use crate::gltf_common;

use gltf_common::{TETRAHEDRON, fault, kind, read_glb, tetrahedron};
use hapdef_mesh::{GltfSurface, SurfaceMesh};
use nalgebra::{Isometry3, Point3, Rotation3, Vector3};
use proptest::prelude::*;
use serde_json::{Value, json};

/// The tetrahedron placed by these nodes, of which node 0 is the scene's.
fn placed(nodes: Value) -> GltfSurface {
    let (mut json, bin) = tetrahedron();
    json["nodes"] = nodes;
    read_glb(&json, &bin).unwrap_or_else(|e| panic!("{e}"))
}

fn refused(nodes: Value) -> String {
    let (mut json, bin) = tetrahedron();
    json["nodes"] = nodes;
    kind(&fault(read_glb(&json, &bin)))
}

#[track_caller]
fn check_vertices(mesh: &SurfaceMesh, expected: impl Fn(Point3<f64>) -> Point3<f64>) {
    for (found, local) in mesh.vertices().iter().zip(TETRAHEDRON.0) {
        let expected = expected(Point3::from(local.map(f64::from)));
        assert!(nalgebra::distance(found, &expected) < 1e-6, "{found} {expected}");
    }
}

#[test]
fn translation_rotation_and_scale_apply_in_that_order() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let surface = placed(json!([{
        "mesh": 0, "translation": [10, 20, 30], "rotation": [0, 0, half, half], "scale": [1, 2, 3],
    }]));
    // A quarter turn about z takes (x, y) to (-y, x).
    check_vertices(&surface.mesh, |p| Point3::new(10.0 - 2.0 * p.y, 20.0 + p.x, 30.0 + 3.0 * p.z));
    assert!((surface.mesh.signed_volume_m3() - 1.0).abs() < 1e-6);
}

#[test]
fn parents_apply_after_children_and_matrices_are_column_major() {
    let surface = placed(json!([
        { "children": [1], "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1] },
        { "children": [2], "translation": [1, 0, 0] },
        { "mesh": 0, "scale": [2, 2, 2] },
    ]));
    check_vertices(&surface.mesh, |p| {
        let p = Point3::from(2.0 * p.coords) + Vector3::x();
        Point3::new(5.0 - p.y, 6.0 + p.x, 7.0 + p.z)
    });
}

#[test]
fn mirrored_nodes_keep_facing_outward() {
    for scale in [[-1, 1, 1], [1, -1, 1], [-1, -1, -1], [-1, -1, 1]] {
        let mesh = placed(json!([{ "mesh": 0, "scale": scale }])).mesh;
        assert!((mesh.signed_volume_m3() - 1.0 / 6.0).abs() < 1e-12, "{scale:?}");
    }
    // Two mirrors make none.
    let twice = placed(json!([
        { "children": [1], "scale": [-1, 1, 1] },
        { "mesh": 0, "scale": [1, 1, -2] },
    ]));
    assert!((twice.mesh.signed_volume_m3() - 2.0 / 6.0).abs() < 1e-12);
}

#[test]
fn scenes_must_be_trees() {
    let cycle = json!([{ "children": [1] }, { "children": [2] }, { "children": [1], "mesh": 0 }]);
    assert_eq!(refused(cycle), "NodeTwice");
    let two_parents = json!([{ "children": [1, 2] }, { "children": [2] }, { "mesh": 0 }]);
    assert_eq!(refused(two_parents), "NodeTwice");
    assert_eq!(refused(json!([{ "mesh": 0, "children": [0] }])), "SceneNotRoot");
    assert_eq!(refused(json!([{ "mesh": 0 }, { "children": [0] }])), "SceneNotRoot");
    let (mut json, bin) = tetrahedron();
    json.as_object_mut().unwrap().remove("scene");
    json["nodes"] = json!([{ "children": [1], "mesh": 0 }, { "children": [0] }]);
    assert_eq!(kind(&fault(read_glb(&json, &bin))), "NodeTwice");
}

#[test]
fn a_chain_of_a_hundred_thousand_nodes_is_read() {
    let n = 100_000;
    let mut nodes: Vec<Value> = (1..n).map(|child| json!({ "children": [child] })).collect();
    nodes.push(json!({ "mesh": 0 }));
    assert_eq!(placed(Value::Array(nodes)).mesh.triangles().len(), 4);
}

#[test]
fn transforms_that_are_none() {
    let identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
    for node in [
        json!({ "mesh": 0, "scale": [1, 0, 1] }),
        json!({ "mesh": 0, "scale": [1, 1e39, 1] }),
        json!({ "mesh": 0, "rotation": [0, 0, 0, 0] }),
        json!({ "mesh": 0, "rotation": [0, 0, 0, 2] }),
        json!({ "mesh": 0, "matrix": identity, "scale": [1, 1, 1] }),
        json!({ "mesh": 0, "matrix": [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] }),
    ] {
        let found = refused(json!([node]));
        assert!(found == "NodeTransform" || found == "Json", "{node}: {found}");
    }
    // Small is not flat.
    assert_eq!(
        placed(json!([{ "mesh": 0, "scale": [1e-6, 1e-6, 1e-6] }])).mesh.triangles().len(),
        4
    );
}

#[test]
fn the_default_scene_is_read_and_the_rest_reported() {
    let (mut json, bin) = tetrahedron();
    let mesh = json["meshes"][0].clone();
    json["meshes"].as_array_mut().unwrap().push(mesh);
    json["nodes"] = json!([{ "mesh": 0 }, { "mesh": 1 }, { "mesh": 1, "name": "second" }]);
    json["scenes"] = json!([{ "nodes": [0, 1] }, { "nodes": [2] }]);
    json["scene"] = json!(1);
    let one = read_glb(&json, &bin).unwrap();
    assert_eq!((one.parts.len(), one.info.n_unused_meshes), (1, 1));
    assert_eq!(one.parts[0].node_name.as_deref(), Some("second"));
    json.as_object_mut().unwrap().remove("scene");
    let all = read_glb(&json, &bin).unwrap();
    assert_eq!((all.parts.len(), all.info.n_unused_meshes), (3, 0));
    assert_eq!(all.parts[2].triangles, 8..12);
    json.as_object_mut().unwrap().remove("nodes");
    json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(read_glb(&json, &bin).unwrap().parts.len(), 2);
}

/// A primitive of this mode over the tetrahedron's first vertices with these indices.
fn with_mode(mode: u32, indices: &[u16]) -> Result<GltfSurface, hapdef_mesh::MeshError> {
    let (mut json, mut bin) = tetrahedron();
    let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
    bin[..bytes.len()].copy_from_slice(&bytes);
    json["accessors"][0]["count"] = json!(indices.len());
    json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
    read_glb(&json, &bin)
}

#[test]
fn strips_and_fans() {
    let strip = with_mode(5, &[0, 1, 2, 3, 0]).unwrap().mesh;
    assert_eq!(strip.triangles(), [[0, 1, 2], [1, 3, 2], [2, 3, 0]]);
    let fan = with_mode(6, &[3, 0, 1, 2]).unwrap().mesh;
    assert_eq!(fan.triangles(), [[0, 1, 3], [1, 2, 3]]);
    let leftover = with_mode(4, &[0, 1, 2, 3, 0]).unwrap();
    assert_eq!(leftover.mesh.triangles(), [[0, 1, 2]]);
    assert_eq!((leftover.info.n_leftover_indices, leftover.info.n_unused_vertices), (2, 1));
    for mode in [4, 5, 6] {
        assert_eq!(kind(&fault(with_mode(mode, &[0, 1]))), "NoTriangles");
    }
}

#[test]
fn points_and_lines_beside_triangles_are_counted() {
    let (mut json, bin) = tetrahedron();
    let triangles = json["meshes"][0]["primitives"][0].clone();
    let with = |mode: u32| {
        let mut primitive = triangles.clone();
        primitive["mode"] = json!(mode);
        primitive
    };
    json["meshes"][0]["primitives"] =
        json!([with(0), with(1), with(2), triangles, with(3), { "attributes": {} }]);
    let surface = read_glb(&json, &bin).unwrap();
    let info = &surface.info;
    assert_eq!(
        (info.n_point_primitives, info.n_line_primitives, info.n_without_position),
        (1, 3, 1)
    );
    assert_eq!((surface.parts.len(), surface.mesh.triangles().len()), (1, 4));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Reading a moved file is moving the read file.
    #[test]
    fn node_transforms_commute_with_reading(
        angles in [-3.0..3.0, -1.5..1.5, -3.0..3.0],
        shift in [-2.0..2.0, -2.0..2.0, -2.0..2.0],
    ) {
        let rotation = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        let isometry = Isometry3::from_parts(Vector3::from(shift).into(), rotation.into());
        let q = isometry.rotation.coords;
        let moved = placed(json!([{
            "mesh": 0, "translation": shift, "rotation": [q.x, q.y, q.z, q.w],
        }]));
        for (found, local) in moved.mesh.vertices().iter().zip(TETRAHEDRON.0) {
            let expected = isometry * Point3::from(local.map(f64::from));
            prop_assert!(nalgebra::distance(found, &expected) < 1e-6);
        }
        prop_assert!((moved.mesh.signed_volume_m3() - 1.0 / 6.0).abs() < 1e-6);
    }
}
