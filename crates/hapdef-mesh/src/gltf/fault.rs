//! What a glTF or GLB file can have wrong, each with its place and the numbers found.

/// Why a glTF or GLB file was refused. Places are written as in the file: `accessors[3].count`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum GltfFault {
    #[error(
        "the name ends in `{found}`, expected `.glb` or `.gltf` (or `.stl`, `.obj`, `.dae`, where any surface is read)"
    )]
    FileKind { found: String },
    #[error(
        "{what}: {found} exceeds the limit of {limit}; raise `GltfParams::{param}` if this is wanted"
    )]
    Limit { what: &'static str, param: &'static str, found: u64, limit: u64 },
    #[error("a GLB header has 12 bytes, the file has {found}")]
    GlbHeaderShort { found: usize },
    #[error("a GLB file begins with 0x46546c67 (`glTF`), found {found:#010x}")]
    GlbMagic { found: u32 },
    #[error("GLB container version 2 expected, found {found}")]
    GlbVersion { found: u32 },
    #[error("the GLB header declares {declared} bytes, the file has {found}")]
    GlbLength { declared: u32, found: usize },
    #[error("GLB chunk at byte {offset}: {problem} (length {length}, {left} bytes left)")]
    GlbChunk { offset: usize, problem: &'static str, length: u32, left: usize },
    #[error("GLB chunk {position} is of type {kind:#010x}: {problem}")]
    GlbChunkOrder { position: usize, kind: u32, problem: &'static str },
    #[error("JSON: {cause}")]
    Json { cause: gltf::json::Error },
    #[error("{place} is {found}, larger than {} can be here", u32::MAX)]
    JsonNumber { place: String, found: u64 },
    #[error("asset.version is `{found}`, expected 2.x (and asset.minVersion at most 2.0)")]
    AssetVersion { found: String },
    #[error(
        "the file requires the extension `{name}`, which changes geometry in a way this reader does not know; export without it"
    )]
    RequiredExtension { name: String },
    #[error("{place} refers to {what} {index}, but the file has {count}")]
    Dangling { place: String, what: &'static str, index: usize, count: usize },
    #[error(
        "buffers[{buffer}].uri {why}: `{uri}`; put the buffer beside the .gltf file or into a .glb"
    )]
    BufferUri { buffer: usize, uri: String, why: &'static str },
    #[error("buffers[{buffer}]: cannot read `{uri}`: {cause}")]
    BufferIo { buffer: usize, uri: String, cause: std::io::Error },
    #[error("buffers[{buffer}] has neither a uri nor a BIN chunk")]
    BufferMissing { buffer: usize },
    #[error("buffers[{buffer}].byteLength is {declared}, but only {found} bytes are there")]
    BufferShort { buffer: usize, declared: u64, found: usize },
    #[error("bufferViews[{view}] ends at byte {end}, its buffer at {available}")]
    ViewEnd { view: usize, end: u64, available: u64 },
    #[error("bufferViews[{view}] holds {place}, but {why}")]
    ViewUse { view: usize, place: String, why: &'static str },
    #[error("accessors[{accessor}] ({place}) must be {expected}, found {found}")]
    AccessorFormat { accessor: usize, place: String, expected: &'static str, found: String },
    #[error(
        "accessors[{accessor}] ({place}) has neither a bufferView nor sparse values: all its values would be 0"
    )]
    AccessorNoData { accessor: usize, place: String },
    #[error("accessors[{accessor}].count is 0, at least 1 expected")]
    AccessorEmpty { accessor: usize },
    #[error(
        "bufferViews[{view}].byteStride is {stride}, expected a multiple of 4 in 4..=252 and at least {element_bytes}"
    )]
    Stride { view: usize, stride: usize, element_bytes: usize },
    #[error("{place} begins at byte {offset} of its buffer, not a multiple of {component_bytes}")]
    Alignment { place: String, offset: u64, component_bytes: usize },
    #[error("{place} needs bytes up to {end} of its view, which has {available}")]
    AccessorEnd { place: String, end: u64, available: u64 },
    #[error(
        "accessors[{accessor}].sparse.indices[{position}] is {found}, expected above the one before and below {count}"
    )]
    SparseIndex { accessor: usize, position: usize, found: u32, count: usize },
    #[error("accessors[{accessor}].sparse.count is {found}, expected 1..={count}")]
    SparseCount { accessor: usize, found: u64, count: usize },
    #[error("{place}: vertex {vertex} is at ({}, {}, {}), which is not finite", position[0], position[1], position[2])]
    PositionNotFinite { place: String, vertex: usize, position: [f32; 3] },
    #[error("{place}.indices[{position}] is {index}, but there are {n_vertices} vertices")]
    VertexIndex { place: String, position: usize, index: u32, n_vertices: usize },
    #[error("{place}: attribute {attribute} has {found} values for {expected} positions")]
    AttributeCount { place: String, attribute: String, found: u64, expected: u64 },
    #[error("{place}.mode is not one of 0..=6")]
    Mode { place: String },
    #[error("nodes[{node}] is reached twice; a scene must be a tree")]
    NodeTwice { node: usize },
    #[error("scenes[{scene}].nodes names nodes[{node}], which is a child of another node")]
    SceneNotRoot { scene: usize, node: usize },
    #[error("nodes[{node}]: {why}")]
    NodeTransform { node: usize, why: &'static str },
    #[error(
        "no triangle in the scene: {n_mesh_nodes} nodes with a mesh, {n_point_primitives} primitives of points, {n_line_primitives} of lines, {n_without_position} without positions, {n_meshes} meshes in the file"
    )]
    NoTriangles {
        n_meshes: usize,
        n_mesh_nodes: usize,
        n_point_primitives: usize,
        n_line_primitives: usize,
        n_without_position: usize,
    },
}
