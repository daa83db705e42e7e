//! The boundary of a solid mesh: six-node faces that belong to one element only.

use crate::{FeNodeId, SolidFault};

/// A six-node triangular face of a ten-node tetrahedron.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Tri6Face {
    /// Three corners, counterclockwise seen from outside the element, then the mid-side nodes
    /// between corners 0–1, 1–2 and 2–0.
    pub nodes: [FeNodeId; 6],
    /// The element the face belongs to, counted from 0.
    pub element: usize,
}

/// The boundary of a solid mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BoundarySurface {
    /// Faces in order of element, then of [`TET10_FACES`]; normals point out of the solid.
    pub faces: Vec<Tri6Face>,
}

impl BoundarySurface {
    /// The nodes of all faces, mid-side nodes included, ascending, each once.
    #[must_use]
    pub fn nodes(&self) -> Vec<FeNodeId> {
        nodes_of(&self.faces)
    }
}

/// The faces of a ten-node tetrahedron in local node numbers: corners counterclockwise from
/// outside, then the mid-side nodes 0–1, 1–2, 2–0 of the face. The order of the faces is that of
/// P1 to P4 on C3D10 (CalculiX 2.20 manual, *DLOAD).
pub const TET10_FACES: [[usize; 6]; 4] =
    [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [2, 0, 3, 6, 7, 9]];

/// Which of `faces` can be reached from face `start` over shared edges, through faces for which
/// `agrees` holds, `[n_faces]`.
///
/// # Panics
/// If `start` is not one of the faces.
#[must_use]
pub fn connected_faces(
    faces: &[Tri6Face],
    start: usize,
    agrees: impl Fn(usize) -> bool,
) -> Vec<bool> {
    // Two faces that share an edge share its mid-side node.
    let mut by_edge: Vec<(FeNodeId, usize)> = faces
        .iter()
        .enumerate()
        .flat_map(|(i, face)| [3, 4, 5].map(|mid| (face.nodes[mid], i)))
        .collect();
    by_edge.sort_unstable();
    let mut reached = vec![false; faces.len()];
    reached[start] = true;
    let mut open = vec![start];
    while let Some(face) = open.pop() {
        for mid in 3..6 {
            let edge = faces[face].nodes[mid];
            let first = by_edge.partition_point(|entry| entry.0 < edge);
            for &(_, next) in by_edge[first..].iter().take_while(|entry| entry.0 == edge) {
                if !reached[next] && agrees(next) {
                    reached[next] = true;
                    open.push(next);
                }
            }
        }
    }
    reached
}

/// The nodes of `faces`, ascending, each once.
pub(crate) fn nodes_of(faces: &[Tri6Face]) -> Vec<FeNodeId> {
    let mut nodes: Vec<FeNodeId> = faces.iter().flat_map(|face| face.nodes).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

pub(crate) fn boundary(elements: &[[FeNodeId; 10]]) -> BoundarySurface {
    let keys = sorted_face_keys(elements);
    let mut single: Vec<(usize, usize)> = Vec::new();
    for group in keys.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, element, face)] = group {
            single.push((*element, *face));
        }
    }
    single.sort_unstable();
    let faces = single
        .into_iter()
        .map(|(element, face)| Tri6Face {
            nodes: TET10_FACES[face].map(|local| elements[element][local]),
            element,
        })
        .collect();
    BoundarySurface { faces }
}

pub(crate) fn check_faces(elements: &[[FeNodeId; 10]]) -> Result<(), SolidFault> {
    let keys = sorted_face_keys(elements);
    match keys.chunk_by(|a, b| a.0 == b.0).find(|group| group.len() > 2) {
        Some(group) => Err(SolidFault::FaceShared { corners: group[0].0, found: group.len() }),
        None => Ok(()),
    }
}

/// `(corner nodes ascending, element, local face)` of every face, sorted.
fn sorted_face_keys(elements: &[[FeNodeId; 10]]) -> Vec<([u32; 3], usize, usize)> {
    let mut keys: Vec<_> = elements
        .iter()
        .enumerate()
        .flat_map(|(element, ids)| {
            TET10_FACES.iter().enumerate().map(move |(face, local)| {
                let mut corners = [0, 1, 2].map(|i| ids[local[i]].0);
                corners.sort_unstable();
                (corners, element, face)
            })
        })
        .collect();
    keys.sort_unstable();
    keys
}
