//! Files nobody here wrote: the Khronos validator's cases, primitive modes, samples.

use crate::gltf_common;

use std::path::Path;

use base64::Engine;
use gltf_common::{fault, files, kind, read_as, shared};
use hapdef_mesh::{GltfParams, read_gltf};
use serde_json::{Value, json};

/// Validator errors that do not touch what a surface is made of, or whose data have only one
/// reading; files with no other errors may be accepted.
const HARMLESS_ERRORS: &[(&str, &str)] = &[
    ("MESH_INVALID_WEIGHTS_COUNT", "morph targets are ignored, and reported as such"),
    ("MESH_PRIMITIVES_UNEQUAL_TARGETS_COUNT", "morph targets are ignored"),
    ("MESH_PRIMITIVE_MORPH_TARGET_NO_BASE_ACCESSOR", "morph targets are ignored"),
    ("MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT", "morph targets are ignored"),
    ("MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH", "skins are ignored"),
    ("MESH_PRIMITIVE_INVALID_ATTRIBUTE", "other attributes are not read"),
    ("MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY", "texture coordinates are not read"),
    ("MESH_PRIMITIVE_TOO_FEW_TEXCOORDS", "texture coordinates are not read"),
    ("MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT", "other attributes are not read"),
    ("MESH_PRIMITIVE_ACCESSOR_UNALIGNED", "it is the colours that are unaligned, not read"),
    ("MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS", "bounds are computed from the positions"),
    ("MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE", "without a stride, tight is the only reading"),
    ("UNRESOLVED_REFERENCE", "where it is a morph target's; others must be refused, see below"),
];

/// What each file with an error that concerns a surface must be refused for.
const REFUSED_FOR: &[(&str, &str)] = &[
    ("bom.glb", "Json"),
    ("chunk_too_big.glb", "GlbLength"),
    ("empty_file.glb", "GlbHeaderShort"),
    ("empty_json_chunk.glb", "GlbChunk"),
    ("empty_json_object.glb", "Json"),
    ("invalid_json_chunk.glb", "Json"),
    ("invalid_magic.glb", "GlbMagic"),
    ("invalid_version.glb", "GlbVersion"),
    ("json_and_two_buffers.glb", "GlbChunkOrder"),
    ("length_mismatch.glb", "GlbLength"),
    ("misplaced_bin_chunk.glb", "GlbChunkOrder"),
    ("no_header.glb", "GlbHeaderShort"),
    ("only_bin_chunk.glb", "GlbChunkOrder"),
    ("only_header.glb", "GlbLength"),
    ("truncated_chunk_data.glb", "GlbLength"),
    ("truncated_chunk_header.glb", "GlbLength"),
    ("two_bin_chunks.glb", "GlbChunkOrder"),
    ("two_empty_bin_chunks.glb", "GlbChunkOrder"),
    ("two_empty_json_chunks.glb", "GlbChunk"),
    ("two_valid_json_chunks.glb", "GlbChunkOrder"),
    ("unaligned_chunk.glb", "GlbChunk"),
    ("unknown_chunk.glb", "GlbChunkOrder"),
    ("zero_chunk_header.glb", "GlbChunkOrder"),
    ("zero_length.glb", "GlbLength"),
    // Well-formed containers without a mesh.
    ("extra_data.glb", "NoTriangles"),
    ("two_images.glb", "NoTriangles"),
    ("valid.glb", "NoTriangles"),
    ("valid_buffer.glb", "NoTriangles"),
    ("accessor_unequal_count.gltf", "AttributeCount"),
    ("bufferview_target_override.gltf", "ViewUse"),
    ("empty_array.gltf", "NoTriangles"),
    ("empty_object.gltf", "Json"),
    ("indices_bytestride.gltf", "ViewUse"),
    ("indices_invalid_format.gltf", "AccessorFormat"),
    ("invalid_tangent.gltf", "NoTriangles"),
    ("position_accessor_invalid_format.gltf", "AccessorFormat"),
    ("primitive_no_position.gltf", "NoTriangles"),
    ("unresolved_indices.gltf", "Dangling"),
    ("unresolved_material.gltf", "Dangling"),
    ("unresolved_positions.gltf", "Dangling"),
];

