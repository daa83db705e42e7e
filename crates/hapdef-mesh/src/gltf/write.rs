//! A triangle surface to a GLB file, coloured by a field if wanted.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use serde_json::{Value, json};

use crate::colour::{linear_from_srgb, viridis};
use crate::{MeshError, SurfaceMesh, atomic_write};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// A number at every vertex, to be shown as colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexField<'a> {
    /// What it is, with its unit: `displacement_m`.
    pub name: &'a str,
    /// The values `[n_vertices]`, finite.
    pub values: &'a [f64],
    /// The values drawn in the first and the last colour; the smallest and the largest value when
    /// not given.
    pub range: Option<(f64, f64)>,
}

/// Writes `mesh` as a GLB file, metres in 32-bit floats, replacing any file at `path` only once
/// the new one is whole.
///
/// A field becomes vertex colours (`COLOR_0`, the map [`viridis`], made linear as section 3.7.2.1
/// asks) and, unrounded but for 32 bits, the custom attribute `_FIELD`; its name and colour range
/// are in the mesh's `extras`.
///
/// # Errors
/// A field of another length, with a value that is not finite or beyond 32-bit floats, or with a
/// bad range; a coordinate beyond 32-bit floats; a surface beyond the 4 GiB a GLB file can hold; a
/// failure to write.
pub fn write_glb(
    path: &Path,
    mesh: &SurfaceMesh,
    field: Option<&VertexField<'_>>,
) -> Result<(), MeshError> {
    let mut parts = Parts::default();
    let indices: Vec<u8> =
        mesh.triangles().iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
    let n_indices = 3 * mesh.triangles().len();
    parts.add(indices, ELEMENT_ARRAY_BUFFER, accessor("SCALAR", UNSIGNED_INT, n_indices));
    add_positions(&mut parts, path, mesh)?;
    let mut attributes = json!({ "POSITION": 1 });
    let mut extras = json!({});
    if let Some(field) = field {
        let (low, high) = checked_range(field, mesh.vertices().len())?;
        add_field(&mut parts, field, (low, high))?;
        attributes = json!({ "POSITION": 1, "COLOR_0": 2, "_FIELD": 3 });
        extras = json!({ "field": field.name, "low": low, "high": high });
    }
    let document = document(&parts, &attributes, &extras);
    let (json, bin) = (padded(document.to_string().into_bytes(), b' '), parts.bytes);
    let total = 12 + 8 + json.len() + 8 + bin.len();
    if u32::try_from(total).is_err() {
        let what = format!("{total} bytes are more than a GLB file can hold");
        return Err(MeshError::NotWritable { path: path.to_owned(), what });
    }
    atomic_write(path, |w| write_chunks(w, total as u32, &json, &bin))
        .map_err(|cause| MeshError::Io { action: "write", path: path.to_owned(), cause })
}

/// The BIN chunk and the JSON that describes it, one view and one accessor per array.
#[derive(Default)]
struct Parts {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Parts {
    fn add(&mut self, bytes: Vec<u8>, target: u32, mut accessor: Value) {
        accessor["bufferView"] = json!(self.views.len());
        self.views.push(json!({
            "buffer": 0,
            "byteOffset": self.bytes.len(),
            "byteLength": bytes.len(),
            "target": target,
        }));
        self.accessors.push(accessor);
        // Every element has a multiple of four bytes, so the next view is aligned.
        self.bytes.extend(bytes);
    }
}

fn accessor(kind: &str, component: u32, count: usize) -> Value {
    json!({ "type": kind, "componentType": component, "count": count })
}

fn add_positions(parts: &mut Parts, path: &Path, mesh: &SurfaceMesh) -> Result<(), MeshError> {
    let positions: Vec<[f32; 3]> =
        mesh.vertices().iter().map(|v| [v.x as f32, v.y as f32, v.z as f32]).collect();
    if let Some(vertex) = positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        let at = mesh.vertices()[vertex];
        let what = format!("vertex {vertex} is at {at}, beyond 32-bit floats");
        return Err(MeshError::NotWritable { path: path.to_owned(), what });
    }
    let (mut min, mut max) = (positions[0], positions[0]);
    for position in &positions {
        for i in 0..3 {
            min[i] = min[i].min(position[i]);
            max[i] = max[i].max(position[i]);
        }
    }
    let mut description = accessor("VEC3", FLOAT, positions.len());
    description["min"] = json!(min);
    description["max"] = json!(max);
    parts.add(float_bytes(positions.into_iter().flatten()), ARRAY_BUFFER, description);
    Ok(())
}

