//! How nodal values become a smooth field on the skin: which control values each face has.

use nalgebra::Vector3;

use crate::basis::{self, N_CUBIC};
use crate::dense::add_scaled;
use crate::node_gradient::{Neighbourhood, gradient_weights};
use crate::skin::Skin;
use crate::skin_point::{Frame, SkinPoint};
use crate::subdivided_faces::{self, N_PARTS, SubdividedFaces};

/// Control values by face. On six-node faces they are the nodal values and the field is the
/// quadratic one of the elements, or that of the four parts of a subdivided face, each with six values of its
/// own. On three-node faces they are those of a cubic Bézier triangle
/// whose edges follow the nodal gradients, and whose middle keeps quadratics exact (Farin, Curves
/// and Surfaces for CAGD, 5th ed., section 17.3; the scheme of PN triangles, Vlachos et al. 2001).
#[derive(Clone, Debug)]
pub(crate) struct Interpolant {
    /// Of faces, or of their four parts.
    rows_of_face: Vec<[u32; N_CUBIC]>,
    is_subdivided: bool,
    n_basis: usize,
    n_rows: usize,
    /// Three-node faces only: weights of nodal values in the edges' control values.
    edges: Vec<EdgeRow>,
}

/// One control value on an edge: the value at `node`, and a third of its slope along the edge.
#[derive(Clone, Debug)]
struct EdgeRow {
    node: u32,
    slope: Vec<(u32, f64)>,
}

/// Weights of a face's control values: value, and slopes along the two tangents.
pub(crate) struct Weights {
    pub(crate) value: [f64; N_CUBIC],
    pub(crate) slope: [[f64; N_CUBIC]; 2],
}

impl Interpolant {
    pub(crate) fn new(skin: &Skin) -> Self {
        if skin.is_quadratic() {
            let rows = |face: usize| {
                let nodes = skin.face(face as u32);
                std::array::from_fn(|i| if i < 6 { nodes[i] } else { 0 })
            };
            return Self {
                rows_of_face: (0..skin.n_faces()).map(rows).collect(),
                is_subdivided: false,
                n_basis: 6,
                n_rows: skin.n_nodes(),
                edges: Vec::new(),
            };
        }
        Self::cubic(skin)
    }

    /// Values on subdivided six-node faces.
    pub(crate) fn subdivided(faces: &SubdividedFaces) -> Self {
        let rows = |rows: &[u32; 6]| std::array::from_fn(|i| if i < 6 { rows[i] } else { 0 });
        Self {
            rows_of_face: faces.rows_of_part.iter().map(rows).collect(),
            is_subdivided: true,
            n_basis: 6,
            n_rows: faces.points.len(),
            edges: Vec::new(),
        }
    }

    pub(crate) fn is_subdivided(&self) -> bool {
        self.is_subdivided
    }

    fn cubic(skin: &Skin) -> Self {
        let n_nodes = skin.n_nodes();
        let near = Neighbourhood::new(skin);
        let gradients: Vec<_> =
            (0..n_nodes).map(|node| gradient_weights(skin, &near, node as u32)).collect();
        let mut edges = Vec::new();
        let mut place = std::collections::BTreeMap::new();
        let mut rows_of_face = Vec::with_capacity(skin.n_faces());
        for face in 0..skin.n_faces() {
            let nodes = skin.face(face as u32);
            let mut rows = [0; N_CUBIC];
            rows[..3].copy_from_slice(&nodes[..3]);
            for edge in 0..3 {
                let (a, b) = (nodes[edge], nodes[(edge + 1) % 3]);
                for (slot, (from, to)) in [(a, b), (b, a)].into_iter().enumerate() {
                    let row = *place.entry((from, to)).or_insert_with(|| {
                        edges.push(edge_row(skin, from, to, &gradients[from as usize]));
                        (n_nodes + edges.len() - 1) as u32
                    });
                    rows[3 + 2 * edge + slot] = row;
                }
            }
            rows_of_face.push(rows);
        }
        let first_middle = n_nodes + edges.len();
        for (face, rows) in rows_of_face.iter_mut().enumerate() {
            rows[9] = (first_middle + face) as u32;
        }
        Self {
            n_rows: first_middle + rows_of_face.len(),
            rows_of_face,
            is_subdivided: false,
            n_basis: N_CUBIC,
            edges,
        }
    }