/// Files with errors of [`HARMLESS_ERRORS`] or none: read, with as many triangles as the validator
/// counts, once the data that these cases leave out are supplied.
const ACCEPTED: &[&str] = &[
    "accessor_attribute_uint32.gltf",
    "accessor_unaligned.gltf",
    "accessor_without_bytestride.gltf",
    "custom_property.gltf",
    "invalid_attribute.gltf",
    "invalid_attribute_escaped_name.gltf",
    "invalid_indexed_attribute.gltf",
    "morph_attribute_invalid_count.gltf",
    "morph_attribute_no_base.gltf",
    "morph_bufferview_target_override.gltf",
    "morph_position_accessor_no_bounds.gltf",
    "morph_unequal_targets_count.gltf",
    "morph_weights_wrong_count.gltf",
    "position_accessor_no_bounds.gltf",
    "primitive_generated_tangent_space.gltf",
    "primitive_incompatible_mode.gltf",
    "unequal_joints.gltf",
    "unresolved_morph_positions.gltf",
    "uv.gltf",
    "valid.gltf",
];

fn name(path: &Path) -> String {
    path.file_name().unwrap().to_string_lossy().into_owned()
}

fn report(path: &Path) -> Value {
    let text = std::fs::read_to_string(path.with_file_name(name(path) + ".report.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn error_codes(report: &Value) -> Vec<String> {
    let messages = report["issues"]["messages"].as_array();
    let is_error = |m: &&Value| m["severity"] == 0;
    let code = |m: &Value| m["code"].as_str().unwrap().to_owned();
    messages.map_or(Vec::new(), |m| m.iter().filter(is_error).map(code).collect())
}

/// The validator's mesh cases describe accessors without bytes. This supplies them: positions on
/// a parabola (no two equal, no three in line), indices 0, 1, 2, …, zeros in shared buffers.
fn with_data(mut json: Value) -> Value {
    let root = json.as_object_mut().unwrap();
    let engine = base64::engine::general_purpose::STANDARD;
    for buffer in root.get_mut("buffers").and_then(Value::as_array_mut).into_iter().flatten() {
        if buffer["uri"].is_null() {
            let bytes = vec![0; buffer["byteLength"].as_u64().unwrap() as usize];
            buffer["uri"] = json!(data_uri(&engine.encode(bytes)));
        }
    }
    let mut accessors = root.remove("accessors").unwrap_or(json!([]));
    for accessor in accessors.as_array_mut().unwrap() {
        if accessor["bufferView"].is_null() {
            let bytes = values(accessor);
            let buffers = array(root, "buffers");
            let buffer = buffers.len();
            let length = bytes.len();
            buffers.push(json!({ "byteLength": length, "uri": data_uri(&engine.encode(bytes)) }));
            let views = array(root, "bufferViews");
            accessor["bufferView"] = json!(views.len());
            views.push(json!({ "buffer": buffer, "byteLength": length }));
        }
    }
    root.insert("accessors".to_owned(), accessors);
    json
}

fn array<'a>(root: &'a mut serde_json::Map<String, Value>, key: &str) -> &'a mut Vec<Value> {
    root.entry(key).or_insert(json!([])).as_array_mut().unwrap()
}

fn data_uri(base64: &str) -> String {
    format!("data:application/octet-stream;base64,{base64}")
}

fn values(accessor: &Value) -> Vec<u8> {
    let count = accessor["count"].as_u64().unwrap();
    let components = match accessor["type"].as_str().unwrap() {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        _ => 4,
    };
    let number = |i: u64, c: u32| i.pow(c + 1) as f32;
    let each = (0..count).flat_map(|i| (0..components).map(move |c| (i, c)));
    match accessor["componentType"].as_u64().unwrap() {
        5126 => each.flat_map(|(i, c)| number(i, c).to_le_bytes()).collect(),
        5125 => each.flat_map(|(i, _)| (i as u32 % 3).to_le_bytes()).collect(),
        5123 => each.flat_map(|(i, _)| (i as u16 % 3).to_le_bytes()).collect(),
        _ => each.map(|(i, _)| i as u8 % 3).collect(),
    }
}

