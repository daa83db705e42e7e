//! Dense Cholesky factors of some thousand rows, in blocks, with further rows solved along.
//!
//! Sums have a fixed order, whatever vector instructions there are.

/// Columns that are finished together.
const BLOCK: usize = 64;

/// Accumulators of a dot product.
const LANES: usize = 8;

/// Length of the dot products whose operands stay in the cache.
const DEPTH: usize = 512;

/// Rows, and columns, of a tile of dot products.
const TILE: usize = 4;

/// The stride of rows with `n` entries.
pub(crate) fn stride_of(n: usize) -> usize {
    n.next_multiple_of(BLOCK)
}

/// A lower triangle of `n` rows and columns, and rows below it.
#[derive(Clone, Debug)]
pub(crate) struct Trapezoid {
    pub(crate) n: usize,
    stride: usize,
    values: Vec<f64>,
}

impl Trapezoid {
    pub(crate) fn zeros(n: usize, n_rows: usize) -> Self {
        let stride = stride_of(n);
        Self { n, stride, values: vec![0.0; n_rows * stride] }
    }

    pub(crate) fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.stride..i * self.stride + self.n]
    }

    pub(crate) fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.values[i * self.stride..i * self.stride + self.n]
    }

    /// C = L Lᵀ of the leading rows in place, and B L⁻ᵀ for the rows B below. `false` if C is not
    /// positive definite.
    #[must_use]
    pub(crate) fn factor(&mut self) -> bool {
        let (n, stride) = (self.n, self.stride);
        pulp::Arch::new().dispatch(|| factor_all(&mut self.values, n, stride))
    }

    /// The diagonal of C⁻¹ `[n]` once factored.
    pub(crate) fn inverse_diagonal(&self) -> Vec<f64> {
        pulp::Arch::new().dispatch(|| inverse_squares(&self.values, self.n, self.stride))
    }

    /// x ← L⁻ᵀ x once factored.
    pub(crate) fn solve_upper(&self, x: &mut [f64]) {
        for j in (0..self.n).rev() {
            let row = self.row(j);
            let value = x[j] / row[j];
            x[j] = value;
            for (x, l) in x[..j].iter_mut().zip(row) {
                *x -= value * l;
            }
        }
    }

    /// 2 Σ ln Lᵢᵢ.
    pub(crate) fn log_det(&self) -> f64 {
        (0..self.n).map(|i| 2.0 * self.row(i)[i].ln()).sum()
    }
}

/// Σ aᵢ bᵢ with a fixed order of summation.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    pulp::Arch::new().dispatch(|| {
        let [[sum]] = products::<1, 1>([a], [b]);
        sum
    })
}

#[inline(always)]
fn factor_all(values: &mut [f64], n: usize, stride: usize) -> bool {
    let mut panel = Vec::new();
    for j0 in (0..n).step_by(BLOCK) {
        let width = BLOCK.min(n - j0);
        panel.clear();
        for j in j0..j0 + width {
            panel.extend_from_slice(&values[j * stride..j * stride + j0]);
        }
        let below = &mut values[j0 * stride..];
        subtract(below, stride, 0, j0, &panel);
        let (diagonal, rest) = below.split_at_mut(width * stride);
        if !factor_block(diagonal, stride, j0, width) {
            return false;
        }
        solve_block(rest, diagonal, stride, j0, width);
    }
    true
}

/// Rows x Lᵀ = eᵢ, a block of them at a time; |x|² is (C⁻¹)ᵢᵢ.
#[inline(always)]
fn inverse_squares(l: &[f64], n: usize, stride: usize) -> Vec<f64> {
    let mut squares = Vec::with_capacity(n);
    let mut panel = Vec::new();
    for i0 in (0..n).step_by(BLOCK) {
        let n_rows = BLOCK.min(n - i0);
        let mut x = vec![0.0; n_rows * stride];
        for i in 0..n_rows {
            x[i * stride + i0 + i] = 1.0;
        }
        for j0 in (i0..n).step_by(BLOCK) {
            let width = BLOCK.min(n - j0);
            panel.clear();
            for j in j0..j0 + width {
                panel.extend_from_slice(&l[j * stride + i0..j * stride + j0]);
            }
            subtract(&mut x, stride, i0, j0, &panel);
            solve_block(&mut x, &l[j0 * stride..], stride, j0, width);
        }
        squares.extend(x.chunks_exact(stride).map(|row| {
            let [[sum]] = products::<1, 1>([&row[i0..n]], [&row[i0..n]]);
            sum
        }));
    }
    squares
}

/// From each row's columns j0… the products of its columns k0…j0 with the rows of `panel`.
#[inline(always)]
fn subtract(rows: &mut [f64], stride: usize, k0: usize, j0: usize, panel: &[f64]) {
    let length = j0 - k0;
    if length == 0 {
        return;
    }
    for from in (0..length).step_by(DEPTH) {
        let to = (from + DEPTH).min(length);
        let mut tiles = rows.chunks_exact_mut(TILE * stride);
        for tile in tiles.by_ref() {
            subtract_rows::<TILE>(tile, stride, k0, j0, panel, from..to);
        }
        for row in tiles.into_remainder().chunks_exact_mut(stride) {
            subtract_rows::<1>(row, stride, k0, j0, panel, from..to);
        }
    }
}

