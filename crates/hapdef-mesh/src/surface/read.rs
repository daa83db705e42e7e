//! Surfaces from whatever file they come in.

use std::io;
use std::path::Path;

use nalgebra::Point3;

use crate::gltf::read_bounded;
use crate::{GltfInfo, GltfParams, GltfPart, GltfSurface, MeshError, SurfaceMesh, read_gltf};

/// Reads the triangles of a `.glb`, `.gltf`, `.stl` (words or bytes), `.obj` or `.dae` file.
///
/// The three last have single precision, as the crate `mesh-loader` reads them: faces of more corners
/// are cut into triangles, materials and textures are not looked for. Vertices, of which each triangle
/// has three of its own, are joined where they are the same. A `.dae` states its unit, in which it
/// is read; `params.unit` is then the length of what comes out.
///
/// # Errors
/// As [`read_gltf`]; [`MeshError::SurfaceFile`] for another format that can't be read or has more
/// vertices or triangles than allowed.
pub fn read_surface(path: &Path, params: &GltfParams) -> Result<GltfSurface, MeshError> {
    let read: fn(&[u8]) -> io::Result<mesh_loader::Scene> = match ending(path).as_str() {
        "stl" => mesh_loader::stl::from_slice,
        // no file but the one named is opened
        "obj" => |bytes| {
            let no_material = |_: &Path| Err::<Vec<u8>, _>(io::ErrorKind::NotFound.into());
            mesh_loader::obj::from_slice(bytes, None, no_material)
        },
        "dae" => mesh_loader::collada::from_slice,
        _ => return read_gltf(path, params),
    };
    let refused = |cause: String| MeshError::SurfaceFile { path: path.to_owned(), cause };
    let bytes = read_bounded(path, params.max_bytes)?;
    if bytes.len() as u64 > params.max_bytes {
        return Err(refused(format!("longer than the {} bytes allowed", params.max_bytes)));
    }
    let scene = read(&bytes).map_err(|cause| refused(cause.to_string()))?;
    let surface = assembled(&scene.meshes, params).map_err(refused)?;
    let GltfSurface { mesh, mut parts, info } = surface?;
    let (mesh, welded) = mesh.weld(0.0)?;
    for part in &mut parts {
        let new = |old: usize| welded.old_triangle.partition_point(|triangle| *triangle < old);
        part.triangles = new(part.triangles.start)..new(part.triangles.end);
    }
    Ok(GltfSurface { mesh, parts, info })
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

/// All meshes of a file as one surface, or what is over a limit.
fn assembled(
    meshes: &[mesh_loader::Mesh],
    params: &GltfParams,
) -> Result<Result<GltfSurface, MeshError>, String> {
    let n_vertices: usize = meshes.iter().map(|mesh| mesh.vertices.len()).sum();
    let n_triangles: usize = meshes.iter().map(|mesh| mesh.faces.len()).sum();
    for (what, found, limit) in [
        ("vertices", n_vertices, params.max_vertices),
        ("triangles", n_triangles, params.max_triangles),
    ] {
        if found > limit {
            return Err(format!("{found} {what}, more than the {limit} allowed"));
        }
    }
    let (mut vertices, mut triangles, mut parts) = (Vec::new(), Vec::new(), Vec::new());
    for mesh in meshes.iter().filter(|mesh| !mesh.faces.is_empty()) {
        let (first_vertex, first) = (vertices.len() as u32, triangles.len());
        let length = params.unit.metres();
        let place = |v: &[f32; 3]| Point3::from(v.map(|x| f64::from(x) * length));
        vertices.extend(mesh.vertices.iter().map(place));
        let n = mesh.vertices.len() as u32;
        if let Some(vertex) = mesh.faces.iter().flatten().find(|vertex| **vertex >= n) {
            return Err(format!("a triangle names vertex {vertex} of {n} (0-based)"));
        }
        triangles.extend(mesh.faces.iter().map(|face| face.map(|v| v + first_vertex)));
        parts.push(GltfPart {
            node_name: None,
            mesh_name: Some(mesh.name.clone()).filter(|name| !name.is_empty()),
            material_name: None,
            triangles: first..triangles.len(),
        });
    }
    let info = GltfInfo { n_mesh_nodes: parts.len(), ..GltfInfo::default() };
    Ok(SurfaceMesh::new(vertices, triangles).map(|mesh| GltfSurface { mesh, parts, info }))
}
