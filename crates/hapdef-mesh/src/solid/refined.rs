//! Uniform refinement of solids whose curved elements fold near a corner, with what the limb says
//! of nodes and faces carried over.

use std::collections::BTreeSet;

use nalgebra::Point3;

use crate::{FeNodeId, MeshError, TET10_EDGES, Tet10Mesh, Tri6Face, tet10};

/// Times neighbours of straightened elements are looked at again.
const MAX_ROUNDS: usize = 8;

/// A refined mesh and what had to be straightened for it.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinedSolid {
    /// The mesh, every element cut into eight; curved faces keep their shape, old nodes their
    /// number and, unless straightened, their place.
    pub mesh: Tet10Mesh,
    /// Parent elements whose edges were straightened.
    pub n_straightened: usize,
    n_old_nodes: usize,
}

/// Refines a mesh. A curved element may be usable as a whole and still fold over between its Gauss
/// points, so that one of its eight parts is inside out; such an element's mid-side nodes are put
/// on the middle of their edges first.
///
/// # Errors
/// [`MeshError`] when parts stay inside out with straight edges, too.
pub fn refine_unfolded(mesh: &Tet10Mesh) -> Result<RefinedSolid, MeshError> {
    let mut nodes = mesh.nodes().to_vec();
    let mut straightened = vec![false; mesh.elements().len()];
    for _ in 0..MAX_ROUNDS {
        let parent = Tet10Mesh::new(nodes.clone(), mesh.elements().to_vec())?;
        let refined = parent.refine();
        let folded: Vec<usize> = (0..mesh.elements().len())
            .filter(|&element| {
                (8 * element..8 * element + 8)
                    .any(|part| is_folded(&refined.element_positions(part)))
            })
            .collect();
        if folded.is_empty() {
            let n_straightened = straightened.iter().filter(|s| **s).count();
            return Ok(RefinedSolid { mesh: refined, n_straightened, n_old_nodes: nodes.len() });
        }
        for element in folded {
            straightened[element] = true;
            let ids = mesh.elements()[element];
            for (mid, [a, b]) in (4..).zip(TET10_EDGES) {
                let ends = nodes[ids[a].index()].coords + nodes[ids[b].index()].coords;
                nodes[ids[mid].index()] = (ends / 2.0).into();
            }
        }
    }
    let n_old_nodes = nodes.len();
    let parent = Tet10Mesh::new(nodes, mesh.elements().to_vec())?;
    let refined = parent.refine();
    let mesh = Tet10Mesh::new(refined.nodes().to_vec(), refined.elements().to_vec())?;
    Ok(RefinedSolid {
        mesh,
        n_straightened: straightened.iter().filter(|s| **s).count(),
        n_old_nodes,
    })
}

impl RefinedSolid {
    /// A set of nodes of the parent mesh, with the new nodes between two of them on an edge,
    /// ascending.
    ///
    /// # Panics
    /// If a node is not of the parent mesh.
    #[must_use]
    pub fn node_set(&self, parent: &[FeNodeId]) -> Vec<FeNodeId> {
        let mut member = vec![false; self.mesh.nodes().len()];
        for node in parent {
            assert!(node.index() < self.n_old_nodes, "a node of the parent mesh");
            member[node.index()] = true;
        }
        for element in self.mesh.elements() {
            for (mid, [a, b]) in (4..).zip(TET10_EDGES) {
                let both = [a, b].iter().all(|&end| {
                    let end = element[end].index();
                    end < self.n_old_nodes && member[end]
                });
                member[element[mid].index()] |= both;
            }
        }
        let nodes = (0..member.len()).filter(|&i| member[i]);
        nodes.map(FeNodeId::from_index).collect()
    }

    /// The boundary faces that boundary faces of the parent mesh were cut into, in the order of the
    /// refined boundary.
    #[must_use]
    pub fn faces(&self, parent: &[Tri6Face]) -> Vec<Tri6Face> {
        let pieces: BTreeSet<[FeNodeId; 3]> = parent.iter().flat_map(quarters).collect();
        let is_piece = |face: &Tri6Face| pieces.contains(&corners(&face.nodes[..3]));
        let boundary = self.mesh.boundary().faces;
        boundary.into_iter().filter(is_piece).collect()
    }
}

/// The corners of the four faces that uniform refinement cuts a face into.
fn quarters(face: &Tri6Face) -> [[FeNodeId; 3]; 4] {
    [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]].map(|piece| corners(&piece.map(|i| face.nodes[i])))
}

fn corners(nodes: &[FeNodeId]) -> [FeNodeId; 3] {
    let mut corners = [nodes[0], nodes[1], nodes[2]];
    corners.sort_unstable();
    corners
}

/// Whether an element is inside out at a Gauss point or in its corner tetrahedron.
#[must_use]
pub fn is_folded(p: &[Point3<f64>; 10]) -> bool {
    let corner_volume = (p[1] - p[0]).cross(&(p[2] - p[0])).dot(&(p[3] - p[0]));
    corner_volume <= 0.0 || tet10::min_gauss_jacobian(p) <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One tetrahedron; `shift` moves the middle of edge 0–1 along it towards corner 0.
    fn bent(shift: f64) -> Tet10Mesh {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut nodes: Vec<Point3<f64>> = corners.map(Point3::from).to_vec();
        for [a, b] in TET10_EDGES {
            nodes.push(nalgebra::center(&nodes[a], &nodes[b]));
        }
        nodes[4].x -= shift;
        Tet10Mesh::new(nodes, vec![std::array::from_fn(FeNodeId::from_index)]).unwrap()
    }

    #[test]
    fn a_mild_bend_is_kept() {
        let refined = refine_unfolded(&bent(0.1)).unwrap();
        assert_eq!(refined.n_straightened, 0);
        assert_eq!(refined.mesh, bent(0.1).refine());
    }

    #[test]
    fn a_fold_is_straightened_and_counted() {
        let folded = bent(0.45);
        assert!(tet10::min_gauss_jacobian(&folded.element_positions(0)) > 0.0);
        assert!(
            (0..8).any(|part| is_folded(&folded.refine().element_positions(part))),
            "the example does not fold"
        );
        let refined = refine_unfolded(&folded).unwrap();
        assert_eq!(refined.n_straightened, 1);
        assert_eq!(refined.mesh, bent(0.0).refine());
    }
}
