//! The ten-node tetrahedral mesh.

use nalgebra::Point3;

use super::tet10::TET10_EDGES;
use super::{boundary, refine};
use crate::{BoundarySurface, FeNodeId, MeshError, SolidFault, Tri6Face};

/// A mesh of ten-node tetrahedra with curved faces.
///
/// Element nodes: four corners, then the mid-side nodes in the order of [`TET10_EDGES`].
/// Corner volumes are positive, every node belongs to an element, at most two elements share a
/// face, and elements that share an edge share its mid-side node. Coordinates in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Tet10Mesh {
    nodes: Vec<Point3<f64>>,
    elements: Vec<[FeNodeId; 10]>,
}

impl Tet10Mesh {
    /// The mesh of `nodes` `[n_fe_nodes]`, m, and `elements` `[n_elements]`.
    ///
    /// # Errors
    /// [`MeshError::Solid`] if the invariants stated on [`Tet10Mesh`] don't hold, or an index or a
    /// coordinate is not usable.
    pub fn new(nodes: Vec<Point3<f64>>, elements: Vec<[FeNodeId; 10]>) -> Result<Self, MeshError> {
        Ok(Self::checked(nodes, elements)?)
    }

    pub(crate) fn checked(
        nodes: Vec<Point3<f64>>,
        elements: Vec<[FeNodeId; 10]>,
    ) -> Result<Self, SolidFault> {
        check_nodes(&nodes)?;
        if elements.is_empty() {
            return Err(SolidFault::NoElements { n_nodes: nodes.len() });
        }
        check_connectivity(nodes.len(), &elements)?;
        check_corner_volumes(&nodes, &elements)?;
        check_edges(&elements)?;
        boundary::check_faces(&elements)?;
        Ok(Self { nodes, elements })
    }

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

    /// The position of one node, m.
    #[must_use]
    pub fn position(&self, node: FeNodeId) -> Point3<f64> {
        self.nodes[node.index()]
    }

    /// The ten node positions of element `element`, m.
    #[must_use]
    pub fn element_positions(&self, element: usize) -> [Point3<f64>; 10] {
        self.elements[element].map(|node| self.nodes[node.index()])
    }

    /// The faces that belong to one element only, normals outward, in element order.
    #[must_use]
    pub fn boundary(&self) -> BoundarySurface {
        boundary::boundary(&self.elements)
    }

    /// The nodes at positions for which `is_wanted` holds, ascending.
    pub fn nodes_where(&self, is_wanted: impl Fn(&Point3<f64>) -> bool) -> Vec<FeNodeId> {
        let wanted = self.nodes.iter().enumerate().filter(|(_, position)| is_wanted(position));
        wanted.map(|(node, _)| FeNodeId::from_index(node)).collect()
    }

    /// The boundary faces of which `is_wanted` holds at all six nodes, in the boundary's order.
    pub fn faces_where(&self, is_wanted: impl Fn(&Point3<f64>) -> bool) -> Vec<Tri6Face> {
        let mut faces = self.boundary().faces;
        faces.retain(|face| face.nodes.iter().all(|node| is_wanted(&self.nodes[node.index()])));
        faces
    }

    /// Each element split into eight (uniform red refinement).
    ///
    /// Old nodes keep their ids, and old mid-side nodes become corners. New mid-side nodes lie on
    /// the parent's quadratic map, so each child's map is the parent's, restricted: curved faces,
    /// volumes and Jacobians stay as they are. The inner octahedron is split along the shortest of
    /// its three diagonals.
    ///
    /// # Panics
    /// If the refined mesh has more nodes than 32-bit indices can name.
    #[must_use]
    pub fn refine(&self) -> Self {
        let (nodes, elements) = refine::refine(&self.nodes, &self.elements);
        Self { nodes, elements }
    }
}

fn check_nodes(nodes: &[Point3<f64>]) -> Result<(), SolidFault> {
    if u32::try_from(nodes.len()).is_err() {
        return Err(SolidFault::TooManyNodes { n_nodes: nodes.len() });
    }
    match nodes.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        Some(node) => Err(SolidFault::NodeNotFinite { node, position: nodes[node].coords.into() }),
        None => Ok(()),
    }
}

fn check_connectivity(n_nodes: usize, elements: &[[FeNodeId; 10]]) -> Result<(), SolidFault> {
    let mut used = vec![false; n_nodes];
    for (element, nodes) in elements.iter().enumerate() {
        for (i, node) in nodes.iter().enumerate() {
            if node.index() >= n_nodes {
                return Err(SolidFault::NodeOutOfRange { element, node: node.0, n_nodes });
            }
            if nodes[..i].contains(node) {
                return Err(SolidFault::NodeTwice { element, node: node.0 });
            }
            used[node.index()] = true;
        }
    }
    match used.iter().position(|used| !used) {
        Some(node) => Err(SolidFault::NodeWithoutElement { node }),
        None => Ok(()),
    }
}

fn check_corner_volumes(
    nodes: &[Point3<f64>],
    elements: &[[FeNodeId; 10]],
) -> Result<(), SolidFault> {
    for (element, ids) in elements.iter().enumerate() {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| nodes[ids[i].index()]);
        let volume_m3 = (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0;
        if volume_m3.is_nan() || volume_m3 <= 0.0 {
            return Err(SolidFault::CornerVolume { element, volume_m3 });
        }
    }
    Ok(())
}

fn check_edges(elements: &[[FeNodeId; 10]]) -> Result<(), SolidFault> {
    let mut edges: Vec<([u32; 2], u32)> = elements
        .iter()
        .flat_map(|ids| {
            TET10_EDGES.iter().enumerate().map(|(i, &[a, b])| {
                let (a, b) = (ids[a].0, ids[b].0);
                ([a.min(b), a.max(b)], ids[4 + i].0)
            })
        })
        .collect();
    edges.sort_unstable();
    match edges.windows(2).find(|w| w[0].0 == w[1].0 && w[0].1 != w[1].1) {
        Some(w) => Err(SolidFault::EdgeMidsDiffer { ends: w[0].0, mids: [w[0].1, w[1].1] }),
        None => Ok(()),
    }
}
