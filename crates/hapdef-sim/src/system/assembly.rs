//! The stiffness matrix of the unknowns: its upper triangle in 3 × 3 blocks.

use std::sync::Arc;

use hapdef_mesh::FeNodeId;
use nalgebra::Matrix3;
use pulp::Arch;
use rayon::prelude::*;

use crate::SimError;
use crate::elements::element_set::Elements;
use crate::elements::rounding::rigid_force;
use crate::factor::ordering::NodeGraph;
use crate::supports::conditions::FaceSpring;
use crate::supports::unknowns::{Link, Unknowns};

/// The range of the elements' largest stiffness coefficients, as ANSYS prints it ("range of element
/// maximum matrix coefficients in global coordinates").
///
/// An element's largest coefficient is its largest diagonal entry: in a positive semidefinite
/// matrix no entry exceeds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StiffnessExtremes {
    /// The largest of these coefficients, N/m.
    pub largest_n_m: f64,
    /// The element it belongs to, counted from 0.
    pub largest_element: usize,
    /// The smallest of these coefficients, N/m.
    pub smallest_n_m: f64,
    /// The element it belongs to, counted from 0.
    pub smallest_element: usize,
}

/// Which blocks of the upper triangle are stored: row by row, the diagonal block first.
#[derive(Debug)]
pub(crate) struct BlockPattern {
    pub(crate) row_ptr: Vec<usize>,
    pub(crate) columns: Vec<u32>,
}

/// A symmetric matrix in 3 × 3 blocks, row-major; only the upper triangle is kept.
#[derive(Debug)]
pub(crate) struct BlockMatrix {
    pub(crate) pattern: Arc<BlockPattern>,
    pub(crate) blocks: Vec<[f64; 9]>,
}

/// Elements whose matrices are made side by side before they are added in order.
const CHUNK: usize = 512;

impl BlockPattern {
    pub(crate) fn build(graph: &NodeGraph) -> Self {
        let n = graph.row_ptr.len() - 1;
        let mut pattern =
            Self { row_ptr: vec![0], columns: Vec::with_capacity(graph.neighbours.len() / 2 + n) };
        for place in 0..n {
            pattern.columns.push(place as u32);
            let later = graph.of(place).iter().filter(|&&other| other as usize > place);
            pattern.columns.extend(later);
            pattern.row_ptr.push(pattern.columns.len());
        }
        pattern
    }

    pub(crate) fn n_rows(&self) -> usize {
        self.row_ptr.len() - 1
    }

    fn find(&self, row: usize, column: usize) -> Option<usize> {
        let range = self.row_ptr[row]..self.row_ptr[row + 1];
        let within = self.columns[range].binary_search(&(column as u32)).ok()?;
        Some(self.row_ptr[row] + within)
    }
}

/// An assembled matrix, and what was seen of its elements.
pub(crate) struct Assembled {
    pub(crate) matrix: BlockMatrix,
    pub(crate) extremes: StiffnessExtremes,
    /// The largest [`rigid_force`] of an element.
    pub(crate) rigid_force: f64,
}

/// Assembles the stiffness of `elements` and `springs`; call inside the thread pool.
pub(crate) fn assemble(
    elements: &dyn Elements,
    springs: &[FaceSpring],
    unknowns: &Unknowns,
    pattern: Arc<BlockPattern>,
) -> Result<Assembled, SimError> {
    let blocks = vec![[0.0; 9]; pattern.columns.len()];
    let mut matrix = BlockMatrix { pattern, blocks };
    let mut extremes = StiffnessExtremes::none();
    let mut largest_rigid_force = 0.0_f64;
    let n_elements = elements.n_elements();
    let mut buffers: Vec<Vec<f64>> = vec![Vec::new(); CHUNK.min(n_elements)];
    for start in (0..n_elements).step_by(CHUNK) {
        let chunk = &mut buffers[..CHUNK.min(n_elements - start)];
        let made: Vec<Result<f64, SimError>> = chunk
            .par_iter_mut()
            .enumerate()
            .map(|(i, k)| {
                let n = 3 * elements.motions_per_node() * elements.nodes(start + i).len();
                k.resize(n * n, 0.0);
                elements.stiffness(start + i, k)?;
                let nodes = elements.nodes(start + i).iter();
                let nodes: Vec<_> = nodes.map(|n| elements.positions()[n.index()]).collect();
                Ok(rigid_force(k, &nodes, elements.has_rotations()))
            })
            .collect();
        for ((element, k), made) in (start..).zip(chunk).zip(made) {
            largest_rigid_force = largest_rigid_force.max(made?);
            extremes.take(k, element);
            let nodes = elements.nodes(element);
            let motions = motions_of(nodes, elements.motions_per_node());
            if !moves_as_one(&motions, unknowns) {
                matrix.add(&motions, k, unknowns).ok_or(SimError::OtherMesh { element })?;
            }
        }
    }
    for spring in springs {
        matrix.add_spring(spring, unknowns);
    }
    matrix.fill_held(unknowns);
    Ok(Assembled { matrix, extremes, rigid_force: largest_rigid_force })
}

