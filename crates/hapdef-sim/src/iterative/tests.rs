//! Laws of the preconditioner and its parts.

use std::sync::Arc;

use hapdef_mesh::{FeNodeId, Tet10Mesh, kuhn_block};
use nalgebra::Point3;

use super::aggregate::Modes;
use super::bsr::Bsr;
use super::multigrid::{Multigrid, NearNull};
use super::{CornerInterpolation, MultigridParams, rigid_modes, smoother};
use crate::elements::element_set::{Elements, SolidElements};
use crate::factor::ordering::{Cliques, NodeGraph};
use crate::supports::conditions::Held;
use crate::supports::unknowns::Unknowns;
use crate::system::assembly::{BlockMatrix, BlockPattern, assemble};
use crate::{IsotropicMaterial, SimError, Supports};

/// A bar of unit cubes along x, each cut in six ten-node tetrahedra about its main diagonal.
fn bar(n_cells: usize) -> Tet10Mesh {
    let stretch = |p: Point3<f64>| Point3::new(n_cells as f64 * p.x, p.y, p.z);
    kuhn_block([n_cells, 1, 1], stretch).expect("a valid bar")
}

struct Problem {
    matrix: BlockMatrix,
    modes: Vec<Modes<3>>,
    corners: CornerInterpolation,
}

fn problem(n_cells: usize, clamped_at: f64) -> Problem {
    let mesh = bar(n_cells);
    let ids = (0..mesh.nodes().len()).map(FeNodeId::from_index);
    let clamped: Vec<FeNodeId> = ids.filter(|&n| mesh.position(n).x == clamped_at).collect();
    let material = IsotropicMaterial::new(2e9, 0.3, 1000.0).expect("valid");
    let elements = SolidElements::new(&mesh, &material, &[], None).expect("one material");
    let held = Held::new(&clamped, &Supports::default(), mesh.nodes().len(), false).expect("held");
    let unknowns = Unknowns::natural(mesh.nodes(), 1, &held, &[]).expect("free nodes");
    let mut cliques = Cliques::default();
    for element in 0..elements.n_elements() {
        let nodes = elements.nodes(element).iter();
        cliques.push(nodes.flat_map(|&node| unknowns.translation(node).places()));
    }
    let graph = NodeGraph::build(unknowns.n_places(), &cliques);
    let pattern = Arc::new(BlockPattern::build(&graph));
    let assembled = assemble(&elements, &[], &unknowns, pattern).expect("assembled");
    Problem {
        matrix: assembled.matrix,
        modes: rigid_modes(mesh.nodes(), &unknowns),
        corners: CornerInterpolation::build(&elements, &unknowns).expect("ten-node tetrahedra"),
    }
}

impl Problem {
    fn n(&self) -> usize {
        self.modes.len()
    }

    fn multigrid(&self, with_corners: bool) -> Result<Multigrid, SimError> {
        let near_null =
            NearNull { modes: &self.modes, corners: with_corners.then_some(&self.corners) };
        let params = MultigridParams { dense_below: 100, ..MultigridParams::default() };
        Multigrid::build(&self.matrix, &near_null, &params)
    }
}

/// Values without structure.
fn vector(n: usize, seed: usize) -> Vec<[f64; 1]> {
    let value = |i: usize| ((i * i + 7 * i * seed + seed) as f64 * 0.618_033_988_749_895).fract();
    (0..n).map(|i| [value(i) - 0.5]).collect()
}

fn dot(a: &[[f64; 1]], b: &[[f64; 1]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a[0] * b[0]).sum()
}

#[test]
fn the_preconditioner_is_symmetric_positive_definite() {
    let problem = problem(30, 0.0);
    let n = 3 * problem.n();
    for with_corners in [true, false] {
        let multigrid = problem.multigrid(with_corners).expect("held");
        assert!(multigrid.info().n_equations.len() >= 3, "{:?}", multigrid.info());
        for seed in 1..6 {
            let (a, b) = (vector(n, seed), vector(n, seed + 10));
            let (mut ma, mut mb) = (a.clone(), b.clone());
            multigrid.apply(&a, &mut ma);
            multigrid.apply(&b, &mut mb);
            let (left, right) = (dot(&a, &mb), dot(&ma, &b));
            let size = (dot(&a, &ma) * dot(&b, &mb)).sqrt();
            assert!(dot(&a, &ma) > 0.0 && dot(&b, &mb) > 0.0);
            assert!((left - right).abs() < 1e-12 * size, "{left:e} against {right:e}");
        }
    }
}

