//! A glTF or GLB file to one triangle surface.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::assembly::Assembly;
use super::buffers::{self, BufferSource};
use super::params::{GltfInfo, GltfParams, GltfPart};
use super::source::Source;
use super::{GltfFault, container, document};
use crate::beside::folder_of;
use crate::{MeshError, SurfaceMesh};

/// The surface of a glTF scene, in world coordinates.
#[derive(Clone, Debug)]
pub struct GltfSurface {
    /// All triangles of the scene, part after part; vertices are not shared between parts.
    pub mesh: SurfaceMesh,
    /// Where each triangle comes from, in triangle order without gaps.
    pub parts: Vec<GltfPart>,
    /// What was ignored or looked odd.
    pub info: GltfInfo,
}

/// Reads the triangles of a `.glb` or `.gltf` file: those of the default scene, or of all root
/// nodes where the file names no default scene, or of all meshes where it has no nodes.
///
/// Node transforms are applied, mirrored parts turned over so that they keep facing outward.
/// Triangle lists, strips and fans, with or without indices and sparse accessors, are read.
/// Buffers come from the BIN chunk, from base64 data URIs and from files inside the file's own
/// folder, never from elsewhere.
///
/// # Errors
/// [`MeshError::Io`] when the file can't be read; [`MeshError::Gltf`] for anything malformed,
/// above a limit of `params`, or without a triangle.
pub fn read_gltf(path: &Path, params: &GltfParams) -> Result<GltfSurface, MeshError> {
    let bytes = read_bounded(path, params.max_bytes)?;
    let assembly = parse(path, &bytes, params)
        .map_err(|fault| MeshError::Gltf { path: path.to_owned(), fault: Box::new(fault) })?;
    let mesh = SurfaceMesh::new(assembly.vertices, assembly.triangles)?;
    Ok(GltfSurface { mesh, parts: assembly.parts, info: assembly.info })
}

/// The file's bytes, one more than allowed at most.
pub(crate) fn read_bounded(path: &Path, max_bytes: u64) -> Result<Vec<u8>, MeshError> {
    let failed = |cause| MeshError::Io { action: "read", path: path.to_owned(), cause };
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(failed)?;
    file.take(max_bytes.saturating_add(1)).read_to_end(&mut bytes).map_err(failed)?;
    Ok(bytes)
}

fn parse<'a>(path: &Path, bytes: &[u8], params: &'a GltfParams) -> Result<Assembly<'a>, GltfFault> {
    let limit = params.max_bytes;
    let budget_bytes = limit.checked_sub(bytes.len() as u64).ok_or(GltfFault::Limit {
        what: "bytes of file and buffers",
        param: "max_bytes",
        found: bytes.len() as u64,
        limit,
    })?;
    let (json, bin, n_trailing_bytes) = match extension(path).as_str() {
        "glb" => {
            let glb = container::split(bytes)?;
            (glb.json, glb.bin, glb.n_trailing_bytes)
        }
        "gltf" => (bytes, None, 0),
        other => {
            return Err(GltfFault::FileKind { found: other.to_owned() });
        }
    };
    let root = document::parse(json)?;
    let source = BufferSource { folder: folder_of(path), bin, budget_bytes, limit_bytes: limit };
    let buffers = buffers::load(&root, source)?;
    let mut assembly = Assembly::new(params);
    assembly.info.n_trailing_bytes = n_trailing_bytes;
    assembly.add_scene(&Source { root: &root, buffers: &buffers, params })?;
    Ok(assembly)
}

fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}