#[test]
fn every_validator_case_is_listed_once_and_consistently() {
    let Some(folder) = shared("gltf/khronos-validator") else {
        return;
    };
    let all =
        [files(&folder.join("glb"), &["glb"]), files(&folder.join("mesh"), &["gltf"])].concat();
    assert_eq!(all.len(), 28 + 32);
    for path in &all {
        let file = name(path);
        let refused = REFUSED_FOR.iter().filter(|(f, _)| *f == file).count();
        let accepted = ACCEPTED.iter().filter(|f| **f == file).count();
        assert_eq!(refused + accepted, 1, "{file}");
        for code in error_codes(&report(path)) {
            let harmless = HARMLESS_ERRORS.iter().any(|(c, _)| *c == code)
                || (code == "BUFFER_VIEW_TARGET_OVERRIDE" && file.starts_with("morph_"));
            assert!(refused == 1 || harmless, "{file}: {code} must be refused");
        }
    }
}

#[test]
fn validator_containers_are_refused_for_what_is_wrong_with_them() {
    let Some(folder) = shared("gltf/khronos-validator/glb") else {
        return;
    };
    for path in files(&folder, &["glb"]) {
        let fault = fault(read_gltf(&path, &GltfParams::default()));
        let expected = REFUSED_FOR.iter().find(|(f, _)| *f == name(&path)).unwrap().1;
        assert_eq!(kind(&fault), expected, "{}: {fault}", name(&path));
    }
}

#[test]
fn validator_meshes_are_read_or_refused_for_what_is_wrong_with_them() {
    let Some(folder) = shared("gltf/khronos-validator/mesh") else {
        return;
    };
    for path in files(&folder, &["gltf"]) {
        let (file, report) = (name(&path), report(&path));
        let json: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let read = read_as(&file, with_data(json).to_string().as_bytes());
        if let Some((_, expected)) = REFUSED_FOR.iter().find(|(f, _)| *f == file) {
            let fault = fault(read);
            assert_eq!(kind(&fault), *expected, "{file}: {fault}");
        } else {
            let surface = read.unwrap_or_else(|e| panic!("{file}: {e}"));
            let expected = report["info"]["totalTriangleCount"].as_u64().unwrap();
            assert_eq!(surface.mesh.triangles().len() as u64, expected, "{file}");
        }
        // As they are, without data, none has a surface, and each says why.
        fault(read_gltf(&path, &GltfParams::default()));
    }
}

#[test]
fn primitive_modes() {
    let Some(folder) = shared("gltf/primitive-modes") else {
        return;
    };
    let all = files(&folder, &["gltf"]);
    assert_eq!(all.len(), 10);
    for path in all {
        let json: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        let mode = json["meshes"][0]["primitives"][0]["mode"].as_u64().unwrap_or(4);
        let read = read_gltf(&path, &GltfParams::default());
        if mode < 4 {
            let fault = fault(read);
            assert_eq!(kind(&fault), "NoTriangles", "{}: {fault}", path.display());
        } else {
            // Each is the same unit square, cut in two.
            let mesh = read.unwrap_or_else(|e| panic!("{e}")).mesh;
            assert_eq!(mesh.triangles().len(), 2, "{}", path.display());
            assert!((mesh.area_m2() - 1.0).abs() < 1e-12, "{}", path.display());
            let normals = [0, 1].map(|t| mesh.area_normal_m2(t).z);
            assert_eq!(normals[0], normals[1], "{}: one side is turned over", path.display());
        }
    }
}

#[test]
fn samples() {
    let Some(folder) = shared("gltf") else { return };
    let read = |file: &str| read_gltf(&folder.join(file), &GltfParams::default()).unwrap();
    let triangle = read("TriangleWithoutIndices.gltf").mesh;
    assert_eq!((triangle.triangles().len(), triangle.area_m2()), (1, 0.5));
    // The sparse values lift three vertices of a strip of 2 × 6 squares: the maximum y is 4.
    let sparse = read("SimpleSparseAccessor.gltf").mesh;
    assert_eq!((sparse.vertices().len(), sparse.triangles().len()), (14, 12));
    let max = sparse.bounding_box().max;
    assert_eq!([max.x, max.y, max.z], [6.0, 4.0, 0.0]);
}