fn add_field(
    parts: &mut Parts,
    field: &VertexField<'_>,
    (low, high): (f64, f64),
) -> Result<(), MeshError> {
    let beyond = |v: &f64| !(*v as f32).is_finite();
    if let Some(point) = field.values.iter().position(beyond) {
        let value = field.values[point];
        return Err(MeshError::FieldNotFinite { field: field.name.to_owned(), point, value });
    }
    let n = field.values.len();
    // A field that is the same everywhere gets the first colour.
    let part = |v: f64| {
        if high > low { (v - low) / (high - low) } else { 0.0 }
    };
    let colours = field.values.iter().flat_map(|&v| linear_from_srgb(viridis(part(v))));
    let colours = float_bytes(colours.map(|c| c as f32));
    parts.add(colours, ARRAY_BUFFER, accessor("VEC3", FLOAT, n));
    let values = float_bytes(field.values.iter().map(|&v| v as f32));
    parts.add(values, ARRAY_BUFFER, accessor("SCALAR", FLOAT, n));
    Ok(())
}

/// The colour range, after checking the field's length and the range itself.
fn checked_range(field: &VertexField<'_>, expected: usize) -> Result<(f64, f64), MeshError> {
    let name = || field.name.to_owned();
    let found = field.values.len();
    if found != expected {
        return Err(MeshError::FieldLength { field: name(), expected, found });
    }
    let smallest = field.values.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = field.values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (low, high) = field.range.unwrap_or((smallest, largest));
    if !(low.is_finite() && high.is_finite() && low <= high && (high - low).is_finite()) {
        if let Some(point) = field.values.iter().position(|v| !v.is_finite()) {
            let value = field.values[point];
            return Err(MeshError::FieldNotFinite { field: name(), point, value });
        }
        return Err(MeshError::FieldRange { field: name(), low, high });
    }
    Ok((low, high))
}

fn document(parts: &Parts, attributes: &Value, extras: &Value) -> Value {
    json!({
        "asset": { "version": "2.0", "generator": "hapdef" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{
            "primitives": [{ "attributes": attributes, "indices": 0, "material": 0, "mode": 4 }],
            "extras": extras,
        }],
        // Without a material a viewer shows polished metal, which hides the colours.
        "materials": [{
            "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 },
            "doubleSided": true,
        }],
        "buffers": [{ "byteLength": parts.bytes.len() }],
        "bufferViews": parts.views,
        "accessors": parts.accessors,
    })
}

fn write_chunks(
    writer: &mut BufWriter<File>,
    total: u32,
    json: &[u8],
    bin: &[u8],
) -> io::Result<()> {
    writer.write_all(b"glTF")?;
    writer.write_all(&2_u32.to_le_bytes())?;
    writer.write_all(&total.to_le_bytes())?;
    for (kind, data) in [(b"JSON", json), (b"BIN\0", bin)] {
        // Both fit: their sum is `total`.
        writer.write_all(&(data.len() as u32).to_le_bytes())?;
        writer.write_all(kind)?;
        writer.write_all(data)?;
    }
    Ok(())
}

fn padded(mut bytes: Vec<u8>, filler: u8) -> Vec<u8> {
    bytes.resize(bytes.len().next_multiple_of(4), filler);
    bytes
}

fn float_bytes(values: impl Iterator<Item = f32>) -> Vec<u8> {
    values.flat_map(f32::to_le_bytes).collect()
}
