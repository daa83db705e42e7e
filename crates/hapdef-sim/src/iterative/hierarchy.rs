//! The levels and the V-cycle over them.

use super::aggregate::{Aggregates, Modes};
use super::bottom::Bottom;
use super::bsr::{Block, Bsr, add_product};
use super::smoother::Smoother;

/// How the levels are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MultigridParams {
    /// Nodes i and j are strongly coupled if ‖Kᵢⱼ‖ > strength · √(‖Kᵢᵢ‖ ‖Kⱼⱼ‖); halved on each level
    /// (Vaněk, Mandel and Brezina 1996, section 5.1: 0.08).
    pub strength: f64,
    /// Degree of the Chebyshev smoother on the finest level of ten-node tetrahedra.
    pub fine_degree: usize,
    /// Degree of the Chebyshev smoother on the levels under it.
    pub degree: usize,
    /// Largest over smallest eigenvalue that the smoothers are made for.
    pub spread: f64,
    /// A level of no more equations than this is factored densely.
    pub dense_below: usize,
}

impl Default for MultigridParams {
    fn default() -> Self {
        Self { strength: 0.08, fine_degree: 3, degree: 2, spread: 20.0, dense_below: 900 }
    }
}

/// A symmetric positive definite operator close to the inverse of its level's matrix.
pub(super) trait Coarser: Sync {
    /// x ← M b.
    fn apply<const K: usize>(&self, b: &[[f64; K]], x: &mut [[f64; K]]);
}

/// One level: its matrix, its smoother and the way to the next one.
#[derive(Debug)]
pub(super) struct Level<const B: usize, const C: usize> {
    a: Bsr<B, B>,
    smoother: Smoother<B>,
    p: Bsr<B, C>,
    p_transposed: Bsr<C, B>,
}

/// A level of 3 × 3 blocks and what lies under it.
#[derive(Debug)]
pub(super) enum Solid {
    /// Ten-node tetrahedra over their corners.
    Corners(Box<Level<3, 3>>, Box<Solid>),
    Aggregates(Box<Level<3, 6>>, Box<Rigid>),
    Bottom(Bsr<3, 3>, Bottom),
}

/// A level of 6 × 6 blocks (six rigid modes per aggregate) and what lies under it.
#[derive(Debug)]
pub(super) enum Rigid {
    Aggregates(Box<Level<6, 6>>, Box<Rigid>),
    Bottom(Bottom),
}

/// Where the build met a pivot that is not positive: a row of the finest level.
pub(super) struct BadPivot {
    pub(super) row: usize,
    pub(super) direction: usize,
    pub(super) pivot: f64,
}

/// A size of each level, for the info.
pub(super) struct Sizes {
    pub(super) n_equations: Vec<usize>,
    pub(super) n_blocks: Vec<usize>,
    pub(super) bytes: usize,
}

impl<const B: usize, const C: usize> Level<B, C> {
    pub(super) fn build(a: Bsr<B, B>, smoother: Smoother<B>, p: Bsr<B, C>) -> (Self, Bsr<C, C>) {
        let p_transposed = p.transpose();
        let coarse = p_transposed.product(&a.product(&p));
        let level = Self { a, smoother, p, p_transposed };
        (level, coarse)
    }

    /// One V-cycle from zero: smooth, correct on `next`, smooth again.
    fn cycle<const K: usize>(&self, next: &impl Coarser, b: &[[f64; K]], x: &mut [[f64; K]]) {
        x.fill([0.0; K]);
        let mut r = b.to_vec();
        self.smoother.smooth(&self.a, x, &mut r);
        let mut coarse_b = vec![[0.0; K]; self.p.n_cols * C];
        self.p_transposed.multiply(&r, &mut coarse_b);
        let mut coarse_x = vec![[0.0; K]; coarse_b.len()];
        next.apply(&coarse_b, &mut coarse_x);
        self.p.add(&coarse_x, x);
        r.copy_from_slice(b);
        self.a.subtract(x, &mut r);
        self.smoother.finish(&self.a, x, &mut r);
    }

