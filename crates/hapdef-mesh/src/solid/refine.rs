//! Uniform red refinement of ten-node tetrahedra: each element becomes eight.

use nalgebra::Point3;

use crate::{FeNodeId, TET10_EDGES, tet10};

/// Corner children by local node numbers of the parent (Bey, Computing 55, 1995, section 3: the
/// order keeps each child's orientation).
const CORNER_CHILDREN: [[usize; 4]; 4] = [[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3]];

/// The inner octahedron's children along each diagonal: mid-side nodes 4–9, 5–7 and 6–8 face each
/// other. Around diagonal (p, q) runs the ring of the other four; each child is p, q and two
/// neighbours in the ring, ordered for positive volume.
const INNER_CHILDREN: [([usize; 2], [[usize; 4]; 4]); 3] = [
    ([4, 9], [[4, 9, 5, 6], [4, 9, 8, 5], [4, 9, 7, 8], [4, 9, 6, 7]]),
    ([5, 7], [[5, 7, 4, 8], [5, 7, 6, 4], [5, 7, 9, 6], [5, 7, 8, 9]]),
    ([6, 8], [[6, 8, 5, 9], [6, 8, 4, 5], [6, 8, 7, 4], [6, 8, 9, 7]]),
];

/// Parent coordinates of the ten nodes.
const NODE_COORDINATES: [[f64; 3]; 10] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.0, 0.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.0],
    [0.0, 0.0, 0.5],
    [0.5, 0.0, 0.5],
    [0.0, 0.5, 0.5],
];

pub(crate) fn refine(
    nodes: &[Point3<f64>],
    elements: &[[FeNodeId; 10]],
) -> (Vec<Point3<f64>>, Vec<[FeNodeId; 10]>) {
    let children: Vec<_> = elements.iter().flat_map(|ids| split(nodes, ids)).collect();
    let (edges, mut all_nodes) = new_nodes(nodes, elements, &children);
    all_nodes.splice(0..0, nodes.iter().copied());
    let refined = children
        .iter()
        .enumerate()
        .map(|(i, local)| {
            let parent = &elements[i / 8];
            let corners = local.map(|l| parent[l]);
            child_element(corners, &edges, nodes.len())
        })
        .collect();
    (all_nodes, refined)
}

/// The eight children's corners in the parent's local node numbers.
fn split(nodes: &[Point3<f64>], ids: &[FeNodeId; 10]) -> [[usize; 4]; 8] {
    let length = |[p, q]: [usize; 2]| (nodes[ids[p].index()] - nodes[ids[q].index()]).norm();
    let mut best = &INNER_CHILDREN[0];
    for candidate in &INNER_CHILDREN[1..] {
        if length(candidate.0) < length(best.0) {
            best = candidate;
        }
    }
    let mut children = [[0; 4]; 8];
    children[..4].copy_from_slice(&CORNER_CHILDREN);
    children[4..].copy_from_slice(&best.1);
    children
}

/// The new mid-side nodes: edge keys (ends ascending) in order, and their positions in that order.
/// An edge's position is taken from the first element that has it; the others agree, since an edge
/// or face of the quadratic map depends on the nodes of that edge or face only.
fn new_nodes(
    nodes: &[Point3<f64>],
    elements: &[[FeNodeId; 10]],
    children: &[[usize; 4]],
) -> (Vec<[FeNodeId; 2]>, Vec<Point3<f64>>) {
    let mut edges: Vec<([FeNodeId; 2], usize, [usize; 2])> = Vec::new();
    for (i, local) in children.iter().enumerate() {
        for [a, b] in TET10_EDGES {
            let parent = i / 8;
            let ends = [local[a], local[b]];
            edges.push((key(ends.map(|l| elements[parent][l])), parent, ends));
        }
    }
    edges.sort_unstable();
    edges.dedup_by_key(|edge| edge.0);
    let positions = edges
        .iter()
        .map(|&(_, parent, [a, b])| {
            let (ra, rb) = (NODE_COORDINATES[a], NODE_COORDINATES[b]);
            let middle = std::array::from_fn(|k| 0.5 * (ra[k] + rb[k]));
            tet10::position(&elements[parent].map(|id| nodes[id.index()]), middle)
        })
        .collect();
    (edges.into_iter().map(|edge| edge.0).collect(), positions)
}

fn child_element(corners: [FeNodeId; 4], edges: &[[FeNodeId; 2]], n_old: usize) -> [FeNodeId; 10] {
    std::array::from_fn(|i| match i {
        0..4 => corners[i],
        _ => {
            let ends = key(TET10_EDGES[i - 4].map(|c| corners[c]));
            let found = edges.partition_point(|edge| *edge < ends);
            FeNodeId::from_index(n_old + found)
        }
    })
}

fn key([a, b]: [FeNodeId; 2]) -> [FeNodeId; 2] {
    if a < b { [a, b] } else { [b, a] }
}
