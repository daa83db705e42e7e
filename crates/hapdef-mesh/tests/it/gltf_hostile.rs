//! Files made to mislead: every one is refused for the right reason, at the right place.

use crate::gltf_common;

use gltf_common::{fault, glb, kind, read_glb, tetrahedron};
use hapdef_mesh::{GltfParams, read_gltf};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Changes one property of the tetrahedron and expects this fault and these words in it.
#[track_caller]
fn check(pointer: &str, value: Value, expected_kind: &str, words: &str) {
    let (mut json, bin) = tetrahedron();
    set(&mut json, pointer, value);
    let fault = fault(read_glb(&json, &bin));
    assert_eq!(kind(&fault), expected_kind, "{fault}");
    assert!(fault.to_string().contains(words), "`{words}` not in: {fault}");
}

fn set(json: &mut Value, pointer: &str, value: Value) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let parent = json.pointer_mut(parent).unwrap();
    match parent {
        Value::Array(items) => items[key.parse::<usize>().unwrap()] = value,
        _ => parent[key] = value,
    }
}

#[test]
fn the_unchanged_tetrahedron_is_read() {
    let (json, bin) = tetrahedron();
    let surface = read_glb(&json, &bin).unwrap();
    assert!((surface.mesh.signed_volume_m3() - 1.0 / 6.0).abs() < 1e-15);
    let part = &surface.parts[0];
    assert_eq!(part.node_name.as_deref(), Some("shank"));
    assert_eq!(part.mesh_name.as_deref(), Some("shell"));
    assert_eq!(part.material_name.as_deref(), Some("skin"));
    assert_eq!(part.triangles, 0..4);
}

#[test]
fn accessor_formats() {
    let words = "accessors[1] (meshes[0].primitives[0].attributes.POSITION) must be VEC3 of FLOAT";
    for kind in ["VEC2", "VEC4", "MAT4", "SCALAR", "vec3"] {
        check("/accessors/1/type", json!(kind), "AccessorFormat", words);
    }
    for component in [5120, 5121, 5122, 5123, 5125, 7] {
        check("/accessors/1/componentType", json!(component), "AccessorFormat", words);
    }
    for component in [5120, 5122, 5126, 0] {
        check("/accessors/0/componentType", json!(component), "AccessorFormat", "accessors[0]");
    }
    check("/accessors/0/type", json!("VEC3"), "AccessorFormat", "accessors[0]");
}

/// 2³² + n would become n in 32 bits, so that another file than the written one is read.
#[test]
fn numbers_beyond_32_bits() {
    let big = |n: u64| json!(4_294_967_296 + n);
    check("/meshes/0/primitives/0/indices", big(0), "JsonNumber", "primitives[0].indices is 42949");
    check("/accessors/0/componentType", big(5123), "JsonNumber", "accessors[0].componentType");
    check("/nodes/0/mesh", big(0), "JsonNumber", "nodes[0].mesh");
    check("/bufferViews/1/byteOffset", json!(u64::MAX), "JsonNumber", "bufferViews[1].byteOffset");
    check("/accessors/1/count", json!(-1), "Json", "line");
    check("/accessors/1/count", json!(1.5), "Json", "line");
}

#[test]
fn ends_of_accessors_and_counts() {
    check("/accessors/1/count", json!(5), "AccessorEnd", "up to 60 of its view, which has 48");
    check("/accessors/1/count", json!(0), "AccessorEmpty", "accessors[1]");
    check("/accessors/1/count", json!(u32::MAX), "Limit", "max_vertices");
    check("/accessors/0/count", json!(u32::MAX), "Limit", "max_triangles");
    check("/accessors/1/byteOffset", json!(4), "AccessorEnd", "up to 52");
    check("/accessors/1/byteOffset", json!(u32::MAX - 3), "AccessorEnd", "which has 48");
}

#[test]
fn ends_of_views_and_buffers() {
    check("/bufferViews/1/byteLength", json!(49), "ViewEnd", "ends at byte 73");
    check("/bufferViews/1/byteOffset", json!(u32::MAX), "ViewEnd", "bufferViews[1]");
    check("/buffers/0/byteLength", json!(76), "BufferShort", "76, but only 72");
    check("/buffers/0/byteLength", json!(71), "ViewEnd", "its buffer at 71");
}

#[test]
fn strides_targets_and_alignment() {
    for stride in [0, 2, 8, 14, 256] {
        check("/bufferViews/1/byteStride", json!(stride), "Stride", "bufferViews[1]");
    }
    check("/bufferViews/1/byteStride", json!(16), "AccessorEnd", "up to 60");
    check("/bufferViews/0/byteStride", json!(4), "ViewUse", "byteStride");
    check("/bufferViews/1/target", json!(34963), "ViewUse", "ELEMENT_ARRAY_BUFFER");
    check("/bufferViews/0/target", json!(34962), "ViewUse", "its target is ARRAY_BUFFER");
    check("/bufferViews/0/target", json!(1), "ViewUse", "neither");
    check("/bufferViews/1/byteOffset", json!(22), "Alignment", "byte 22");
    check("/bufferViews/0/byteOffset", json!(1), "Alignment", "not a multiple of 2");
}