    fn count(&self, sizes: &mut Sizes) {
        sizes.n_equations.push(B * self.a.n_rows());
        sizes.n_blocks.push(self.a.blocks.len());
        sizes.bytes += self.a.bytes() + self.p.bytes() + self.p_transposed.bytes();
        sizes.bytes += 8 * B * B * self.a.n_rows();
    }
}

impl Coarser for Solid {
    fn apply<const K: usize>(&self, b: &[[f64; K]], x: &mut [[f64; K]]) {
        match self {
            Self::Corners(level, next) => level.cycle(next.as_ref(), b, x),
            Self::Aggregates(level, next) => level.cycle(next.as_ref(), b, x),
            Self::Bottom(_, bottom) => bottom.solve(b, x),
        }
    }
}

impl Coarser for Rigid {
    fn apply<const K: usize>(&self, b: &[[f64; K]], x: &mut [[f64; K]]) {
        match self {
            Self::Aggregates(level, next) => level.cycle(next.as_ref(), b, x),
            Self::Bottom(bottom) => bottom.solve(b, x),
        }
    }
}

impl Solid {
    /// Smoothed aggregation under `a`, whose near-null space is `modes`; `rows` names for each row
    /// a row of the finest level.
    pub(super) fn aggregated(
        a: Bsr<3, 3>,
        modes: &[Modes<3>],
        rows: &[u32],
        params: &MultigridParams,
    ) -> Result<Self, BadPivot> {
        if 3 * a.n_rows() <= params.dense_below {
            let bottom = bottom(&a, rows)?;
            return Ok(Self::Bottom(a, bottom));
        }
        let coarsened = Coarsened::build(a, modes, rows, 0, params)?;
        let next =
            Rigid::aggregated(coarsened.coarse, &coarsened.modes, &coarsened.rows, 1, params)?;
        Ok(Self::Aggregates(Box::new(coarsened.level), Box::new(next)))
    }

    pub(super) fn matrix(&self) -> &Bsr<3, 3> {
        match self {
            Self::Corners(level, _) => &level.a,
            Self::Aggregates(level, _) => &level.a,
            Self::Bottom(a, _) => a,
        }
    }

    pub(super) fn count(&self, sizes: &mut Sizes) {
        match self {
            Self::Corners(level, next) => {
                level.count(sizes);
                next.count(sizes);
            }
            Self::Aggregates(level, next) => {
                level.count(sizes);
                next.count(sizes);
            }
            Self::Bottom(_, bottom) => count_bottom(bottom, sizes),
        }
    }
}

impl Rigid {
    fn aggregated(
        a: Bsr<6, 6>,
        modes: &[Modes<6>],
        rows: &[u32],
        depth: i32,
        params: &MultigridParams,
    ) -> Result<Self, BadPivot> {
        if 6 * a.n_rows() <= params.dense_below {
            return bottom(&a, rows).map(Self::Bottom);
        }
        let coarsened = Coarsened::build(a, modes, rows, depth, params)?;
        let (coarse, modes, rows) = (coarsened.coarse, &coarsened.modes, &coarsened.rows);
        let next = Self::aggregated(coarse, modes, rows, depth + 1, params)?;
        Ok(Self::Aggregates(Box::new(coarsened.level), Box::new(next)))
    }

    fn count(&self, sizes: &mut Sizes) {
        match self {
            Self::Aggregates(level, next) => {
                level.count(sizes);
                next.count(sizes);
            }
            Self::Bottom(bottom) => count_bottom(bottom, sizes),
        }
    }
}

/// A level of aggregates and the matrix under it.
struct Coarsened<const B: usize> {
    level: Level<B, 6>,
    coarse: Bsr<6, 6>,
    modes: Vec<Modes<6>>,
    rows: Vec<u32>,
}

