//! Surfaces as STL files.

use std::io::Write;
use std::path::Path;

use crate::{MeshError, SurfaceMesh, atomic_write};

/// Writes `mesh` as a binary STL file in millimetres, which slicers take for granted, replacing any file
/// at `path` only once the new one is whole.
///
/// # Errors
/// [`MeshError::Io`] when the disk refuses.
pub fn write_stl(path: &Path, mesh: &SurfaceMesh) -> Result<(), MeshError> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((mesh.triangles().len() as u32).to_le_bytes());
    for triangle in 0..mesh.triangles().len() {
        let normal = mesh.area_normal_m2(triangle).try_normalize(0.0).unwrap_or_default();
        let corners = mesh.corners(triangle).map(|p| p.coords * 1e3);
        let numbers = std::iter::once(normal).chain(corners).flat_map(|v| [v.x, v.y, v.z]);
        bytes.extend(numbers.flat_map(|x| (x as f32).to_le_bytes()));
        bytes.extend([0, 0]);
    }
    let refused = |cause| MeshError::Io { action: "write", path: path.into(), cause };
    atomic_write(path, |file| file.write_all(&bytes)).map_err(refused)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::triangles::tests::cuboid;
    use crate::{GltfParams, LengthUnit, read_surface};

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("box.stl");
        write_stl(&path, &cuboid(0.04, 0.03, 0.05)).unwrap();
        let params = GltfParams { unit: LengthUnit::Millimetre, ..GltfParams::default() };
        let read = read_surface(&path, &params).unwrap().mesh;
        assert_eq!((read.vertices().len(), read.triangles().len()), (8, 12));
        assert!((read.signed_volume_m3() - 6e-5).abs() < 1e-11);
    }
}
