//! The best thinner layers, of a layer's weights or of what it does to samples.

use crate::error::{NetsError, check_length};
use crate::forward::Scratch;
use crate::mlp::{Layer, Mlp};
use crate::net::Net;
use crate::rows::{Rows, axpy, dot};

use super::{LowRank, LowRankInfo};

/// Rounds of the subspace iteration; each multiplies the share of what is left out by the square of
/// the ratio of the singular values.
const ROUNDS: usize = 5;

impl LowRank {
    /// The best rank-`rank` approximation of the weights of layer `layer` in the least-squares
    /// sense: the first singular vectors of W.
    ///
    /// Fails if there is no such layer, or if the rank is 0 or not below both widths.
    pub fn of_weights(
        net: &Net,
        layer: usize,
        rank: usize,
    ) -> Result<(Self, LowRankInfo), NetsError> {
        let original = layer_of(net.mlp(), layer)?;
        let n_out = original.bias.len();
        let n_in = original.weights.len() / n_out;
        let mut columns = Rows::new(n_in, n_out);
        for (o, row) in original.weights.chunks_exact(n_in).enumerate() {
            for (i, &w) in row.iter().enumerate() {
                columns.row_mut(i)[o] = f64::from(w);
            }
        }
        Self::onto(layer, original, &columns, original.bias.clone(), rank)
    }

    /// The approximation of layer `layer` that loses least on samples `x` `[n, inputs]`, raw
    /// units: the first modes of the layer's sums (proper orthogonal decomposition; L. Sirovich,
    /// "Turbulence and the dynamics of coherent structures", Quart. Appl. Math. 45, 1987). For the
    /// last layer the loss is in raw units of the outputs.
    ///
    /// Fails as [`LowRank::of_weights`] does, and on samples that are not whole rows, or fewer than
    /// `rank`.
    pub fn of_samples(
        net: &Net,
        layer: usize,
        x: &[f32],
        rank: usize,
    ) -> Result<(Self, LowRankInfo), NetsError> {
        let original = layer_of(net.mlp(), layer)?;
        let n_out = original.bias.len();
        let is_last = layer + 1 == net.mlp().layers().len();
        let unit: Vec<f64> = match is_last {
            true => net.output_scale().std().iter().map(|&s| f64::from(s)).collect(),
            false => vec![1.0; n_out],
        };
        let mut sums = sums_of(net, layer, x)?;
        check_rank(rank, sums.n.min(n_out))?;
        for row in sums.iter_mut() {
            row.iter_mut().zip(&unit).for_each(|(v, u)| *v *= u);
        }
        let mean = sums.centre();
        let scaled = scaled_rows(original, &unit);
        let mean_f32: Vec<f32> = mean.iter().map(|&m| m as f32).collect();
        let (mut low_rank, info) = Self::onto(layer, &scaled, &sums, mean_f32, rank)?;
        let expand = &mut low_rank.expand;
        // An output that never varied has the unit 0, and is its mean whatever its sum.
        let per = |v: f32, u: f64| match u > 0.0 {
            true => (f64::from(v) / u) as f32,
            false => 0.0,
        };
        for (row, u) in expand.weights.chunks_exact_mut(rank).zip(&unit) {
            row.iter_mut().for_each(|w| *w = per(*w, *u));
        }
        for (bias, u) in expand.bias.iter_mut().zip(&unit) {
            *bias = per(*bias, *u);
        }
        Ok((low_rank, info))
    }