/// The motions of an element's nodes.
pub(crate) fn motions_of(nodes: &[FeNodeId], per_node: usize) -> Vec<usize> {
    nodes
        .iter()
        .flat_map(|node| (0..per_node).map(move |second| per_node * node.index() + second))
        .collect()
}

/// Whether all motions follow one rigid body: then nothing deforms, and only rounding would be
/// added.
pub(crate) fn moves_as_one(motions: &[usize], unknowns: &Unknowns) -> bool {
    let rigid_body = |motion: usize| match unknowns.link(motion) {
        Link::Tied { rotation, .. } => Some(*rotation),
        _ => None,
    };
    let per_node = unknowns.motions_per_node();
    let mut translations = motions.iter().step_by(per_node);
    let first = translations.next().and_then(|&motion| rigid_body(motion));
    first.is_some() && translations.all(|&motion| rigid_body(motion) == first)
}

impl StiffnessExtremes {
    fn none() -> Self {
        Self {
            largest_n_m: f64::NEG_INFINITY,
            largest_element: 0,
            smallest_n_m: f64::INFINITY,
            smallest_element: 0,
        }
    }

    fn take(&mut self, k: &[f64], element: usize) {
        let n = k.len().isqrt();
        let coefficient = k.iter().step_by(n + 1).copied().fold(0.0, f64::max);
        if coefficient > self.largest_n_m {
            (self.largest_n_m, self.largest_element) = (coefficient, element);
        }
        if coefficient < self.smallest_n_m {
            (self.smallest_n_m, self.smallest_element) = (coefficient, element);
        }
    }
}

impl BlockMatrix {
    /// Adds the stiffness `k` `[n, n]` of an element's motions; nothing where the pattern has no
    /// room for it.
    fn add(&mut self, motions: &[usize], k: &[f64], unknowns: &Unknowns) -> Option<()> {
        let n = 3 * motions.len();
        for (i, &row_motion) in motions.iter().enumerate() {
            for (j, &column_motion) in motions.iter().enumerate() {
                let block = |c: usize| k[(3 * i + c / 3) * n + 3 * j + c % 3];
                match (unknowns.link(row_motion), unknowns.link(column_motion)) {
                    (Link::Free(row), Link::Free(column)) => {
                        if row > column {
                            continue;
                        }
                        let slot = self.pattern.find(*row as usize, *column as usize)?;
                        for (c, value) in self.blocks[slot].iter_mut().enumerate() {
                            *value += block(c);
                        }
                    }
                    (row, column) => {
                        let block = Matrix3::from_fn(|r, c| block(3 * r + c));
                        self.add_linked(row, column, &block)?;
                    }
                }
            }
        }
        Some(())
    }

    /// Adds Tᵀ K T for one block between two motions.
    fn add_linked(&mut self, row: &Link, column: &Link, block: &Matrix3<f64>) -> Option<()> {
        for (row, row_t) in row.terms() {
            for (column, column_t) in column.terms().filter(|(column, _)| row <= *column) {
                let slot = self.pattern.find(row, column)?;
                let block = row_t.transpose() * block * column_t;
                for (c, value) in self.blocks[slot].iter_mut().enumerate() {
                    *value += block[(c / 3, c % 3)];
                }
            }
        }
        Some(())
    }

    fn add_spring(&mut self, spring: &FaceSpring, unknowns: &Unknowns) {
        let n = spring.nodes.len();
        for (i, &row) in spring.nodes.iter().enumerate() {
            for (j, &column) in spring.nodes.iter().enumerate() {
                let (row, column) = (unknowns.translation(row), unknowns.translation(column));
                let added = self.add_linked(row, column, &spring.blocks[n * i + j]);
                debug_assert!(added.is_some(), "the pattern holds every spring");
            }
        }
    }