#[test]
fn a_floating_body_is_singular_with_a_node_named() {
    let problem = problem(30, -1.0);
    for with_corners in [true, false] {
        let error = problem.multigrid(with_corners).expect_err("floating");
        let (SimError::Singular { node, .. } | SimError::NotPositiveDefinite { node, .. }) = error
        else {
            panic!("{error}");
        };
        assert!(node < problem.n());
    }
}

#[test]
fn corners_carry_rigid_motions_to_all_nodes() {
    let problem = problem(3, -1.0);
    let n = problem.n();
    let sequence: Vec<u32> = (0..n as u32).rev().collect();
    let (p, corner_rows) = problem.corners.matrix(&sequence);
    assert_eq!(corner_rows.len(), 16);
    let flat = |rows: &[u32]| -> Vec<[f64; 6]> {
        rows.iter().flat_map(|&row| problem.modes[row as usize]).collect()
    };
    let mut fine = vec![[0.0; 6]; 3 * n];
    p.multiply(&flat(&corner_rows), &mut fine);
    let expected = flat(&sequence);
    for (found, expected) in fine.as_flattened().iter().zip(expected.as_flattened()) {
        assert!((found - expected).abs() < 1e-14);
    }
}

#[test]
fn products_and_transposes_agree_with_multiplication() {
    let problem = problem(4, 0.0);
    let n = problem.n();
    let sequence: Vec<u32> = (0..n as u32).map(|i| (i * 7) % n as u32).collect();
    assert_ne!(n % 7, 0, "7 must not divide the rows");
    let a = Bsr::from_symmetric(&problem.matrix, &sequence);
    let (p, _) = problem.corners.matrix(&sequence);
    let x = vector(3 * p.n_cols, 3);
    let (mut px, mut apx, mut both) = (vec![[0.0]; 3 * n], vec![[0.0]; 3 * n], vec![[0.0]; 3 * n]);
    p.multiply(&x, &mut px);
    a.multiply(&px, &mut apx);
    a.product(&p).multiply(&x, &mut both);
    let y = vector(3 * n, 5);
    let mut pty = vec![[0.0]; x.len()];
    p.transpose().multiply(&y, &mut pty);
    let size = dot(&apx, &apx).sqrt();
    let miss = apx.iter().zip(&both).map(|(a, b)| (a[0] - b[0]).abs());
    assert!(miss.fold(0.0, f64::max) < 1e-13 * size);
    assert!((dot(&pty, &x) - dot(&y, &px)).abs() < 1e-12);
}

#[test]
fn the_polynomial_covers_the_spectrum() {
    let problem = problem(6, 0.0);
    let n = problem.n();
    let sequence: Vec<u32> = (0..n as u32).collect();
    let a = Bsr::from_symmetric(&problem.matrix, &sequence);
    let smoother = smoother::Smoother::build(&a, 2, 20.0).expect("positive definite");
    let dense = nalgebra::DMatrix::from_fn(3 * n, 3 * n, |i, j| {
        let row = a.row(i / 3).find(|(column, _)| *column == j / 3);
        row.map_or(0.0, |(_, block)| block[i % 3][j % 3])
    });
    let mut inverse = nalgebra::DMatrix::zeros(3 * n, 3 * n);
    for row in 0..n {
        for (i, values) in smoother.inverse(row).iter().enumerate() {
            (0..3).for_each(|j| inverse[(3 * row + i, 3 * row + j)] = values[j]);
        }
    }
    let half = inverse.cholesky().expect("positive definite").l();
    let similar = half.transpose() * dense * half;
    let largest = similar.symmetric_eigenvalues().max();
    assert!(largest < smoother.largest, "{largest} above {}", smoother.largest);
    assert!(smoother.largest < 1.2 * largest, "{largest} below {}", smoother.largest);
}
