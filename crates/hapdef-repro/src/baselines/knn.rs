//! k-nearest-neighbour regression, exact by brute force.
//!
//! Distances come from blocked matrix products, ‖a‖² + ‖b‖² − 2a·b in f64 on centred rows; all
//! candidates within the rounding of that formula of the k-th smallest are then measured again
//! as Σ(aᵢ−bᵢ)² on the values as given, so the neighbours are the exact ones. Ties go to the
//! smaller row index.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use hapdef_report::ArgumentError;
use rayon::prelude::*;

use crate::error::{ReproError, check_finite, check_parameter, whole_rows};

/// Queries that one task handles; fixed, so that results do not depend on threads.
const QUERY_TILE: usize = 64;
/// Training rows of one matrix product.
const ROW_BLOCK: usize = 2048;

/// Parameters of [`Knn::neighbours`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnnParams {
    /// Neighbours averaged.
    pub k: usize,
    /// Whether a query's own training row may be its neighbour.
    pub own_row: OwnRow,
}

impl Default for KnnParams {
    /// The paper's k = 6; queries are no training rows.
    fn default() -> Self {
        Self { k: 6, own_row: OwnRow::None }
    }
}

/// How queries relate to training rows.
///
/// With weights 1/distance a training row predicts itself without error, so a training error
/// says nothing unless the row itself is left out. The paper prints training errors above zero
/// (2.3 µm and more), which can't come from queries that count themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OwnRow {
    /// Queries are not training rows: every row may be a neighbour.
    None,
    /// Query `i` is training row `first + i`, which is left out of its neighbours.
    Exclude {
        /// Training row of query 0.
        first: usize,
    },
}

/// The training inputs, ready for queries.
#[derive(Clone, Debug)]
pub struct Knn {
    n_inputs: usize,
    centre: Vec<f64>,
    /// `[n_rows, n_inputs]`, row-major, as given.
    x: Vec<f32>,
    /// `[n_inputs, n_rows]`, centred, one training row per column.
    rows: Mat<f64>,
    norm_sq: Vec<f64>,
    largest_norm_sq: f64,
}

/// Neighbours of `n` queries and their weights, nearest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Neighbours {
    k: usize,
    rows: Vec<u32>,
    weights: Vec<f64>,
    distances: Vec<f64>,
}

impl Knn {
    /// Takes the training inputs `x` `[rows, n_inputs]`, row-major. Holds them in f32 and in f64.
    pub fn new(x: &[f32], n_inputs: usize) -> Result<Self, ReproError> {
        let n = whole_rows("k-NN training inputs", n_inputs, x.len())?;
        check_finite("k-NN training inputs", n_inputs, x)?;
        if n == 0 || u32::try_from(n).is_err() {
            let what = "k-NN (at most 2³² − 1 samples)";
            return Err(ReproError::TooFewSamples { what, needed: 1, found: n });
        }
        let mut centre = vec![0.0; n_inputs];
        for row in x.chunks_exact(n_inputs) {
            centre.iter_mut().zip(row).for_each(|(c, v)| *c += f64::from(*v) / n as f64);
        }
        let rows = columns(x, &centre);
        let norm_sq = norms_sq(rows.as_ref());
        let largest_norm_sq = norm_sq.iter().copied().fold(0.0, f64::max);
        Ok(Self { n_inputs, centre, x: x.to_vec(), rows, norm_sq, largest_norm_sq })
    }

    /// Training rows held.
    pub fn n_rows(&self) -> usize {
        self.norm_sq.len()
    }

    /// The `k` nearest training rows of each query `[n, n_inputs]` and their weights 1/distance,
    /// normalised to sum 1; rows at distance 0 share the whole weight, as with scikit-learn's
    /// `weights="distance"`. Scratch per thread: about 2 MB.
    pub fn neighbours(
        &self,
        queries: &[f32],
        params: &KnnParams,
    ) -> Result<Neighbours, ReproError> {
        let n = whole_rows("k-NN queries", self.n_inputs, queries.len())?;
        check_finite("k-NN queries", self.n_inputs, queries)?;
        self.check(params, n)?;
        let tiles: Vec<Vec<(f64, u32)>> = queries
            .par_chunks(QUERY_TILE * self.n_inputs)
            .enumerate()
            .map(|(tile, queries)| self.tile(tile * QUERY_TILE, queries, params))
            .collect();
        let mut found =
            Neighbours { k: params.k, rows: vec![], weights: vec![], distances: vec![] };
        for nearest in tiles.iter().flat_map(|tile| tile.chunks_exact(params.k)) {
            found.push(nearest);
        }
        Ok(found)
    }

    fn check(&self, params: &KnnParams, n_queries: usize) -> Result<(), ReproError> {
        check_parameter("k", params.k as f64, "at least 1", params.k > 0)?;
        let excluded = match params.own_row {
            OwnRow::None => 0,
            OwnRow::Exclude { first } => {
                let len = self.n_rows();
                if n_queries > 0 && first.saturating_add(n_queries) > len {
                    let index = first.saturating_add(n_queries) - 1;
                    let position = n_queries - 1;
                    let what = "own training row of a k-NN query";
                    return Err(ArgumentError::Index { what, index, position, len }.into());
                }
                1
            }
        };
        if self.n_rows() < params.k + excluded {
            return Err(ReproError::TooFewSamples {
                what: "k-NN",
                needed: params.k + excluded,
                found: self.n_rows(),
            });
        }
        Ok(())
    }

