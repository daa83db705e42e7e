//! What a glTF or GLB file can have wrong, each with its place and the numbers found.

/// Why a glTF or GLB file was refused. Places are written as in the file: `accessors[3].count`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GltfFault {
    /// The file name ends in neither `.glb` nor `.gltf`.
    #[error("the name ends in `{found}`, expected `.glb` or `.gltf`")]
    FileKind {
        /// The ending found, empty when there is none.
        found: String,
    },
    /// More bytes, vertices, triangles or nodes than the caller allows.
    #[error(
        "{what}: {found} exceeds the limit of {limit}; raise `GltfParams::{param}` if this is wanted"
    )]
    Limit {
        /// What was counted.
        what: &'static str,
        /// The field of `GltfParams` that holds the limit.
        param: &'static str,
        /// The count found, or the part of it read before stopping.
        found: u64,
        /// The limit.
        limit: u64,
    },
    /// A GLB file that ends inside its 12-byte header.
    #[error("a GLB header has 12 bytes, the file has {found}")]
    GlbHeaderShort {
        /// Bytes in the file.
        found: usize,
    },
    /// A GLB file that does not begin with `glTF`.
    #[error("a GLB file begins with 0x46546c67 (`glTF`), found {found:#010x}")]
    GlbMagic {
        /// The first four bytes, little-endian.
        found: u32,
    },
    /// A GLB container version other than 2.
    #[error("GLB container version 2 expected, found {found}")]
    GlbVersion {
        /// The version found.
        found: u32,
    },
    /// The length in the GLB header does not fit the file.
    #[error("the GLB header declares {declared} bytes, the file has {found}")]
    GlbLength {
        /// The length the header declares.
        declared: u32,
        /// Bytes in the file.
        found: usize,
    },
    /// A GLB chunk that is cut off, empty or not padded to four bytes.
    #[error("GLB chunk at byte {offset}: {problem} (length {length}, {left} bytes left)")]
    GlbChunk {
        /// Where the chunk's header begins.
        offset: usize,
        /// What is wrong.
        problem: &'static str,
        /// The chunk's declared length; 0 when the header itself is cut off.
        length: u32,
        /// Bytes between the chunk's header, or its data, and the end of the container.
        left: usize,
    },
    /// GLB chunks out of order: JSON first, then at most one BIN, as the second chunk.
    #[error("GLB chunk {position} is of type {kind:#010x}: {problem}")]
    GlbChunkOrder {
        /// The chunk, counted from 0.
        position: usize,
        /// Its type, little-endian.
        kind: u32,
        /// What was expected.
        problem: &'static str,
    },
    /// The JSON cannot be parsed, or a property has the wrong type.
    #[error("JSON: {cause}")]
    Json {
        /// The parser's answer with line and column.
        cause: gltf::json::Error,
    },
    /// A number that glTF's 32-bit indices and sizes cannot hold.
    #[error("{place} is {found}, larger than {} can be here", u32::MAX)]
    JsonNumber {
        /// The property.
        place: String,
        /// The number found.
        found: u64,
    },
    /// A file made for another version of glTF.
    #[error("asset.version is `{found}`, expected 2.x (and asset.minVersion at most 2.0)")]
    AssetVersion {
        /// The version found.
        found: String,
    },
    /// An extension without which the geometry cannot be read.
    #[error(
        "the file requires the extension `{name}`, which changes geometry in a way this reader does not know; export without it"
    )]
    RequiredExtension {
        /// The extension's name.
        name: String,
    },
    /// A reference to something that is not in the file.
    #[error("{place} refers to {what} {index}, but the file has {count}")]
    Dangling {
        /// The referring property.
        place: String,
        /// What it refers to.
        what: &'static str,
        /// The index found.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A buffer address that may not be followed.
    #[error(
        "buffers[{buffer}].uri {why}: `{uri}`; put the buffer beside the .gltf file or into a .glb"
    )]
    BufferUri {
        /// The buffer.
        buffer: usize,
        /// The address, shortened.
        uri: String,
        /// Why it is refused.
        why: &'static str,
    },
    /// A buffer's file that cannot be opened or read.
    #[error("buffers[{buffer}]: cannot read `{uri}`: {cause}")]
    BufferIo {
        /// The buffer.
        buffer: usize,
        /// The address in the file.
        uri: String,
        /// The operating system's answer.
        cause: std::io::Error,
    },
    /// A buffer without an address that is not the BIN chunk of a GLB file.
    #[error("buffers[{buffer}] has neither a uri nor a BIN chunk")]
    BufferMissing {
        /// The buffer.
        buffer: usize,
    },
    /// A buffer shorter than it says.
    #[error("buffers[{buffer}].byteLength is {declared}, but only {found} bytes are there")]
    BufferShort {
        /// The buffer.
        buffer: usize,
        /// Its `byteLength`.
        declared: u64,
        /// Bytes found.
        found: usize,
    },
    /// A view that reaches beyond its buffer.
    #[error("bufferViews[{view}] ends at byte {end}, its buffer at {available}")]
    ViewEnd {
        /// The view.
        view: usize,
        /// Where it ends; `u64::MAX` stands for an end that overflows.
        end: u64,
        /// Bytes in the buffer.
        available: u64,
    },
    /// A view used for something its `target` or its other use excludes.
    #[error("bufferViews[{view}] holds {place}, but {why}")]
    ViewUse {
        /// The view.
        view: usize,
        /// What is read from it.
        place: String,
        /// What excludes that.
        why: &'static str,
    },
    /// An accessor whose values have the wrong type.
    #[error("accessors[{accessor}] ({place}) must be {expected}, found {found}")]
    AccessorFormat {
        /// The accessor.
        accessor: usize,
        /// What it is read for.
        place: String,
        /// The type expected.
        expected: &'static str,
        /// The type found.
        found: String,
    },
    /// An accessor without bytes: neither a view nor sparse values.
    #[error(
        "accessors[{accessor}] ({place}) has neither a bufferView nor sparse values: all its values would be 0"
    )]
    AccessorNoData {
        /// The accessor.
        accessor: usize,
        /// What it is read for.
        place: String,
    },
    /// An accessor with a count of 0, which the format forbids.
    #[error("accessors[{accessor}].count is 0, at least 1 expected")]
    AccessorEmpty {
        /// The accessor.
        accessor: usize,
    },
    /// A distance between elements that the format forbids.
    #[error(
        "bufferViews[{view}].byteStride is {stride}, expected a multiple of 4 in 4..=252 and at least {element_bytes}"
    )]
    Stride {
        /// The view.
        view: usize,
        /// The stride found.
        stride: usize,
        /// Bytes of one element.
        element_bytes: usize,
    },
    /// Values that do not begin on a multiple of their component's size.
    #[error("{place} begins at byte {offset} of its buffer, not a multiple of {component_bytes}")]
    Alignment {
        /// The accessor or its sparse part.
        place: String,
        /// The first byte.
        offset: u64,
        /// Bytes of one component.
        component_bytes: usize,
    },
    /// Values that reach beyond their view.
    #[error("{place} needs bytes up to {end} of its view, which has {available}")]
    AccessorEnd {
        /// The accessor or its sparse part.
        place: String,
        /// Where the last element ends; `u64::MAX` stands for an end that overflows.
        end: u64,
        /// Bytes in the view.
        available: u64,
    },
    /// A sparse accessor whose indices are not increasing and in range.
    #[error(
        "accessors[{accessor}].sparse.indices[{position}] is {found}, expected above the one before and below {count}"
    )]
    SparseIndex {
        /// The accessor.
        accessor: usize,
        /// Which of the sparse indices.
        position: usize,
        /// The index found.
        found: u32,
        /// Elements in the accessor.
        count: usize,
    },
    /// More sparse values than elements, or none.
    #[error("accessors[{accessor}].sparse.count is {found}, expected 1..={count}")]
    SparseCount {
        /// The accessor.
        accessor: usize,
        /// The count found.
        found: u64,
        /// Elements in the accessor.
        count: usize,
    },
    /// A vertex coordinate that is not a finite number.
    #[error("{place}: vertex {vertex} is at ({}, {}, {}), which is not finite", position[0], position[1], position[2])]
    PositionNotFinite {
        /// The primitive.
        place: String,
        /// The vertex, counted from 0.
        vertex: usize,
        /// Its coordinates.
        position: [f32; 3],
    },
    /// An index beyond the primitive's vertices.
    #[error("{place}.indices[{position}] is {index}, but there are {n_vertices} vertices")]
    VertexIndex {
        /// The primitive.
        place: String,
        /// Which of the indices.
        position: usize,
        /// The index found.
        index: u32,
        /// Vertices of the primitive.
        n_vertices: usize,
    },
    /// Attributes of one primitive that do not have one value per vertex.
    #[error("{place}: attribute {attribute} has {found} values for {expected} positions")]
    AttributeCount {
        /// The primitive.
        place: String,
        /// The attribute's name.
        attribute: String,
        /// Its count.
        found: u64,
        /// Vertices of the primitive.
        expected: u64,
    },
    /// A primitive whose `mode` is not 0..=6.
    #[error("{place}.mode is not one of 0..=6")]
    Mode {
        /// The primitive.
        place: String,
    },
    /// A node reached twice: a cycle, or a node with two parents.
    #[error("nodes[{node}] is reached twice; a scene must be a tree")]
    NodeTwice {
        /// The node.
        node: usize,
    },
    /// A scene that begins at a node which has a parent, whose transform would be lost.
    #[error("scenes[{scene}].nodes names nodes[{node}], which is a child of another node")]
    SceneNotRoot {
        /// The scene.
        scene: usize,
        /// The node.
        node: usize,
    },
    /// A node transform that is not an invertible affine map.
    #[error("nodes[{node}]: {why}")]
    NodeTransform {
        /// The node.
        node: usize,
        /// What is wrong.
        why: &'static str,
    },
    /// A file that is well formed as far as read, but gives no triangle.
    #[error(
        "no triangle in the scene: {n_mesh_nodes} nodes with a mesh, {n_point_primitives} primitives of points, {n_line_primitives} of lines, {n_without_position} without positions, {n_meshes} meshes in the file"
    )]
    NoTriangles {
        /// Meshes in the file.
        n_meshes: usize,
        /// Nodes of the scene that carry a mesh.
        n_mesh_nodes: usize,
        /// Primitives made of points.
        n_point_primitives: usize,
        /// Primitives made of lines.
        n_line_primitives: usize,
        /// Primitives without positions.
        n_without_position: usize,
    },
}
