//! The stiffness matrix of the free nodes: its upper triangle in 3 × 3 blocks.

use std::sync::Arc;

use hapdef_mesh::Tet10Mesh;
use pulp::Arch;
use rayon::prelude::*;

use crate::element::{ElementMatrix, stiffness};
use crate::ordering::{NodeGraph, NodeOrder};
use crate::{IsotropicMaterial, SimError};

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
        let mut pattern = Self {
            row_ptr: vec![0],
            columns: Vec::with_capacity(graph.neighbours.len() / 2 + n),
        };
        for place in 0..n {
            pattern.columns.push(place as u32);
            let later = graph
                .of(place)
                .iter()
                .filter(|&&other| other as usize > place);
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

/// Assembles the stiffness of `mesh` with E scaled per element; call inside the thread pool.
pub(crate) fn assemble(
    mesh: &Tet10Mesh,
    material: &IsotropicMaterial,
    scale: Option<&[f64]>,
    order: &NodeOrder,
    pattern: Arc<BlockPattern>,
) -> Result<(BlockMatrix, StiffnessExtremes), SimError> {
    let blocks = vec![[0.0; 9]; pattern.columns.len()];
    let mut matrix = BlockMatrix { pattern, blocks };
    let mut extremes = StiffnessExtremes {
        largest_n_m: f64::NEG_INFINITY,
        largest_element: 0,
        smallest_n_m: f64::INFINITY,
        smallest_element: 0,
    };
    let n_elements = mesh.elements().len();
    for start in (0..n_elements).step_by(CHUNK) {
        let end = (start + CHUNK).min(n_elements);
        let chunk: Vec<Result<ElementMatrix, SimError>> = (start..end)
            .into_par_iter()
            .map(|element| {
                element_matrix(mesh, element, material, scale.map_or(1.0, |s| s[element]))
            })
            .collect();
        for (element, k) in (start..end).zip(chunk) {
            let k = k?;
            extremes.take(&k, element);
            matrix.add(mesh, element, &k, order)?;
        }
    }
    Ok((matrix, extremes))
}

fn element_matrix(
    mesh: &Tet10Mesh,
    element: usize,
    material: &IsotropicMaterial,
    scale: f64,
) -> Result<ElementMatrix, SimError> {
    let nodes = mesh.element_positions(element);
    let mut k = stiffness(&nodes, material).map_err(|point| SimError::ElementInverted {
        element,
        parent: point.parent,
        det_j_m3: point.det_j_m3,
    })?;
    for row in &mut k {
        for value in row {
            *value *= scale;
        }
    }
    Ok(k)
}

impl StiffnessExtremes {
    fn take(&mut self, k: &ElementMatrix, element: usize) {
        let coefficient = (0..30).map(|i| k[i][i]).fold(0.0, f64::max);
        if coefficient > self.largest_n_m {
            (self.largest_n_m, self.largest_element) = (coefficient, element);
        }
        if coefficient < self.smallest_n_m {
            (self.smallest_n_m, self.smallest_element) = (coefficient, element);
        }
    }
}

impl BlockMatrix {
    fn add(
        &mut self,
        mesh: &Tet10Mesh,
        element: usize,
        k: &ElementMatrix,
        order: &NodeOrder,
    ) -> Result<(), SimError> {
        let places = mesh.elements()[element].map(|node| order.place(node));
        for i in 0..10 {
            for j in 0..10 {
                let (Some(row), Some(column)) = (places[i], places[j]) else {
                    continue;
                };
                if row > column {
                    continue;
                }
                let slot = self
                    .pattern
                    .find(row, column)
                    .ok_or(SimError::OtherMesh { element })?;
                for (c, value) in self.blocks[slot].iter_mut().enumerate() {
                    *value += k[3 * i + c / 3][3 * j + c % 3];
                }
            }
        }
        Ok(())
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