impl<const B: usize> Coarsened<B> {
    fn build(
        a: Bsr<B, B>,
        modes: &[Modes<B>],
        rows: &[u32],
        depth: i32,
        params: &MultigridParams,
    ) -> Result<Self, BadPivot> {
        let smoother = smoother(&a, rows, params.degree, params.spread)?;
        let aggregates = coarser_aggregates(&a, params.strength * 0.5_f64.powi(depth));
        let (tentative, modes) = aggregates.tentative(modes);
        let p = smoothed(&a, &smoother, tentative);
        let (level, mut coarse) = Level::build(a, smoother, p);
        fill_empty_diagonals(&mut coarse);
        let mut coarse_rows = vec![0; aggregates.n];
        for (row, &aggregate) in aggregates.of_row.iter().enumerate().rev() {
            coarse_rows[aggregate as usize] = rows[row];
        }
        Ok(Self { level, coarse, modes, rows: coarse_rows })
    }
}

/// Weak couplings stop the coarsening when nothing else is left; then every coupling counts, and at
/// last everything is one aggregate.
fn coarser_aggregates<const B: usize>(a: &Bsr<B, B>, threshold: f64) -> Aggregates {
    let enough = |aggregates: &Aggregates| 2 * aggregates.n <= a.n_rows();
    let strong = Aggregates::build(a, threshold);
    if enough(&strong) {
        return strong;
    }
    let any = Aggregates::build(a, 0.0);
    if enough(&any) {
        return any;
    }
    let half = |row: usize| (row / 2) as u32;
    Aggregates { of_row: (0..a.n_rows()).map(half).collect(), n: a.n_rows().div_ceil(2) }
}

pub(super) fn smoother<const B: usize>(
    a: &Bsr<B, B>,
    rows: &[u32],
    degree: usize,
    spread: f64,
) -> Result<Smoother<B>, BadPivot> {
    Smoother::build(a, degree, spread).map_err(|[row, direction]| BadPivot {
        row: rows[row] as usize,
        direction: direction % 3,
        pivot: 0.0,
    })
}

fn bottom<const B: usize>(a: &Bsr<B, B>, rows: &[u32]) -> Result<Bottom, BadPivot> {
    Bottom::build(a).map_err(|(row, direction, pivot)| BadPivot {
        row: rows[row] as usize,
        direction: direction % 3,
        pivot,
    })
}

/// P = (I − ω D⁻¹A) P̂ with ω = 4/3 over the largest eigenvalue of D⁻¹A (Vaněk, Mandel and Brezina
/// 1996, section 4).
fn smoothed<const B: usize>(
    a: &Bsr<B, B>,
    smoother: &Smoother<B>,
    tentative: Bsr<B, 6>,
) -> Bsr<B, 6> {
    let omega = 4.0 / 3.0 / smoother.largest;
    let mut p = a.product(&tentative);
    for row in 0..p.n_rows() {
        let inverse = smoother.inverse(row).map(|r| r.map(|v| -omega * v));
        for slot in p.row_ptr[row]..p.row_ptr[row + 1] {
            let mut block: Block<B, 6> = [[0.0; 6]; B];
            add_product(&inverse, &p.blocks[slot], &mut block);
            if p.columns[slot] == tentative.columns[row] {
                for (values, own) in block.iter_mut().zip(&tentative.blocks[row]) {
                    values.iter_mut().zip(own).for_each(|(v, own)| *v += own);
                }
            }
            p.blocks[slot] = block;
        }
    }
    p
}

/// Where an aggregate has fewer than six independent modes, the coarse matrix has empty rows: they
/// get a diagonal, so that they stay zero in every solution.
fn fill_empty_diagonals(a: &mut Bsr<6, 6>) {
    for row in 0..a.n_rows() {
        for slot in a.row_ptr[row]..a.row_ptr[row + 1] {
            if a.columns[slot] as usize != row {
                continue;
            }
            let block = &mut a.blocks[slot];
            let largest = (0..6).map(|i| block[i][i]).fold(0.0, f64::max);
            for i in 0..6 {
                if block[i][i] == 0.0 {
                    block[i][i] = if largest > 0.0 { largest } else { 1.0 };
                }
            }
        }
    }
}

fn count_bottom(bottom: &Bottom, sizes: &mut Sizes) {
    let n = bottom.n_equations();
    sizes.n_equations.push(n);
    sizes.n_blocks.push(1);
    sizes.bytes += 8 * n * n;
}