    /// Control values `[n_rows, width]` of nodal values `[n_nodes, width]`.
    pub(crate) fn control(&self, nodal: &[f64], width: usize) -> Vec<f64> {
        let mut rows = nodal.to_vec();
        rows.resize(self.n_rows * width, 0.0);
        if self.n_basis == 6 {
            return rows;
        }
        let first_edge = nodal.len() / width;
        for (i, edge) in self.edges.iter().enumerate() {
            let at = (first_edge + i) * width;
            for c in 0..width {
                let own = nodal[edge.node as usize * width + c];
                let slope: f64 =
                    edge.slope.iter().map(|&(node, w)| w * nodal[node as usize * width + c]).sum();
                rows[at + c] = own + slope / 3.0;
            }
        }
        for face in &self.rows_of_face {
            for c in 0..width {
                let sum = |rows: &[f64], ids: &[u32]| -> f64 {
                    ids.iter().map(|&r| rows[r as usize * width + c]).sum()
                };
                let middle = sum(&rows, &face[3..9]) / 4.0 - sum(&rows, &face[..3]) / 6.0;
                rows[face[9] as usize * width + c] = middle;
            }
        }
        rows
    }

    pub(crate) fn value_weights(&self, bary: &[f64; 3]) -> [f64; N_CUBIC] {
        if self.n_basis == N_CUBIC {
            return basis::cubic(bary);
        }
        if self.is_subdivided {
            return widened(&basis::quadratic(&subdivided_faces::part_of(bary).1));
        }
        widened(&basis::quadratic(bary))
    }

    pub(crate) fn weights(&self, bary: &[f64; 3], frame: &Frame) -> Weights {
        let by_parent = if self.n_basis == N_CUBIC {
            basis::cubic_gradient(bary)
        } else if self.is_subdivided {
            subdivided_faces::gradient(bary).map(|row| widened(&row))
        } else {
            basis::quadratic_gradient(bary).map(|row| widened(&row))
        };
        let slope = frame
            .parent_by_step
            .map(|[a, b]| std::array::from_fn(|i| a * by_parent[0][i] + b * by_parent[1][i]));
        Weights { value: self.value_weights(bary), slope }
    }

    /// Σ weightᵢ rowᵢ over the control values of `point`'s face, into `out` `[width]`; `rows` is
    /// `[n_rows, width]`, `width` a multiple of 4.
    #[inline]
    pub(crate) fn combine(
        &self,
        rows: &[f64],
        point: &SkinPoint,
        weights: &[f64; N_CUBIC],
        out: &mut [f64],
    ) {
        let width = out.len();
        out.fill(0.0);
        let ids = self.rows_at(point);
        for i in 0..self.n_basis {
            let at = ids[i] as usize * width;
            add_scaled(out, weights[i], &rows[at..at + width]);
        }
    }

    /// Column `column` of [`Interpolant::combine`].
    pub(crate) fn combine_one(
        &self,
        rows: &[f64],
        width: usize,
        point: &SkinPoint,
        weights: &[f64; N_CUBIC],
        column: usize,
    ) -> f64 {
        let ids = self.rows_at(point);
        (0..self.n_basis).map(|i| weights[i] * rows[ids[i] as usize * width + column]).sum()
    }

    #[inline]
    fn rows_at(&self, point: &SkinPoint) -> &[u32; N_CUBIC] {
        if self.is_subdivided {
            let (part, _) = subdivided_faces::part_of(&point.bary());
            return &self.rows_of_face[N_PARTS * point.face() + part];
        }
        &self.rows_of_face[point.face()]
    }
}

fn widened(six: &[f64; 6]) -> [f64; N_CUBIC] {
    let mut ten = [0.0; N_CUBIC];
    ten[..6].copy_from_slice(six);
    ten
}

/// The slope along the edge from its gradient weights at `from`.
fn edge_row(skin: &Skin, from: u32, to: u32, gradient: &[(u32, Vector3<f64>)]) -> EdgeRow {
    let along = skin.nodes()[to as usize] - skin.nodes()[from as usize];
    let slope = gradient.iter().map(|(node, weight)| (*node, weight.dot(&along)));
    EdgeRow { node: from, slope: slope.collect() }
}
