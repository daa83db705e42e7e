//! Solid meshes with fields for ParaView: VTK XML unstructured grids.
//!
//! Format: VTK File Formats (vtk.org, "XML File Formats"), inline base64 arrays with 64-bit
//! headers, uncompressed, little-endian.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use nalgebra::Vector3;

use crate::{MeshError, Tet10Mesh, atomic_write};

/// `VTK_QUADRATIC_TETRA`: its mid-edge nodes stand in the order of
/// [`TET10_EDGES`](crate::TET10_EDGES).
const QUADRATIC_TETRA: u8 = 24;

/// A field over the FE nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointField<'a> {
    /// Its name with its unit: `displacement_m`.
    pub name: &'a str,
    /// Its values, in node order.
    pub values: PointValues<'a>,
}

/// The values of a [`PointField`], `[n_fe_nodes]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointValues<'a> {
    /// One number per node.
    Scalars(&'a [f64]),
    /// One vector per node.
    Vectors(&'a [Vector3<f64>]),
}

/// Writes `mesh` and fields over its nodes as a `.vtu` file of quadratic tetrahedra, replacing any
/// file at `path` only once the new one is whole.
///
/// # Errors
/// A field of another length or with a value that is not finite; two fields of one name, or an
/// empty name or one with a control character; a failure to write.
pub fn write_vtu(
    path: &Path,
    mesh: &Tet10Mesh,
    point_fields: &[PointField<'_>],
) -> Result<(), MeshError> {
    for (i, field) in point_fields.iter().enumerate() {
        check_name(field.name, point_fields[..i].iter().map(|f| f.name))?;
        check_values(field, mesh.nodes().len())?;
    }
    atomic_write(path, |w| write_document(w, mesh, point_fields)).map_err(|cause| MeshError::Io {
        action: "write",
        path: path.to_owned(),
        cause,
    })
}

impl PointValues<'_> {
    /// All numbers, a vector's components side by side.
    fn flat(&self) -> Vec<f64> {
        match self {
            Self::Scalars(values) => values.to_vec(),
            Self::Vectors(values) => values.iter().flat_map(|v| v.iter().copied()).collect(),
        }
    }

    fn n_components(&self) -> usize {
        match self {
            Self::Scalars(_) => 1,
            Self::Vectors(_) => 3,
        }
    }
}

fn check_name<'a>(name: &str, mut earlier: impl Iterator<Item = &'a str>) -> Result<(), MeshError> {
    let why = match name {
        "" => "it is empty",
        _ if name.chars().any(char::is_control) => "it contains a control character",
        _ if earlier.any(|other| other == name) => "another field has the same name",
        _ => return Ok(()),
    };
    Err(MeshError::FieldName { field: name.to_owned(), why })
}

fn check_values(field: &PointField<'_>, expected: usize) -> Result<(), MeshError> {
    let (flat, n_components) = (field.values.flat(), field.values.n_components());
    let found = flat.len() / n_components;
    if found != expected {
        return Err(MeshError::FieldLength { field: field.name.to_owned(), expected, found });
    }
    match flat.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(at) => {
            let (field, point, value) = (field.name.to_owned(), at / n_components, flat[at]);
            Err(MeshError::FieldNotFinite { field, point, value })
        }
    }
}

