//! What can be wrong with a solid mesh, whatever it was read from.

/// Why nodes and elements don't make a ten-node tetrahedral mesh. Nodes and elements count from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum SolidFault {
    #[error("the solid mesh has {n_nodes} nodes and no element; at least one is needed")]
    NoElements { n_nodes: usize },
    #[error("the solid mesh has {n_nodes} nodes, more than 32-bit indices can name")]
    TooManyNodes { n_nodes: usize },
    #[error("element {element} uses node {node}, but the mesh has {n_nodes} nodes (0-based)")]
    NodeOutOfRange { element: usize, node: u32, n_nodes: usize },
    #[error(
        "element {element} uses node {node} twice (0-based); a ten-node tetrahedron has ten different nodes"
    )]
    NodeTwice { element: usize, node: u32 },
    #[error("FE node {node} is at ({}, {}, {}), which is not finite", position[0], position[1], position[2])]
    NodeNotFinite { node: usize, position: [f64; 3] },
    #[error("FE node {node} belongs to no element (0-based); leave it out of the mesh")]
    NodeWithoutElement { node: usize },
    #[error(
        "element {element} has corner volume {volume_m3:.3e} m3 (0-based); it must be positive: \
         number the corners so that the fourth sees the first three counterclockwise from inside"
    )]
    CornerVolume { element: usize, volume_m3: f64 },
    #[error(
        "face with corners {corners:?} belongs to {found} elements; at most two can share a face"
    )]
    FaceShared { corners: [u32; 3], found: usize },
    #[error(
        "edge {}-{} has mid-side nodes {} and {}: elements that share an edge must share its mid-side node",
        ends[0], ends[1], mids[0], mids[1]
    )]
    EdgeMidsDiffer { ends: [u32; 2], mids: [u32; 2] },
}