    /// Projects the layer's sums onto the first modes of `rows` around `centre`:
    /// U Uᵀ (W a + b − c) + c.
    fn onto(
        layer: usize,
        original: &Layer,
        rows: &Rows,
        centre: Vec<f32>,
        rank: usize,
    ) -> Result<(Self, LowRankInfo), NetsError> {
        let n_out = original.bias.len();
        let n_in = original.weights.len() / n_out;
        check_rank(rank, n_in.min(n_out))?;
        let modes = modes(rows, rank);
        let left_out = left_out(rows, &modes);
        let mut reduce = vec![0.0f64; rank * n_in];
        for (o, row) in original.weights.chunks_exact(n_in).enumerate() {
            for (r, reduced) in reduce.chunks_exact_mut(n_in).enumerate() {
                axpy(modes.row(r)[o], row.iter().map(|&w| f64::from(w)), reduced);
            }
        }
        let offset = original.bias.iter().zip(&centre);
        let offset: Vec<f64> = offset.map(|(b, c)| f64::from(b - c)).collect();
        let mut bias: Vec<f64> = centre.iter().map(|&c| f64::from(c)).collect();
        for mode in modes.iter() {
            axpy(dot(mode, &offset), mode.iter().copied(), &mut bias);
        }
        let expand = (0..n_out).flat_map(|o| (0..rank).map(move |r| (o, r)));
        let low_rank = Self {
            layer,
            reduce: Layer {
                weights: reduce.iter().map(|&w| w as f32).collect(),
                bias: vec![0.0; rank],
            },
            expand: Layer {
                weights: expand.map(|(o, r)| modes.row(r)[o] as f32).collect(),
                bias: bias.iter().map(|&b| b as f32).collect(),
            },
        };
        Ok((low_rank, LowRankInfo { rank, left_out }))
    }
}

/// Orthonormal modes `[rank, width]` that span the first right singular vectors of `rows`, by
/// subspace iteration (G. Golub and C. Van Loan, Matrix Computations, 4th ed., section 8.2.4).
fn modes(rows: &Rows, rank: usize) -> Rows {
    let mut modes = Rows::random_orthonormal(rank, rows.width);
    for _ in 0..ROUNDS {
        let mut next = Rows::new(rank, rows.width);
        for row in rows.iter() {
            for r in 0..rank {
                let share = dot(modes.row(r), row);
                axpy(share, row.iter().copied(), next.row_mut(r));
            }
        }
        modes = next;
        modes.orthonormalise();
    }
    modes
}

fn left_out(rows: &Rows, modes: &Rows) -> f64 {
    let (mut all, mut kept) = (0.0, 0.0);
    for row in rows.iter() {
        all += dot(row, row);
        kept += modes.iter().map(|mode| dot(mode, row).powi(2)).sum::<f64>();
    }
    if all > 0.0 { (1.0 - kept / all).max(0.0) } else { 0.0 }
}

/// Sums `W a + b` of layer `layer` for raw samples `x`, one row each.
fn sums_of(net: &Net, layer: usize, x: &[f32]) -> Result<Rows, NetsError> {
    let spec = net.mlp().spec();
    let n = x.len() / spec.inputs;
    check_length("samples of a low rank", n * spec.inputs, x.len())?;
    let layers = net.mlp().layers()[..=layer].to_vec();
    let mut head = spec.clone();
    head.hidden.truncate(layer);
    head.outputs = layers[layer].bias.len();
    let head = Mlp::from_layers(&head, layers)?;
    let mut standardised = x.to_vec();
    net.input_scale().apply(&mut standardised);
    let mut out = vec![0.0; n * head.spec().outputs];
    head.forward_batch(&standardised, &mut Scratch::default(), &mut out)?;
    Ok(Rows::of(n, head.spec().outputs, &out))
}

/// The layer with its outputs in other units.
fn scaled_rows(layer: &Layer, unit: &[f64]) -> Layer {
    let n_in = layer.weights.len() / layer.bias.len();
    let scaled = |value: f32, unit: f64| (f64::from(value) * unit) as f32;
    let weights = layer.weights.chunks_exact(n_in).zip(unit);
    let bias = layer.bias.iter().zip(unit);
    Layer {
        weights: weights.flat_map(|(row, &u)| row.iter().map(move |&w| scaled(w, u))).collect(),
        bias: bias.map(|(&b, &u)| scaled(b, u)).collect(),
    }
}

fn layer_of(mlp: &Mlp, layer: usize) -> Result<&Layer, NetsError> {
    let n_layers = mlp.layers().len();
    mlp.layers().get(layer).ok_or(NetsError::NoSuchLayer { layer, n_layers })
}

fn check_rank(rank: usize, most: usize) -> Result<(), NetsError> {
    if (1..=most).contains(&rank) {
        return Ok(());
    }
    Err(NetsError::Rank { rank, most })
}
