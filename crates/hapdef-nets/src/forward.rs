//! The forward pass on slices.
//!
//! A float sum has a fixed order, so the compiler may not split it; every dot product is therefore
//! kept as [`LANES`] independent sums. Four of them run together and share one operand: four rows
//! of W against one sample, or one row of W against four samples. Either way each result has the
//! same bits.

use crate::error::{NetsError, check_length};
use crate::mlp::{Layer, Mlp};

/// Buffers of a forward pass; keep one per thread and use it again and again.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    layer_in: Vec<f32>,
    layer_out: Vec<f32>,
    pub(crate) scaled: Vec<f32>,
}

/// Independent sums of a dot product.
const LANES: usize = 8;

/// Dot products that run together.
const TOGETHER: usize = 4;

/// Samples that pass a layer together, so that its weights are read once for all of them.
const BATCH_BLOCK: usize = 16;

impl Mlp {
    /// One sample: `x` is `[inputs]`, `out` is `[outputs]`, both standardised.
    ///
    /// Fails on slices of another length. NaN is not looked for; [`crate::Net::forward`] does.
    pub fn forward(
        &self,
        x: &[f32],
        scratch: &mut Scratch,
        out: &mut [f32],
    ) -> Result<(), NetsError> {
        check_length("input of a net", self.spec().inputs, x.len())?;
        check_length("output of a net", self.spec().outputs, out.len())?;
        self.forward_block(x, 1, scratch, out);
        Ok(())
    }

    /// Many samples: `x` is `[n, inputs]`, `out` is `[n, outputs]`, both standardised, row-major.
    /// Each row has the bits that [`Mlp::forward`] gives it.
    ///
    /// Fails on slices that are not whole rows, or not as many.
    pub fn forward_batch(
        &self,
        x: &[f32],
        scratch: &mut Scratch,
        out: &mut [f32],
    ) -> Result<(), NetsError> {
        let (n_in, n_out) = (self.spec().inputs, self.spec().outputs);
        let n = x.len() / n_in;
        check_length("inputs of a net", n * n_in, x.len())?;
        check_length("outputs of a net", n * n_out, out.len())?;
        let blocks = x.chunks(BATCH_BLOCK * n_in);
        for (x, out) in blocks.zip(out.chunks_mut(BATCH_BLOCK * n_out)) {
            self.forward_block(x, x.len() / n_in, scratch, out);
        }
        Ok(())
    }

    fn forward_block(&self, x: &[f32], n: usize, scratch: &mut Scratch, out: &mut [f32]) {
        let last = self.layers().len() - 1;
        scratch.layer_in.clear();
        scratch.layer_in.extend_from_slice(x);
        for layer in &self.layers()[..last] {
            let n_out = layer.bias.len();
            scratch.layer_out.resize(n * n_out, 0.0);
            layer.products(&scratch.layer_in, n, &mut scratch.layer_out);
            for z in scratch.layer_out.chunks_exact_mut(n_out) {
                self.spec().activation.apply(z, &layer.bias);
            }
            std::mem::swap(&mut scratch.layer_in, &mut scratch.layer_out);
        }
        let layer = &self.layers()[last];
        layer.products(&scratch.layer_in, n, out);
        for z in out.chunks_exact_mut(layer.bias.len()) {
            z.iter_mut().zip(&layer.bias).for_each(|(z, b)| *z += b);
        }
    }
}

impl Layer {
    /// `out[s] = W x[s]` for n samples: `x` is `[n, inputs]`, `out` is `[n, outputs]`.
    fn products(&self, x: &[f32], n: usize, out: &mut [f32]) {
        let n_out = self.bias.len();
        let n_in = self.weights.len() / n_out;
        if n == 1 {
            dots_against(&self.weights, x, out.iter_mut());
            return;
        }
        for (o, row) in self.weights.chunks_exact(n_in).enumerate() {
            dots_against(x, row, out[o..].iter_mut().step_by(n_out));
        }
    }
}

/// Dot products of every row of `rows`, `[m, shared.len()]`, with `shared`, into `out`, m places.
fn dots_against<'a>(rows: &[f32], shared: &[f32], mut out: impl Iterator<Item = &'a mut f32>) {
    let width = shared.len();
    let mut groups = rows.chunks_exact(TOGETHER * width);
    for group in &mut groups {
        let (a, b) = group.split_at(2 * width);
        let ((a, b), (c, d)) = (a.split_at(width), b.split_at(width));
        let sums = dots([a, b, c, d], shared);
        out.by_ref().zip(sums).take(TOGETHER).for_each(|(out, sum)| *out = sum);
    }
    for row in groups.remainder().chunks_exact(width) {
        let [sum] = dots([row], shared);
        if let Some(out) = out.next() {
            *out = sum;
        }
    }
}

/// Dot products of `M` rows with one slice of the same length.
#[inline]
fn dots<const M: usize>(rows: [&[f32]; M], shared: &[f32]) -> [f32; M] {
    let (shared_blocks, shared_rest) = shared.as_chunks::<LANES>();
    let rows = rows.map(|row| row.split_at(shared_blocks.len() * LANES));
    let row_blocks = rows.map(|(whole, _)| whole.as_chunks::<LANES>().0);
    let row_blocks = row_blocks.map(|blocks| &blocks[..shared_blocks.len()]);
    let mut sums = [[0.0f32; LANES]; M];
    for (i, s) in shared_blocks.iter().enumerate() {
        for m in 0..M {
            let r = &row_blocks[m][i];
            for l in 0..LANES {
                sums[m][l] += r[l] * s[l];
            }
        }
    }
    let mut result = [0.0; M];
    add_lanes(&sums, &mut result);
    for m in 0..M {
        let rest = rows[m].1.iter().zip(shared_rest).map(|(r, s)| r * s);
        result[m] = rest.fold(result[m], |sum, p| sum + p);
    }
    result
}

/// The sum of each one's lanes. On its own, since a compiler that sees it beside the loop over blocks
/// keeps the sums of equal lanes together, and shuffles every block of a row to suit.
#[inline(never)]
fn add_lanes(sums: &[[f32; LANES]], totals: &mut [f32]) {
    for (total, [a, b, c, d, e, f, g, h]) in totals.iter_mut().zip(sums) {
        *total = ((a + b) + (c + d)) + ((e + f) + (g + h));
    }
}
