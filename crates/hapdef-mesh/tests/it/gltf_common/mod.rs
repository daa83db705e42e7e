//! Small glTF files made in memory, and the shared inputs.
#![allow(dead_code, reason = "each test binary uses its own part")]

use std::path::{Path, PathBuf};

use hapdef_mesh::{GltfFault, GltfParams, GltfSurface, MeshError, read_gltf};
use serde_json::{Value, json};
use tempfile::TempDir;

/// The corners of a tetrahedron with volume 1/6, and its faces seen from outside.
pub const TETRAHEDRON: ([[f32; 3]; 4], [u16; 12]) = (
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3],
);

/// The tetrahedron as JSON and BIN chunk: indices (24 bytes), then positions (48 bytes).
pub fn tetrahedron() -> (Value, Vec<u8>) {
    let (positions, indices) = TETRAHEDRON;
    let mut bin: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
    bin.extend(positions.iter().flatten().flat_map(|x| x.to_le_bytes()));
    let json = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "shank" }],
        "meshes": [{
            "name": "shell",
            "primitives": [{ "attributes": { "POSITION": 1 }, "indices": 0, "material": 0 }],
        }],
        "materials": [{ "name": "skin" }],
        "buffers": [{ "byteLength": 72 }],
        "bufferViews": [
            { "buffer": 0, "byteLength": 24, "target": 34963 },
            { "buffer": 0, "byteOffset": 24, "byteLength": 48, "target": 34962 },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5123, "count": 12, "type": "SCALAR" },
            { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3",
              "min": [0, 0, 0], "max": [1, 1, 1] },
        ],
    });
    (json, bin)
}

/// A GLB file from its chunks.
pub fn glb(json: &Value, bin: &[u8]) -> Vec<u8> {
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bin = bin.to_vec();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let total = 12 + 8 + json.len() + 8 + bin.len();
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((total as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", bin)] {
        file.extend((chunk.len() as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

/// Reads `bytes` as a file of that name in a folder of its own.
pub fn read_as(name: &str, bytes: &[u8]) -> Result<GltfSurface, MeshError> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read_gltf(&path, &GltfParams::default())
}

/// Reads a GLB file of these chunks.
pub fn read_glb(json: &Value, bin: &[u8]) -> Result<GltfSurface, MeshError> {
    read_as("a.glb", &glb(json, bin))
}

/// The fault a file was refused for.
#[track_caller]
pub fn fault(result: Result<GltfSurface, MeshError>) -> GltfFault {
    match result {
        Err(MeshError::Gltf { fault, .. }) => *fault,
        other => panic!("a glTF fault expected, found {other:?}"),
    }
}

/// The name of a fault's variant.
pub fn kind(fault: &GltfFault) -> String {
    let text = format!("{fault:?}");
    text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().to_owned()
}

/// A folder or file of the shared inputs, or nothing (with the reason printed) where it is absent.
pub fn shared(name: &str) -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");
    let shared = std::env::var("HAPDEF_SHARED").unwrap_or_else(|_| default.to_owned());
    let path = Path::new(&shared).join("inputs").join(name);
    if !path.exists() {
        println!("skipped: {} is absent; set HAPDEF_SHARED", path.display());
        return None;
    }
    Some(path)
}

/// The files below `folder` with this ending, sorted.
pub fn files(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let mut found: Vec<PathBuf> = entries
        .filter(|p| endings.iter().any(|e| p.extension().is_some_and(|x| x == *e)))
        .collect();
    found.sort();
    found
}