    /// Gives held directions of roller unknowns a stiffness of their own, the mean of the free
    /// ones, so that they stay zero.
    fn fill_held(&mut self, unknowns: &Unknowns) {
        for link in unknowns.links() {
            let Link::Roller(place, projector) = link else {
                continue;
            };
            let block = &mut self.blocks[self.pattern.row_ptr[*place as usize]];
            let free = projector.trace();
            let stiffness = (block[0] + block[4] + block[8]) / free.max(1.0);
            for (c, value) in block.iter_mut().enumerate() {
                let held = f64::from(u8::from(c % 4 == 0)) - projector[(c / 3, c % 3)];
                *value += stiffness * held;
            }
        }
    }

    /// 1/√Kᵢᵢ for each equation: the scaling that makes the diagonal 1.
    pub(crate) fn jacobi_scale(&self) -> Vec<f64> {
        (0..self.pattern.n_rows())
            .flat_map(|row| {
                let d = &self.blocks[self.pattern.row_ptr[row]];
                [d[0], d[4], d[8]].map(|d| 1.0 / d.sqrt())
            })
            .collect()
    }

    /// ‖S K S‖∞, the largest row sum of magnitudes.
    pub(crate) fn scaled_norm(&self, scale: &[f64]) -> f64 {
        let mut sums = vec![0.0; scale.len()];
        for row in 0..self.pattern.n_rows() {
            for slot in self.pattern.row_ptr[row]..self.pattern.row_ptr[row + 1] {
                let column = self.pattern.columns[slot] as usize;
                for (c, value) in self.blocks[slot].iter().enumerate() {
                    let (i, j) = (3 * row + c / 3, 3 * column + c % 3);
                    let size = (value * scale[i] * scale[j]).abs();
                    sums[i] += size;
                    if row != column {
                        sums[j] += size;
                    }
                }
            }
        }
        sums.into_iter().fold(0.0, f64::max)
    }

    /// y += factor · K x for `k` columns at once; `x`, `y` `[n_equations, k]`, row-major.
    pub(crate) fn multiply_add(&self, factor: f64, x: &[f64], k: usize, y: &mut [f64]) {
        Arch::new().dispatch(
            #[inline(always)]
            || {
                for row in 0..self.pattern.n_rows() {
                    for slot in self.pattern.row_ptr[row]..self.pattern.row_ptr[row + 1] {
                        let column = self.pattern.columns[slot] as usize;
                        let block = self.blocks[slot].map(|v| factor * v);
                        multiply_block(&block, row, column, x, k, y);
                    }
                }
            },
        );
    }
}

/// y_row += A x_column and, off the diagonal, y_column += Aᵀ x_row.
#[inline(always)]
fn multiply_block(a: &[f64; 9], row: usize, column: usize, x: &[f64], k: usize, y: &mut [f64]) {
    let (x0, x1, x2) = thirds(&x[3 * column * k..], k);
    if row == column {
        let (y0, y1, y2) = thirds_mut(&mut y[3 * row * k..], k);
        for l in 0..k {
            y0[l] += a[0] * x0[l] + a[1] * x1[l] + a[2] * x2[l];
            y1[l] += a[3] * x0[l] + a[4] * x1[l] + a[5] * x2[l];
            y2[l] += a[6] * x0[l] + a[7] * x1[l] + a[8] * x2[l];
        }
        return;
    }
    let (r0, r1, r2) = thirds(&x[3 * row * k..], k);
    let (head, tail) = y.split_at_mut(3 * column * k);
    let (y0, y1, y2) = thirds_mut(&mut head[3 * row * k..], k);
    let (z0, z1, z2) = thirds_mut(tail, k);
    for l in 0..k {
        y0[l] += a[0] * x0[l] + a[1] * x1[l] + a[2] * x2[l];
        y1[l] += a[3] * x0[l] + a[4] * x1[l] + a[5] * x2[l];
        y2[l] += a[6] * x0[l] + a[7] * x1[l] + a[8] * x2[l];
        z0[l] += a[0] * r0[l] + a[3] * r1[l] + a[6] * r2[l];
        z1[l] += a[1] * r0[l] + a[4] * r1[l] + a[7] * r2[l];
        z2[l] += a[2] * r0[l] + a[5] * r1[l] + a[8] * r2[l];
    }
}

#[inline(always)]
fn thirds(rows: &[f64], k: usize) -> (&[f64], &[f64], &[f64]) {
    (&rows[..k], &rows[k..2 * k], &rows[2 * k..3 * k])
}

#[inline(always)]
fn thirds_mut(rows: &mut [f64], k: usize) -> (&mut [f64], &mut [f64], &mut [f64]) {
    let (a, rest) = rows.split_at_mut(k);
    let (b, rest) = rest.split_at_mut(k);
    (a, b, &mut rest[..k])
}
