//! The ten-node tetrahedral mesh.

use nalgebra::Point3;

use crate::FeNodeId;

/// The mid-side nodes 4..10 of a ten-node tetrahedron and the corner pair each lies between:
/// the order of C3D10 (CalculiX 2.20 manual, section 6.2.6) and SOLID187 (ANSYS element reference).
pub const TET10_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// A mesh of ten-node tetrahedra with curved faces.
///
/// Element nodes: four corners, then the mid-side nodes in the order of [`TET10_EDGES`].
/// Corner volumes are positive. Coordinates in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Tet10Mesh {
    nodes: Vec<Point3<f64>>,
    elements: Vec<[FeNodeId; 10]>,
}

impl Tet10Mesh {
    /// Node positions `[n_fe_nodes]`, m.
    #[must_use]
    pub fn nodes(&self) -> &[Point3<f64>] {
        &self.nodes
    }

    /// Element connectivity `[n_elements]`, ten nodes each.
    #[must_use]
    pub fn elements(&self) -> &[[FeNodeId; 10]] {
        &self.elements
    }
}