    /// (distance, row) of the neighbours of one tile of queries, `k` per query.
    fn tile(&self, first: usize, queries: &[f32], params: &KnnParams) -> Vec<(f64, u32)> {
        let q = columns(queries, &self.centre);
        let q_norm_sq = norms_sq(q.as_ref());
        let own = |i: usize| match params.own_row {
            OwnRow::None => None,
            OwnRow::Exclude { first: own } => Some(own + first + i),
        };
        let mut candidates = vec![Vec::new(); q.ncols()];
        let mut limits = vec![f64::INFINITY; q.ncols()];
        for start in (0..self.n_rows()).step_by(ROW_BLOCK) {
            let n = ROW_BLOCK.min(self.n_rows() - start);
            let rows = self.rows.subcols(start, n).transpose();
            let mut products = Mat::<f64>::zeros(n, q.ncols());
            matmul(products.as_mut(), Accum::Replace, rows, q.as_ref(), 1.0, Par::Seq);
            for (i, found) in candidates.iter_mut().enumerate() {
                let norms_sq = &self.norm_sq[start..start + n];
                for (j, (norm_sq, product)) in
                    norms_sq.iter().zip(products.col(i).iter()).enumerate()
                {
                    let d_sq = norm_sq + q_norm_sq[i] - 2.0 * product;
                    if d_sq <= limits[i] && Some(start + j) != own(i) {
                        found.push((d_sq, (start + j) as u32));
                    }
                }
                limits[i] = keep_nearest(found, params.k, 2.0 * self.rounding(q_norm_sq[i]));
            }
        }
        let queries = queries.chunks_exact(self.n_inputs);
        let exact = candidates.into_iter().zip(queries).map(|(c, q)| self.exact(c, q, params.k));
        exact.flatten().collect()
    }

    /// A bound on the error of ‖a‖² + ‖b‖² − 2a·b: sums of n products err by at most
    /// n·u/(1 − n·u)·Σ|aᵢbᵢ| (Higham, Accuracy and Stability, 2nd ed., eq. 3.5), and
    /// |2a·b| ≤ ‖a‖² + ‖b‖²; the largest row stands for all.
    fn rounding(&self, q_norm_sq: f64) -> f64 {
        4.0 * (self.n_inputs as f64 + 4.0) * f64::EPSILON * (self.largest_norm_sq + q_norm_sq)
    }

    /// Measures the candidates again; the `k` nearest (distance, row), nearest first.
    fn exact(&self, mut found: Vec<(f64, u32)>, query: &[f32], k: usize) -> Vec<(f64, u32)> {
        for (distance, row) in &mut found {
            let first = *row as usize * self.n_inputs;
            let row = &self.x[first..first + self.n_inputs];
            let apart = |(a, b): (&f32, &f32)| f64::from(*a) - f64::from(*b);
            *distance = row.iter().zip(query).map(apart).map(|d| d * d).sum::<f64>().sqrt();
        }
        found.sort_unstable_by(by_distance);
        found.truncate(k);
        found
    }
}

fn by_distance(a: &(f64, u32), b: &(f64, u32)) -> std::cmp::Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

/// Drops what lies more than `slack` beyond the `k`-th nearest; returns that limit on d².
fn keep_nearest(found: &mut Vec<(f64, u32)>, k: usize, slack: f64) -> f64 {
    if found.len() <= k {
        return f64::INFINITY;
    }
    let (_, kth, _) = found.select_nth_unstable_by(k - 1, by_distance);
    let limit = kth.0 + slack;
    found.retain(|c| c.0 <= limit);
    limit
}

impl Neighbours {
    /// Training rows nearest to query `query`, nearest first, `[k]`.
    pub fn rows(&self, query: usize) -> &[u32] {
        &self.rows[query * self.k..(query + 1) * self.k]
    }

    /// Distances to [`Neighbours::rows`], in input units, `[k]`.
    #[cfg(test)]
    pub fn distances(&self, query: usize) -> &[f64] {
        &self.distances[query * self.k..(query + 1) * self.k]
    }

    /// Weights of [`Neighbours::rows`], summing to 1, `[k]`.
    pub fn weights(&self, query: usize) -> &[f64] {
        &self.weights[query * self.k..(query + 1) * self.k]
    }

    /// The weighted mean of the neighbours' rows of the training outputs `y` `[n_rows, n_outputs]` for query
    /// `query`, into `out` `[n_outputs]`.
    pub fn predict(&self, query: usize, y: &[f32], out: &mut [f32]) {
        let mut sums = vec![0.0_f64; out.len()];
        for (&row, &weight) in self.rows(query).iter().zip(self.weights(query)) {
            let row = &y[row as usize * out.len()..(row as usize + 1) * out.len()];
            sums.iter_mut().zip(row).for_each(|(sum, v)| *sum += weight * f64::from(*v));
        }
        out.iter_mut().zip(sums).for_each(|(o, s)| *o = s as f32);
    }

    fn push(&mut self, nearest: &[(f64, u32)]) {
        let exact = nearest.iter().filter(|n| n.0 == 0.0).count();
        let total: f64 = nearest.iter().map(|n| 1.0 / n.0).sum();
        for &(distance, row) in nearest {
            self.rows.push(row);
            self.distances.push(distance);
            self.weights.push(match (exact, distance == 0.0) {
                (0, _) => 1.0 / distance / total,
                (_, true) => 1.0 / exact as f64,
                (_, false) => 0.0,
            });
        }
    }
}

/// Row-major `x` minus `centre`, one row per column.
fn columns(x: &[f32], centre: &[f64]) -> Mat<f64> {
    let width = centre.len();
    Mat::from_fn(width, x.len() / width, |i, j| f64::from(x[j * width + i]) - centre[i])
}

fn norms_sq(columns: MatRef<'_, f64>) -> Vec<f64> {
    (0..columns.ncols()).map(|j| columns.col(j).iter().map(|v| v * v).sum()).collect()
}

#[cfg(test)]
mod tests;
