//! From the corner nodes of ten-node tetrahedra to all their nodes.

use hapdef_mesh::{FeNodeId, TET10_EDGES, Tet10Mesh};
use nalgebra::{Matrix4, Point3, Vector4};

use super::bsr::Bsr;
use crate::ordering::NodeOrder;

/// A mid-side node takes its weights from the corners of an element only if the magnitudes sum to
/// no more than this; else it takes the mean of its two ends. A straight edge has 1.
const MAX_WEIGHT: f64 = 2.0;

/// Weights below this are rounding.
const MIN_WEIGHT: f64 = 1e-9;

/// How each free node of a mesh follows corner nodes.
///
/// A mid-side node takes the barycentric coordinates of its position in the tetrahedron of an
/// element's corners: ½ and ½ on a straight edge, and on curved ones whatever reproduces linear
/// displacements, rigid rotations among them, exactly.
#[derive(Debug)]
pub(crate) struct CornerInterpolation {
    /// Per place: corner places and weights; a corner has itself alone.
    rows: Vec<Vec<(u32, f64)>>,
}

impl CornerInterpolation {
    pub(crate) fn build(mesh: &Tet10Mesh, order: &NodeOrder) -> Self {
        let mut is_corner = vec![false; mesh.nodes().len()];
        for nodes in mesh.elements() {
            nodes[..4].iter().for_each(|n| is_corner[n.index()] = true);
        }
        let mut best: Vec<Option<(f64, [(FeNodeId, f64); 4])>> = vec![None; mesh.nodes().len()];
        for nodes in mesh.elements() {
            let corners: [FeNodeId; 4] = std::array::from_fn(|i| nodes[i]);
            for (edge, &node) in TET10_EDGES.iter().zip(&nodes[4..]) {
                if is_corner[node.index()] || order.place(node).is_none() {
                    continue;
                }
                let weights = weights(mesh, &corners, *edge, node);
                let size: f64 = weights.iter().map(|w| w.abs()).sum();
                if best[node.index()].is_none_or(|(smallest, _)| size < smallest) {
                    let entries = std::array::from_fn(|i| (corners[i], weights[i]));
                    best[node.index()] = Some((size, entries));
                }
            }
        }
        let row = |(place, node): (usize, &FeNodeId)| match &best[node.index()] {
            Some((_, entries)) => free_entries(entries, order),
            None => vec![(place as u32, 1.0)],
        };
        let rows = order.nodes().iter().enumerate().map(row).collect();
        Self { rows }
    }

    /// The prolongation from corners to all places, both taken in `sequence`; and the corners'
    /// places in that order.
    pub(super) fn matrix(&self, sequence: &[u32]) -> (Bsr<3, 3>, Vec<u32>) {
        let is_corner =
            |place: u32| matches!(self.rows[place as usize][..], [(own, 1.0)] if own == place);
        let corners: Vec<u32> = sequence.iter().copied().filter(|&p| is_corner(p)).collect();
        let mut column = vec![0_u32; sequence.len()];
        for (i, &place) in corners.iter().enumerate() {
            column[place as usize] = i as u32;
        }
        let mut p = Bsr {
            row_ptr: vec![0],
            columns: Vec::new(),
            blocks: Vec::new(),
            n_cols: corners.len(),
        };
        for &place in sequence {
            let mut row: Vec<(u32, f64)> = self.rows[place as usize]
                .iter()
                .map(|&(corner, weight)| (column[corner as usize], weight))
                .collect();
            row.sort_unstable_by_key(|entry| entry.0);
            for (column, w) in row {
                p.columns.push(column);
                p.blocks.push([[w, 0.0, 0.0], [0.0, w, 0.0], [0.0, 0.0, w]]);
            }
            p.row_ptr.push(p.columns.len());
        }
        (p, corners)
    }
}

fn free_entries(entries: &[(FeNodeId, f64); 4], order: &NodeOrder) -> Vec<(u32, f64)> {
    entries
        .iter()
        .filter(|(_, weight)| *weight != 0.0)
        .filter_map(|&(node, weight)| Some((order.place(node)? as u32, weight)))
        .collect()
}

/// The barycentric coordinates of `node` in the tetrahedron of `corners`, or ½ at both ends of its
/// `edge` where they are unusable.
fn weights(
    mesh: &Tet10Mesh,
    corners: &[FeNodeId; 4],
    edge: [usize; 2],
    node: FeNodeId,
) -> [f64; 4] {
    let mut mean = [0.0; 4];
    edge.iter().for_each(|&end| mean[end] = 0.5);
    let at = |i: usize| mesh.position(corners[i]);
    let found = barycentric(&std::array::from_fn(at), &mesh.position(node));
    match found {
        Some(w) if w.iter().map(|w| w.abs()).sum::<f64>() <= MAX_WEIGHT => {
            w.map(|w| if w.abs() < MIN_WEIGHT { 0.0 } else { w })
        }
        _ => mean,
    }
}

fn barycentric(corners: &[Point3<f64>; 4], at: &Point3<f64>) -> Option<[f64; 4]> {
    let origin = corners[0];
    let length = (corners[1] - origin).norm();
    let local = |p: &Point3<f64>| (p - origin) / length;
    let a = Matrix4::from_fn(|r, c| if r < 3 { local(&corners[c])[r] } else { 1.0 });
    let b = local(at);
    let weights = a.lu().solve(&Vector4::new(b.x, b.y, b.z, 1.0))?;
    Some(weights.into())
}