fn write_document(
    writer: &mut BufWriter<File>,
    mesh: &Tet10Mesh,
    point_fields: &[PointField<'_>],
) -> io::Result<()> {
    let (n_points, n_cells) = (mesh.nodes().len(), mesh.elements().len());
    writeln!(writer, r#"<?xml version="1.0"?>"#)?;
    writeln!(
        writer,
        r#"<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">"#
    )?;
    writeln!(writer, "<UnstructuredGrid>")?;
    writeln!(writer, r#"<Piece NumberOfPoints="{n_points}" NumberOfCells="{n_cells}">"#)?;
    writeln!(writer, "<PointData>")?;
    for field in point_fields {
        let (name, values) = (escaped(field.name), field.values.flat());
        write_floats(writer, &name, field.values.n_components(), &values)?;
    }
    writeln!(writer, "</PointData>")?;
    writeln!(writer, "<Points>")?;
    let coordinates: Vec<f64> =
        mesh.nodes().iter().flat_map(|p| p.coords.iter().copied()).collect();
    write_floats(writer, "Points", 3, &coordinates)?;
    writeln!(writer, "</Points>")?;
    write_cells(writer, mesh)?;
    writeln!(writer, "</Piece>\n</UnstructuredGrid>\n</VTKFile>")
}

fn write_cells(writer: &mut BufWriter<File>, mesh: &Tet10Mesh) -> io::Result<()> {
    let n_cells = mesh.elements().len() as u64;
    let connectivity = mesh.elements().iter().flatten().flat_map(|n| u64::from(n.0).to_le_bytes());
    let offsets = (1..=n_cells).flat_map(|cell| (10 * cell).to_le_bytes());
    writeln!(writer, "<Cells>")?;
    write_array(writer, "connectivity", "Int64", 1, connectivity.collect())?;
    write_array(writer, "offsets", "Int64", 1, offsets.collect())?;
    write_array(writer, "types", "UInt8", 1, vec![QUADRATIC_TETRA; mesh.elements().len()])?;
    writeln!(writer, "</Cells>")
}

fn write_floats(
    writer: &mut BufWriter<File>,
    name: &str,
    n_components: usize,
    values: &[f64],
) -> io::Result<()> {
    let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    write_array(writer, name, "Float64", n_components, bytes)
}

/// One array: its length in bytes and its bytes, base64 together.
fn write_array(
    writer: &mut BufWriter<File>,
    name: &str,
    kind: &str,
    n_components: usize,
    bytes: Vec<u8>,
) -> io::Result<()> {
    let mut with_header = (bytes.len() as u64).to_le_bytes().to_vec();
    with_header.extend(bytes);
    writeln!(
        writer,
        r#"<DataArray type="{kind}" Name="{name}" NumberOfComponents="{n_components}" format="binary">"#
    )?;
    writeln!(writer, "{}", STANDARD.encode(with_header))?;
    writeln!(writer, "</DataArray>")
}

fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::{FeNodeId, TET10_EDGES};

    fn one_tetrahedron() -> Tet10Mesh {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut nodes: Vec<Point3<f64>> = corners.into_iter().map(Point3::from).collect();
        nodes.extend(TET10_EDGES.map(|[a, b]| nalgebra::center(&nodes[a], &nodes[b])));
        Tet10Mesh::new(nodes, vec![std::array::from_fn(FeNodeId::from_index)]).unwrap()
    }

    /// The bytes of the array called `name`, read as a stranger would: by tag and length header.
    fn array(text: &str, name: &str) -> Vec<u8> {
        let tag = text.find(&format!("Name=\"{name}\"")).unwrap();
        let body = &text[tag..];
        let body = &body[body.find('>').unwrap() + 1..body.find("</DataArray>").unwrap()];
        let bytes = STANDARD.decode(body.trim()).unwrap();
        let (header, data) = bytes.split_at(8);
        assert_eq!(u64::from_le_bytes(header.try_into().unwrap()), data.len() as u64);
        data.to_vec()
    }

    fn floats(text: &str, name: &str) -> Vec<f64> {
        let bytes = array(text, name);
        bytes.chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn integers(text: &str, name: &str) -> Vec<u64> {
        let bytes = array(text, name);
        bytes.chunks(8).map(|b| u64::from_le_bytes(b.try_into().unwrap())).collect()
    }

    #[test]
    fn what_was_written_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vtu");
        let mesh = one_tetrahedron();
        let scalars: Vec<f64> = (0..10).map(|i| f64::from(i) / 3.0).collect();
        let vectors: Vec<_> = (0..10).map(|i| Vector3::new(f64::from(i), -1.5, 1e-300)).collect();
        let fields = [
            PointField { name: "energy <J> & \"more\"", values: PointValues::Scalars(&scalars) },
            PointField { name: "displacement_m", values: PointValues::Vectors(&vectors) },
        ];
        write_vtu(&path, &mesh, &fields).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(r#"NumberOfPoints="10" NumberOfCells="1""#), "{text}");
        assert_eq!(floats(&text, "energy &lt;J&gt; &amp; &quot;more&quot;"), scalars);
        let flat: Vec<f64> = vectors.iter().flat_map(|v| v.iter().copied()).collect();
        assert_eq!(floats(&text, "displacement_m"), flat);
        let nodes: Vec<f64> = mesh.nodes().iter().flat_map(|p| p.coords.iter().copied()).collect();
        assert_eq!(floats(&text, "Points"), nodes);
        assert_eq!(integers(&text, "connectivity"), (0..10).collect::<Vec<_>>());
        assert_eq!(integers(&text, "offsets"), [10]);
        assert_eq!(array(&text, "types"), [24]);
    }

    #[track_caller]
    fn check_refused(fields: &[PointField<'_>], expected: &str) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vtu");
        let error = write_vtu(&path, &one_tetrahedron(), fields).unwrap_err().to_string();
        assert_eq!(error, expected);
        assert!(!path.exists());
    }

    #[test]
    fn bad_fields_are_refused() {
        let field = |name, values| PointField { name, values: PointValues::Scalars(values) };
        check_refused(
            &[field("u", &[1.0; 9])],
            "field `u` has 9 values, but the mesh has 10 points",
        );
        let mut values = [0.0; 10];
        values[7] = f64::NAN;
        check_refused(&[field("u", &values)], "field `u` has NaN at point 7, which is not finite");
        check_refused(
            &[field("u", &[0.0; 10]), field("u", &[0.0; 10])],
            "field name `u` is not usable here: another field has the same name",
        );
        check_refused(&[field("", &[0.0; 10])], "field name `` is not usable here: it is empty");
    }
}
