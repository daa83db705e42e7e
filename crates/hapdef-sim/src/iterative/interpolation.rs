//! From the corner nodes of ten-node tetrahedra to all their nodes.

use hapdef_mesh::{FeNodeId, TET10_EDGES};
use nalgebra::{Matrix3, Matrix4, Point3, Vector4};

use super::bsr::{Block, Bsr};
use crate::elements::element_set::Elements;
use crate::supports::unknowns::{Link, Unknowns};

/// A mid-side node takes its weights from the corners of an element only if the magnitudes sum to
/// no more than this; else it takes the mean of its two ends. A straight edge has 1.
const MAX_WEIGHT: f64 = 2.0;

/// Weights below this are rounding.
const MIN_WEIGHT: f64 = 1e-9;

/// How each unknown of a mesh of ten-node tetrahedra follows those of corner nodes.
///
/// A mid-side node takes the barycentric coordinates of its position in the tetrahedron of an
/// element's corners: ½ and ½ on a straight edge, and on curved ones whatever reproduces linear
/// displacements, rigid rotations among them, exactly. All other unknowns stay as they are.
#[derive(Debug)]
pub(crate) struct CornerInterpolation {
    /// Per place: what a mid-side node takes from other places; nothing elsewhere.
    rows: Vec<Option<Row>>,
}

/// Places and the matrix on each.
type Row = Vec<(u32, Matrix3<f64>)>;

/// The corners of an element, and a mid-side node's weight on each.
type Weights = [(FeNodeId, f64); 4];

impl CornerInterpolation {
    /// Nothing if the elements are not ten-node tetrahedra.
    pub(crate) fn build(elements: &dyn Elements, unknowns: &Unknowns) -> Option<Self> {
        let all = 0..elements.n_elements();
        if elements.has_rotations() || all.clone().any(|e| elements.nodes(e).len() != 10) {
            return None;
        }
        let mut is_corner = vec![false; elements.positions().len()];
        for element in all {
            let corners = &elements.nodes(element)[..4];
            corners.iter().for_each(|n| is_corner[n.index()] = true);
        }
        let mut rows = vec![None; unknowns.n_places()];
        for (node, best) in best_weights(elements, &is_corner).into_iter().enumerate() {
            let Some((_, weights)) = best else { continue };
            let own = unknowns.translation(FeNodeId::from_index(node));
            match own {
                Link::Free(place) => {
                    rows[*place as usize] =
                        Some(followed(&weights, &Matrix3::identity(), unknowns));
                }
                Link::Roller(place, projector) => {
                    rows[*place as usize] = Some(followed(&weights, projector, unknowns));
                }
                Link::Fixed | Link::Tied { .. } => {}
            }
        }
        Some(Self { rows })
    }

    /// The prolongation from the places that stay to all places, both taken in `sequence`; and the
    /// places that stay, in that order.
    pub(super) fn matrix(&self, sequence: &[u32]) -> (Bsr<3, 3>, Vec<u32>) {
        let stays = |place: &u32| self.rows[*place as usize].is_none();
        let corners: Vec<u32> = sequence.iter().copied().filter(stays).collect();
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
            let own = [(place, Matrix3::identity())];
            let row = self.rows[place as usize].as_deref().unwrap_or(&own);
            for (corner, matrix) in row {
                p.columns.push(column[*corner as usize]);
                p.blocks.push(block(matrix));
            }
            let start = p.row_ptr[p.row_ptr.len() - 1];
            sort_row(&mut p.columns[start..], &mut p.blocks[start..]);
            p.row_ptr.push(p.columns.len());
        }
        (p, corners)
    }
}

/// For each mid-side node the weights of the smallest size among its elements, and that size.
fn best_weights(elements: &dyn Elements, is_corner: &[bool]) -> Vec<Option<(f64, Weights)>> {
    let mut best: Vec<Option<(f64, Weights)>> = vec![None; is_corner.len()];
    for element in 0..elements.n_elements() {
        let nodes = elements.nodes(element);
        let corners: [FeNodeId; 4] = std::array::from_fn(|i| nodes[i]);
        for (edge, &node) in TET10_EDGES.iter().zip(&nodes[4..]) {
            if is_corner[node.index()] {
                continue;
            }
            let weights = weights(elements.positions(), &corners, *edge, node);
            let size: f64 = weights.iter().map(|w| w.abs()).sum();
            if best[node.index()].is_none_or(|(smallest, _)| size < smallest) {
                let weights = std::array::from_fn(|i| (corners[i], weights[i]));
                best[node.index()] = Some((size, weights));
            }
        }
    }
    best
}

/// What `projector` times the weighted motion of the corners takes from each place.
fn followed(weights: &Weights, projector: &Matrix3<f64>, unknowns: &Unknowns) -> Row {
    let mut row = Row::new();
    for (corner, weight) in weights.iter().filter(|(_, weight)| *weight != 0.0) {
        for (place, matrix) in unknowns.translation(*corner).terms() {
            let term = projector * matrix * *weight;
            match row.iter_mut().find(|(known, _)| *known == place as u32) {
                Some((_, sum)) => *sum += term,
                None => row.push((place as u32, term)),
            }
        }
    }
    row
}

fn block(matrix: &Matrix3<f64>) -> Block<3, 3> {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]))
}

/// A row has a few entries: insertion sort.
fn sort_row(columns: &mut [u32], blocks: &mut [Block<3, 3>]) {
    for end in 1..columns.len() {
        for i in (1..=end).rev() {
            if columns[i - 1] > columns[i] {
                columns.swap(i - 1, i);
                blocks.swap(i - 1, i);
            }
        }
    }
}

/// The barycentric coordinates of `node` in the tetrahedron of `corners`, or ½ at both ends of its
/// `edge` where they are unusable.
fn weights(
    positions: &[Point3<f64>],
    corners: &[FeNodeId; 4],
    edge: [usize; 2],
    node: FeNodeId,
) -> [f64; 4] {
    let mut mean = [0.0; 4];
    edge.iter().for_each(|&end| mean[end] = 0.5);
    let corners = corners.map(|corner| positions[corner.index()]);
    match barycentric(&corners, &positions[node.index()]) {
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