#[inline(always)]
fn subtract_rows<const R: usize>(
    rows: &mut [f64],
    stride: usize,
    k0: usize,
    j0: usize,
    panel: &[f64],
    part: std::ops::Range<usize>,
) {
    let length = j0 - k0;
    let width = panel.len() / length;
    let of_panel = |c: usize| &panel[c * length + part.start..c * length + part.end];
    for c in (0..width).step_by(TILE) {
        let left = |r: usize| &rows[r * stride + k0 + part.start..r * stride + k0 + part.end];
        if c + TILE <= width {
            let sums = products::<R, TILE>(
                std::array::from_fn(left),
                std::array::from_fn(|i| of_panel(c + i)),
            );
            for (r, sums) in sums.iter().enumerate() {
                for (i, sum) in sums.iter().enumerate() {
                    rows[r * stride + j0 + c + i] -= sum;
                }
            }
            continue;
        }
        for c in c..width {
            let left = |r: usize| &rows[r * stride + k0 + part.start..r * stride + k0 + part.end];
            let sums = products::<R, 1>(std::array::from_fn(left), [of_panel(c)]);
            for (r, [sum]) in sums.iter().enumerate() {
                rows[r * stride + j0 + c] -= sum;
            }
        }
    }
}

/// All dot products of the rows of `a` with those of `b`.
#[inline(always)]
fn products<const R: usize, const C: usize>(a: [&[f64]; R], b: [&[f64]; C]) -> [[f64; C]; R] {
    let mut sums = [[[0.0; LANES]; C]; R];
    let length = a[0].len();
    let whole = length / LANES * LANES;
    for k in (0..whole).step_by(LANES) {
        for r in 0..R {
            for c in 0..C {
                for lane in 0..LANES {
                    sums[r][c][lane] += a[r][k + lane] * b[c][k + lane];
                }
            }
        }
    }
    std::array::from_fn(|r| {
        std::array::from_fn(|c| {
            let rest: f64 = (whole..length).map(|k| a[r][k] * b[c][k]).sum();
            let s = &sums[r][c];
            ((s[0] + s[4]) + (s[1] + s[5])) + ((s[2] + s[6]) + (s[3] + s[7])) + rest
        })
    })
}

fn factor_block(rows: &mut [f64], stride: usize, j0: usize, width: usize) -> bool {
    for j in 0..width {
        let (above, row) = rows.split_at_mut(j * stride);
        let row = &mut row[j0..j0 + width];
        for c in 0..j {
            let done = &above[c * stride + j0..c * stride + j0 + width];
            let sum: f64 = (0..c).map(|k| row[k] * done[k]).sum();
            row[c] = (row[c] - sum) / done[c];
        }
        let pivot = row[j] - row[..j].iter().map(|v| v * v).sum::<f64>();
        if !(pivot > 1e-14 * row[j].abs() && pivot.is_finite()) {
            return false;
        }
        row[j] = pivot.sqrt();
        row[j + 1..].fill(0.0);
    }
    true
}

/// x Dᵀ = row for the columns of one block.
#[inline(always)]
fn solve_block(rows: &mut [f64], diagonal: &[f64], stride: usize, j0: usize, width: usize) {
    for row in rows.chunks_exact_mut(stride) {
        let row = &mut row[j0..j0 + width];
        for c in 0..width {
            let done = &diagonal[c * stride + j0..c * stride + j0 + width];
            let [[sum]] = products::<1, 1>([&row[..c]], [&done[..c]]);
            row[c] = (row[c] - sum) / done[c];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix with known entries, positive definite: exp(−|i − j| / 9) and 0.1 on the diagonal.
    fn entry(i: usize, j: usize) -> f64 {
        let gap = i.abs_diff(j) as f64;
        (-gap / 9.0).exp() + if i == j { 0.1 } else { 0.0 }
    }

    #[test]
    fn factor_times_its_transpose_is_the_matrix() {
        let (n, extra) = (203, 7);
        let mut t = Trapezoid::zeros(n, n + extra);
        for i in 0..n + extra {
            for j in 0..n.min(i + 1) {
                t.row_mut(i)[j] = entry(i, j);
            }
        }
        assert!(t.factor());
        for i in 0..n + extra {
            for j in 0..n.min(i + 1) {
                let back = dot(&t.row(i)[..=j], &t.row(j)[..=j]);
                assert!((back - entry(i, j)).abs() < 1e-13, "({i}, {j}): {back}");
            }
        }
        let diagonal = t.inverse_diagonal();
        for i in [0, 63, 64, 130, 202] {
            let mut x = vec![0.0; n];
            x[i] = 1.0;
            // C x = eᵢ by one solve down and one up
            for r in 0..n {
                let sum: f64 = (0..r).map(|k| t.row(r)[k] * x[k]).sum();
                x[r] = (x[r] - sum) / t.row(r)[r];
            }
            t.solve_upper(&mut x);
            assert!((x[i] - diagonal[i]).abs() < 1e-12, "{} {}", x[i], diagonal[i]);
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        let mut t = Trapezoid::zeros(2, 2);
        t.row_mut(0).copy_from_slice(&[1.0, 0.0]);
        t.row_mut(1).copy_from_slice(&[2.0, 1.0]);
        assert!(!t.factor());
    }
}
