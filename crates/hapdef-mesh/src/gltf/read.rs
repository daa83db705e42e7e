//! A glTF or GLB file to one triangle surface.

use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path;

use super::accessor::Source;
use super::assembly::Assembly;
use super::buffers::{self, BufferSource};
use super::{GltfFault, container, document};
use crate::{LengthUnit, MeshError, SurfaceMesh};

/// What [`read_gltf`] may spend, and how long the file's unit is.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfParams {
    /// The length of one coordinate unit. The format prescribes metres; files exported in another
    /// unit exist ([`UnitGuess`](crate::UnitGuess)).
    pub unit: LengthUnit,
    /// Most bytes of file and buffers together.
    pub max_bytes: u64,
    /// Most vertices of all placed primitives together.
    pub max_vertices: usize,
    /// Most triangles of all placed primitives together.
    pub max_triangles: usize,
}

impl Default for GltfParams {
    /// Metres, 512 MiB, 20 million vertices and as many triangles.
    fn default() -> Self {
        Self {
            unit: LengthUnit::Metre,
            max_bytes: 512 << 20,
            max_vertices: 20_000_000,
            max_triangles: 20_000_000,
        }
    }
}

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

/// One placed primitive.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfPart {
    /// The node's name, if it has one.
    pub node_name: Option<String>,
    /// The mesh's name, if it has one.
    pub mesh_name: Option<String>,
    /// The material's name, if there is a material and it has one.
    pub material_name: Option<String>,
    /// Its triangles in [`GltfSurface::mesh`].
    pub triangles: Range<usize>,
}

/// What [`read_gltf`] left out or noticed. All counts but the first two are over the placed meshes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GltfInfo {
    /// Bytes after the end of the GLB container, ignored as the format asks.
    pub n_trailing_bytes: usize,
    /// Meshes of the file that the scene does not show.
    pub n_unused_meshes: usize,
    /// Nodes with a mesh, or meshes in a file without nodes.
    pub n_mesh_nodes: usize,
    /// Primitives of points, skipped.
    pub n_point_primitives: usize,
    /// Primitives of lines, skipped.
    pub n_line_primitives: usize,
    /// Primitives without positions, skipped.
    pub n_without_position: usize,
    /// Morph targets, ignored: the surface is the undeformed one.
    pub n_morph_targets: usize,
    /// Nodes with a skin, which is ignored: the surface is placed by its node alone.
    pub n_skinned_nodes: usize,
    /// Indices left after the last whole triangle, ignored as the format asks.
    pub n_leftover_indices: usize,
    /// Vertices that no triangle uses, dropped.
    pub n_unused_vertices: usize,
    /// Vertices outside the bounds that their accessor declares: a sign of a damaged file.
    pub n_outside_bounds: usize,
    /// Optional extensions of the file, all ignored.
    pub extensions_ignored: Vec<String>,
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

fn read_bounded(path: &Path, max_bytes: u64) -> Result<Vec<u8>, MeshError> {
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
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let source = BufferSource { folder, bin, budget_bytes, limit_bytes: limit };
    let buffers = buffers::load(&root, source)?;
    let mut assembly = Assembly::new(params);
    assembly.info.n_trailing_bytes = n_trailing_bytes;
    assembly.add_scene(&Source { root: &root, buffers: &buffers, params })?;
    Ok(assembly)
}

fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}