#[test]
fn dangling_references() {
    let primitive = "/meshes/0/primitives/0";
    check(&format!("{primitive}/attributes/POSITION"), json!(2), "Dangling", "accessor 2");
    check(&format!("{primitive}/attributes/NORMAL"), json!(9), "Dangling", "NORMAL");
    check(&format!("{primitive}/indices"), json!(2), "Dangling", "primitives[0].indices");
    check(&format!("{primitive}/material"), json!(1), "Dangling", "material 1");
    check("/accessors/1/bufferView", json!(2), "Dangling", "bufferView 2");
    check("/bufferViews/1/buffer", json!(1), "Dangling", "buffer 1");
    check("/nodes/0/mesh", json!(1), "Dangling", "nodes[0].mesh");
    check("/scenes/0/nodes", json!([0, 1]), "Dangling", "scenes[0].nodes");
    check("/scene", json!(1), "Dangling", "scene 1");
    check("/nodes/0/children", json!([7]), "Dangling", "nodes[0].children");
}

#[test]
fn values_that_are_no_mesh() {
    let (json, mut bin) = tetrahedron();
    bin[2] = 4;
    let out_of_range = fault(read_glb(&json, &bin));
    assert_eq!(
        out_of_range.to_string(),
        "meshes[0].primitives[0].indices[1] is 4, but there are 4 vertices"
    );
    let (json, mut bin) = tetrahedron();
    bin[28..32].copy_from_slice(&f32::NAN.to_le_bytes());
    let not_finite = fault(read_glb(&json, &bin));
    assert!(not_finite.to_string().contains("vertex 0 is at (0, NaN, 0)"), "{not_finite}");
    check("/meshes/0/primitives/0/mode", json!(7), "Mode", "primitives[0].mode");
    check("/accessors/1/bufferView", Value::Null, "AccessorNoData", "would be 0");
    check("/asset/version", json!("1.0"), "AssetVersion", "`1.0`");
    check("/asset/minVersion", json!("2.1"), "AssetVersion", "2.1");
}

#[test]
fn required_extensions_that_move_vertices() {
    for name in ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_mesh_quantization"] {
        check("/extensionsRequired", json!([name]), "RequiredExtension", name);
    }
    let (mut json, bin) = tetrahedron();
    json["extensionsRequired"] = json!(["KHR_materials_unlit"]);
    json["extensionsUsed"] = json!(["KHR_materials_unlit"]);
    assert_eq!(read_glb(&json, &bin).unwrap().info.extensions_ignored, ["KHR_materials_unlit"]);
}

#[test]
fn sparse_accessors() {
    let sparse = |count: u64, indices: &[u16], kind: u32| {
        let (mut json, mut bin) = tetrahedron();
        bin.extend(indices.iter().flat_map(|i| i.to_le_bytes()));
        bin.resize(80, 0);
        bin.extend([2.0_f32, 0.0, 0.0, 0.0, 2.0, 0.0].iter().flat_map(|x| x.to_le_bytes()));
        json["buffers"][0]["byteLength"] = json!(bin.len());
        let views = json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({ "buffer": 0, "byteOffset": 72, "byteLength": 4 }));
        views.push(json!({ "buffer": 0, "byteOffset": 80, "byteLength": 24 }));
        json["accessors"][1]["sparse"] = json!({
            "count": count,
            "indices": { "bufferView": 2, "componentType": kind },
            "values": { "bufferView": 3 },
        });
        (json, bin)
    };
    let refused = |(json, bin): (Value, Vec<u8>)| kind(&fault(read_glb(&json, &bin)));
    let (json, bin) = sparse(2, &[1, 2], 5123);
    let surface = read_glb(&json, &bin).unwrap();
    assert!((surface.mesh.signed_volume_m3() - 4.0 / 6.0).abs() < 1e-15);
    assert_eq!(surface.info.n_outside_bounds, 2);
    assert_eq!(refused(sparse(2, &[2, 1], 5123)), "SparseIndex");
    assert_eq!(refused(sparse(2, &[1, 1], 5123)), "SparseIndex");
    assert_eq!(refused(sparse(2, &[1, 4], 5123)), "SparseIndex");
    assert_eq!(refused(sparse(0, &[1, 2], 5123)), "SparseCount");
    assert_eq!(refused(sparse(5, &[1, 2], 5123)), "SparseCount");
    assert_eq!(refused(sparse(3, &[1, 2], 5123)), "AccessorEnd");
    assert_eq!(refused(sparse(2, &[1, 2], 5126)), "AccessorFormat");
    let (mut json, bin) = sparse(2, &[1, 2], 5123);
    json["bufferViews"][3]["target"] = json!(34962);
    assert_eq!(refused((json, bin)), "ViewUse");
    // Without a view the other vertices are at the origin, as the format says.
    let (mut json, bin) = sparse(2, &[1, 2], 5123);
    json["accessors"][1].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(read_glb(&json, &bin).unwrap().mesh.bounding_box().max.z, 0.0);
}

#[test]
fn limits_hold_for_repeated_meshes() {
    let (mut json, bin) = tetrahedron();
    json["nodes"] = (0..1000).map(|_| json!({ "mesh": 0 })).collect();
    json["scenes"][0]["nodes"] = (0..1000).collect();
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.glb");
    std::fs::write(&path, glb(&json, &bin)).unwrap();
    let read = |max_vertices, max_triangles| {
        read_gltf(&path, &GltfParams { max_vertices, max_triangles, ..GltfParams::default() })
    };
    assert_eq!(read(4000, 4000).unwrap().mesh.triangles().len(), 4000);
    assert_eq!(kind(&fault(read(3999, 4000))), "Limit");
    assert_eq!(kind(&fault(read(4000, 3999))), "Limit");
}
