//! Damaged files: whatever the bytes, the reader answers with a mesh or a fault, never a panic.

use crate::gltf_common;

use std::collections::BTreeMap;
use std::panic::catch_unwind;
use std::path::Path;

use gltf_common::{glb, kind, tetrahedron};
use hapdef_mesh::{GltfParams, MeshError, QualityReport, read_gltf};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Small limits, so that a damaged count costs no memory.
fn params() -> GltfParams {
    let small = 100_000;
    let (max_vertices, max_triangles) = (small, small);
    GltfParams { max_bytes: 1 << 20, max_vertices, max_triangles, ..GltfParams::default() }
}

/// A scene with everything the reader knows: a tree of nodes, three meshes, a strip, sparse
/// positions, a stride, 8- and 16-bit indices, a morph target, a buffer inside the JSON.
fn rich() -> (Value, Vec<u8>) {
    let (mut json, mut bin) = tetrahedron();
    bin.extend([1_u8, 3, 0, 0]);
    bin.extend([3.0_f32, 0.0, 0.0, 0.0, 0.0, 3.0].iter().flat_map(|x| x.to_le_bytes()));
    bin.extend([0_u8, 1, 2, 3]);
    json["buffers"] = json!([
        { "byteLength": bin.len() },
        { "byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" },
    ]);
    let views = json["bufferViews"].as_array_mut().unwrap();
    views.push(json!({ "buffer": 0, "byteOffset": 72, "byteLength": 2 }));
    views.push(json!({ "buffer": 0, "byteOffset": 76, "byteLength": 24 }));
    views.push(json!({ "buffer": 0, "byteOffset": 100, "byteLength": 4, "target": 34963 }));
    views.push(json!({ "buffer": 1, "byteLength": 36, "byteStride": 12, "target": 34962 }));
    views.push(json!({ "buffer": 0, "byteOffset": 24, "byteLength": 48, "target": 34962 }));
    let accessors = json["accessors"].as_array_mut().unwrap();
    accessors.push(json!({
        "bufferView": 6, "componentType": 5126, "count": 4, "type": "VEC3",
        "min": [0, 0, 0], "max": [3, 1, 3],
        "sparse": {
            "count": 2,
            "indices": { "bufferView": 2, "componentType": 5121 },
            "values": { "bufferView": 3 },
        },
    }));
    accessors.push(json!({ "bufferView": 4, "componentType": 5121, "count": 4, "type": "SCALAR" }));
    accessors.push(json!({
        "bufferView": 5, "componentType": 5126, "count": 3, "type": "VEC3",
        "min": [0, 0, 0], "max": [1, 1, 0],
    }));
    let meshes = json["meshes"].as_array_mut().unwrap();
    meshes.push(json!({ "primitives": [{
        "attributes": { "POSITION": 2 }, "indices": 3, "mode": 5, "targets": [{ "POSITION": 2 }],
    }]}));
    meshes.push(json!({ "primitives": [{ "attributes": { "POSITION": 4 }, "mode": 4 }] }));
    json["nodes"] = json!([
        { "mesh": 0, "name": "shank", "children": [1, 2], "rotation": [0, 0, 0.6, 0.8] },
        { "mesh": 1, "scale": [-1, 2, 1], "translation": [0.5, 0, 0] },
        { "mesh": 2, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 2, 0, 0, 1] },
    ]);
    (json, bin)
}

/// Reads and looks at the mesh; the kind of answer, or a panic with the case's number.
fn outcome(folder: &Path, bytes: &[u8], case: usize) -> String {
    // A new name each time: overwriting a file makes some file systems wait for the disk.
    let path = &folder.join(format!("{case}.glb"));
    std::fs::write(path, bytes).unwrap();
    let answer = catch_unwind(|| match read_gltf(path, &params()) {
        Ok(surface) => {
            let report = QualityReport::of(&surface.mesh);
            assert!(report.n_triangles > 0);
            assert_eq!(surface.parts.last().unwrap().triangles.end, report.n_triangles);
            let _ = surface.mesh.weld(1e-6);
            "read".to_owned()
        }
        Err(MeshError::Gltf { fault, .. }) => {
            assert!(!fault.to_string().is_empty());
            kind(&fault)
        }
        Err(other) => format!("{other:?}"),
    });
    std::fs::remove_file(path).unwrap();
    answer.unwrap_or_else(|_| panic!("case {case} panicked"))
}

fn below(rng: &mut ChaCha8Rng, n: usize) -> usize {
    rng.next_u32() as usize % n
}

