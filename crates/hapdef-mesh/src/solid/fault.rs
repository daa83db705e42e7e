//! What can be wrong with a solid mesh, whatever it was read from.

/// Why nodes and elements don't make a ten-node tetrahedral mesh. Nodes and elements count from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolidFault {
    /// A mesh without elements.
    #[error("the solid mesh has {n_nodes} nodes and no element; at least one is needed")]
    NoElements {
        /// How many nodes there are.
        n_nodes: usize,
    },
    /// More nodes than 32-bit indices can name.
    #[error("the solid mesh has {n_nodes} nodes, more than 32-bit indices can name")]
    TooManyNodes {
        /// How many nodes there are.
        n_nodes: usize,
    },
    /// An element names a node that is not there.
    #[error("element {element} uses node {node}, but the mesh has {n_nodes} nodes (0-based)")]
    NodeOutOfRange {
        /// The element.
        element: usize,
        /// The node it names.
        node: u32,
        /// How many nodes there are.
        n_nodes: usize,
    },
    /// An element names one node twice.
    #[error(
        "element {element} uses node {node} twice (0-based); a ten-node tetrahedron has ten different nodes"
    )]
    NodeTwice {
        /// The element.
        element: usize,
        /// The node named twice.
        node: u32,
    },
    /// A coordinate that is not a finite number.
    #[error("FE node {node} is at ({}, {}, {}), which is not finite", position[0], position[1], position[2])]
    NodeNotFinite {
        /// The node.
        node: usize,
        /// Its coordinates, m.
        position: [f64; 3],
    },
    /// A node that belongs to no element: it would float without stiffness.
    #[error("FE node {node} belongs to no element (0-based); leave it out of the mesh")]
    NodeWithoutElement {
        /// The node.
        node: usize,
    },
    /// Four corners that lie in a plane or are numbered inside out.
    #[error(
        "element {element} has corner volume {volume_m3:.3e} m3 (0-based); it must be positive: \
         number the corners so that the fourth sees the first three counterclockwise from inside"
    )]
    CornerVolume {
        /// The element.
        element: usize,
        /// The signed volume of the tetrahedron of its four corners, m³.
        volume_m3: f64,
    },
    /// A face that more than two elements share.
    #[error(
        "face with corners {corners:?} belongs to {found} elements; at most two can share a face"
    )]
    FaceShared {
        /// The corner nodes, ascending.
        corners: [u32; 3],
        /// How many elements have this face.
        found: usize,
    },
    /// Two elements that share an edge's ends but not its mid-side node: the mesh gapes there.
    #[error(
        "edge {}-{} has mid-side nodes {} and {}: elements that share an edge must share its mid-side node",
        ends[0], ends[1], mids[0], mids[1]
    )]
    EdgeMidsDiffer {
        /// The end nodes, ascending.
        ends: [u32; 2],
        /// Two of the mid-side nodes found.
        mids: [u32; 2],
    },
}
