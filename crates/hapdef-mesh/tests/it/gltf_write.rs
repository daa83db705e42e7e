//! What is written is read back, and the file says what the format asks for.

use crate::gltf_common;

use gltf_common::{files, shared};
use hapdef_mesh::colour::{linear_from_srgb, viridis};
use hapdef_mesh::{
    GltfParams, LengthUnit, MeshError, SurfaceMesh, VertexField, read_gltf, write_glb,
};
use nalgebra::Point3;
use serde_json::Value;
use tempfile::TempDir;

fn tetrahedron() -> SurfaceMesh {
    let (positions, indices) = gltf_common::TETRAHEDRON;
    let vertices = positions.iter().map(|p| Point3::from(p.map(f64::from))).collect();
    let triangles = indices.chunks(3).map(|c| [c[0], c[1], c[2]].map(u32::from)).collect();
    SurfaceMesh::new(vertices, triangles).unwrap()
}

fn written(mesh: &SurfaceMesh, field: Option<&VertexField<'_>>) -> (Value, Vec<u8>) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.glb");
    write_glb(&path, mesh, field).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((u32_at(8), bytes.len() % 4), (bytes.len(), 0));
    let json_end = 20 + u32_at(12);
    assert_eq!(json_end % 4, 0);
    (serde_json::from_slice(&bytes[20..json_end]).unwrap(), bytes[json_end + 8..].to_vec())
}

/// The floats of accessor `index`, by its view.
fn floats(json: &Value, bin: &[u8], index: usize) -> Vec<f32> {
    let view =
        &json["bufferViews"][json["accessors"][index]["bufferView"].as_u64().unwrap() as usize];
    let number = |key: &str| view[key].as_u64().unwrap() as usize;
    let bytes = &bin[number("byteOffset")..number("byteOffset") + number("byteLength")];
    bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn every_limb_survives_writing_and_reading() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.glb");
    write_glb(&path, &tetrahedron(), None).unwrap();
    let mut all = vec![path.clone()];
    all.extend(shared("limbs").iter().flat_map(|f| files(f, &["glb"])));
    for file in all {
        let mesh = read_gltf(&file, &GltfParams::default()).unwrap().mesh;
        write_glb(&path, &mesh, None).unwrap();
        let again = read_gltf(&path, &GltfParams::default()).unwrap();
        assert_eq!(again.mesh, mesh, "{}", file.display());
        assert_eq!(again.info.n_outside_bounds, 0);
    }
}

#[test]
fn a_field_becomes_colours_and_raw_values() {
    let values = [0.0, 1e-6, 2e-6, 4e-6];
    let field = VertexField { name: "displacement_m", values: &values, range: None };
    let (json, bin) = written(&tetrahedron(), Some(&field));
    let attributes = &json["meshes"][0]["primitives"][0]["attributes"];
    let index = |name: &str| attributes[name].as_u64().unwrap() as usize;
    let raw: Vec<f32> = values.iter().map(|&v| v as f32).collect();
    assert_eq!(floats(&json, &bin, index("_FIELD")), raw);
    let colours = floats(&json, &bin, index("COLOR_0"));
    for (i, colour) in colours.chunks(3).enumerate() {
        let expected = linear_from_srgb(viridis(values[i] / 4e-6)).map(|c| c as f32);
        assert_eq!(colour, expected, "vertex {i}");
    }
    let extras = &json["meshes"][0]["extras"];
    assert_eq!(extras["field"], "displacement_m");
    assert_eq!((extras["low"].as_f64(), extras["high"].as_f64()), (Some(0.0), Some(4e-6)));
    for view in json["bufferViews"].as_array().unwrap() {
        assert!(view["target"].is_u64() && view["byteOffset"].as_u64().unwrap() % 4 == 0);
    }
    let position = &json["accessors"][index("POSITION")];
    assert_eq!(position["min"], serde_json::json!([0.0, 0.0, 0.0]));
    assert_eq!(position["max"], serde_json::json!([1.0, 1.0, 1.0]));
}

#[test]
fn a_constant_field_and_a_given_range() {
    let values = [3.0; 4];
    let colours = |range| {
        let field = VertexField { name: "x", values: &values, range };
        let (json, bin) = written(&tetrahedron(), Some(&field));
        floats(&json, &bin, 2)[..3].to_vec()
    };
    let expected = |t| linear_from_srgb(viridis(t)).map(|c| c as f32).to_vec();
    assert_eq!(colours(None), expected(0.0));
    assert_eq!(colours(Some((1.0, 5.0))), expected(0.5));
    assert_eq!(colours(Some((0.0, 1.0))), expected(1.0));
}

#[test]
fn what_cannot_be_written_leaves_no_file() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.glb");
    let refused = |values: &[f64], range| {
        let field = VertexField { name: "x", values, range };
        let error = write_glb(&path, &tetrahedron(), Some(&field)).unwrap_err();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        error
    };
    let error = refused(&[0.0; 3], None);
    assert!(matches!(error, MeshError::FieldLength { expected: 4, found: 3, .. }), "{error}");
    for bad in [f64::NAN, f64::INFINITY, 1e39] {
        let error = refused(&[0.0, bad, 0.0, 0.0], None);
        assert!(matches!(error, MeshError::FieldNotFinite { point: 1, .. }), "{error}");
    }
    for range in [(1.0, 0.0), (0.0, f64::NAN), (f64::MIN, f64::MAX)] {
        let error = refused(&[0.0; 4], Some(range));
        assert!(matches!(error, MeshError::FieldRange { .. }), "{error}");
    }
    let far = tetrahedron().scaled(1e39).unwrap();
    let error = write_glb(&path, &far, None).unwrap_err();
    assert!(matches!(error, MeshError::NotWritable { .. }), "{error}");
    let error = write_glb(&folder.path().join("none/a.glb"), &tetrahedron(), None).unwrap_err();
    assert!(matches!(error, MeshError::Io { action: "write", .. }), "{error}");
}

#[test]
fn a_file_in_inches_is_read_in_metres() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.glb");
    write_glb(&path, &tetrahedron(), None).unwrap();
    let params = GltfParams { unit: LengthUnit::Inch, ..GltfParams::default() };
    let mesh = read_gltf(&path, &params).unwrap().mesh;
    assert!((mesh.signed_volume_m3() / (0.0254_f64.powi(3) / 6.0) - 1.0).abs() < 1e-12);
}