/// Overwrites, inserts, removes or repeats a few bytes anywhere, or cuts the file.
fn damaged_bytes(file: &[u8], rng: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for _ in 0..=below(rng, 4) {
        let at = below(rng, bytes.len().max(1)).min(bytes.len().saturating_sub(1));
        match below(rng, 8) {
            0..=3 if !bytes.is_empty() => bytes[at] = rng.next_u32() as u8,
            4 if !bytes.is_empty() => bytes[at] = b"0123456789-.e,:[]{}\"\\"[below(rng, 21)],
            5 => bytes.insert(at, rng.next_u32() as u8),
            6 if !bytes.is_empty() => drop(bytes.remove(at)),
            _ => {
                if below(rng, 20) == 0 {
                    bytes.truncate(at);
                }
            }
        }
    }
    bytes
}

/// Paths to every value of a document.
fn pointers(value: &Value, prefix: &str, found: &mut Vec<String>) {
    found.push(prefix.to_owned());
    match value {
        Value::Array(items) => items
            .iter()
            .enumerate()
            .for_each(|(i, item)| pointers(item, &format!("{prefix}/{i}"), found)),
        Value::Object(map) => {
            map.iter().for_each(|(key, item)| pointers(item, &format!("{prefix}/{key}"), found));
        }
        _ => {}
    }
}

/// Replaces one value by something hostile: mostly a number by another number.
fn damaged_json(json: &Value, rng: &mut ChaCha8Rng) -> Value {
    let mut json = json.clone();
    let mut all = Vec::new();
    pointers(&json, "", &mut all);
    let number = |p: &&String| json.pointer(p).is_some_and(Value::is_number);
    let all_numbers: Vec<String> = all.iter().filter(number).cloned().collect();
    let mostly_number = !all_numbers.is_empty() && below(rng, 4) > 0;
    let candidates = if mostly_number { &all_numbers } else { &all };
    let pointer = &candidates[below(rng, candidates.len())];
    *json.pointer_mut(pointer).unwrap() = hostile_value(rng, mostly_number);
    json
}

/// Indices, sizes and enum values, right and wrong, and the ends of the integer types.
#[rustfmt::skip]
const HOSTILE_NUMBERS: [u64; 30] = [
    0, 1, 2, 3, 4, 5, 7, 11, 12, 13, 35, 36, 37, 72, 255, 256, 5120, 5121, 5122, 5123, 5125, 5126,
    34962, 34963, 65535, 65536, 4294967295, 4294967296, 18446744073709551614, 18446744073709551615,
];

/// Everything else that a property may be by mistake or malice, as JSON.
const HOSTILE_OTHERS: &str = r#"[null, -1, 0.5, 1e39, -1e308, "", "VEC4", "SCALAR", [], {}, [0],
    [0, 0], [1, 2, 0], [0, 0, 0], true, "../a.bin", "data:;base64,AAAA"]"#;

fn hostile_value(rng: &mut ChaCha8Rng, mostly_number: bool) -> Value {
    if mostly_number && below(rng, 8) > 0 {
        return json!(HOSTILE_NUMBERS[below(rng, HOSTILE_NUMBERS.len())]);
    }
    let others: Vec<Value> = serde_json::from_str(HOSTILE_OTHERS).unwrap();
    let pick = below(rng, HOSTILE_NUMBERS.len() + others.len());
    match HOSTILE_NUMBERS.get(pick) {
        Some(number) => json!(number),
        None => others[pick - HOSTILE_NUMBERS.len()].clone(),
    }
}

fn run(
    n_cases: usize,
    seed: u64,
    mut make: impl FnMut(&mut ChaCha8Rng) -> Vec<u8>,
) -> BTreeMap<String, usize> {
    let folder = TempDir::new().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut outcomes = BTreeMap::new();
    for case in 0..n_cases {
        let bytes = make(&mut rng);
        *outcomes.entry(outcome(folder.path(), &bytes, case)).or_insert(0) += 1;
    }
    println!("{outcomes:?}");
    outcomes
}

#[test]
fn the_undamaged_file_is_read() {
    let (json, bin) = rich();
    let outcomes = run(1, 0, |_| glb(&json, &bin));
    assert_eq!(outcomes["read"], 1);
}

#[test]
fn damaged_bytes_never_panic() {
    let (json, bin) = rich();
    let file = glb(&json, &bin);
    let outcomes = run(20_000, 1, |rng| damaged_bytes(&file, rng));
    assert!(outcomes.len() > 15, "too few kinds of damage were reached: {outcomes:?}");
    assert!(outcomes["read"] > 500, "harmless damage is not told apart from harmful: {outcomes:?}");
}

#[test]
fn damaged_json_never_panics() {
    let (json, bin) = rich();
    let outcomes = run(20_000, 2, |rng| {
        let mut damaged = damaged_json(&json, rng);
        if below(rng, 2) == 0 {
            damaged = damaged_json(&damaged, rng);
        }
        glb(&damaged, &bin)
    });
    assert!(outcomes.len() > 20, "too few kinds of damage were reached: {outcomes:?}");
    assert!(outcomes["read"] > 500, "harmless damage is not told apart from harmful: {outcomes:?}");
}
