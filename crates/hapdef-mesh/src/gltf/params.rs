//! What a reader may spend, what it read and what it left out.

use std::ops::Range;

use crate::LengthUnit;

/// What [`read_gltf`](crate::read_gltf) may spend, and how long the file's unit is.
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

/// One placed primitive.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfPart {
    /// The node's name, if it has one.
    pub node_name: Option<String>,
    /// The mesh's name, if it has one.
    pub mesh_name: Option<String>,
    /// The material's name, if there is a material and it has one.
    pub material_name: Option<String>,
    /// Its triangles in [`GltfSurface::mesh`](crate::GltfSurface::mesh).
    pub triangles: Range<usize>,
}

/// What [`read_gltf`](crate::read_gltf) left out or noticed. All counts but the first two are over the placed meshes.
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
