//! Small dense linear algebra on slices, without allocation. Matrices are row by row.

/// Lower Cholesky factor of the symmetric `a` `[n, n]` in its lower half, in place. `false`, with
/// `a` spoilt, if a pivot is not above `least` times its diagonal entry.
pub(crate) fn cholesky(a: &mut [f64], n: usize, least: f64) -> bool {
    for j in 0..n {
        let diagonal = a[j * n + j];
        let mut pivot = diagonal;
        for k in 0..j {
            pivot -= a[j * n + k] * a[j * n + k];
        }
        if !(pivot > least * diagonal && pivot > 0.0 && pivot.is_finite()) {
            return false;
        }
        let root = pivot.sqrt();
        a[j * n + j] = root;
        for i in j + 1..n {
            let mut sum = a[i * n + j];
            for k in 0..j {
                sum -= a[i * n + k] * a[j * n + k];
            }
            a[i * n + j] = sum / root;
        }
    }
    true
}

/// x ← L⁻¹ x.
pub(crate) fn solve_lower(l: &[f64], n: usize, x: &mut [f64]) {
    for i in 0..n {
        let mut sum = x[i];
        for k in 0..i {
            sum -= l[i * n + k] * x[k];
        }
        x[i] = sum / l[i * n + i];
    }
}

/// The columns of the lower `l` `[n, n]` below its diagonal, each padded to `width`, into `columns` `[n, width]`, and
/// one over its diagonal into `inverses` `[n]`, for [`solve_columns`].
pub(crate) fn set_columns(
    l: &[f64],
    n: usize,
    width: usize,
    columns: &mut [f64],
    inverses: &mut [f64],
) {
    columns.fill(0.0);
    for k in 0..n {
        inverses[k] = 1.0 / l[k * n + k];
        for i in k + 1..n {
            columns[k * width + i] = l[i * n + k];
        }
    }
}

/// x ← L⁻¹ x for `K` right-hand sides at once, `x` `[K, width]` with L by [`set_columns`]: sums go along whole
/// columns, so that none waits for the one before as in [`solve_lower`].
pub(crate) fn solve_columns<const K: usize>(columns: &[f64], inverses: &[f64], x: &mut [f64]) {
    let width = x.len() / K;
    for (k, (column, inverse)) in columns.chunks_exact(width).zip(inverses).enumerate() {
        let first = k / 4 * 4;
        for x in x.chunks_exact_mut(width) {
            x[k] *= inverse;
            let solved = x[k];
            add_scaled(&mut x[first..], -solved, &column[first..]);
        }
    }
}

/// x ← L⁻ᵀ x.
pub(crate) fn solve_upper(l: &[f64], n: usize, x: &mut [f64]) {
    for i in (0..n).rev() {
        let mut sum = x[i];
        for k in i + 1..n {
            sum -= l[k * n + i] * x[k];
        }
        x[i] = sum / l[i * n + i];
    }
}

/// 2 Σ ln Lᵢᵢ = ln det (L Lᵀ).
pub(crate) fn log_det(l: &[f64], n: usize) -> f64 {
    (0..n).map(|i| 2.0 * l[i * n + i].ln()).sum()
}

/// (L Lᵀ)⁻¹ into `out` `[n, n]`.
pub(crate) fn inverse(l: &[f64], n: usize, out: &mut [f64]) {
    for j in 0..n {
        let row = &mut out[j * n..(j + 1) * n];
        row.fill(0.0);
        row[j] = 1.0;
        solve_lower(l, n, row);
        solve_upper(l, n, row);
    }
}

/// aᵀ b; both lengths the same multiple of 4 (rows are padded with zeros).
#[inline]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    for (a, b) in a.chunks_exact(4).zip(b.chunks_exact(4)) {
        for lane in 0..4 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// y ← y + s x; both lengths the same multiple of 4.
#[inline]
pub(crate) fn add_scaled(y: &mut [f64], s: f64, x: &[f64]) {
    for (y, x) in y.chunks_exact_mut(4).zip(x.chunks_exact(4)) {
        for lane in 0..4 {
            y[lane] += s * x[lane];
        }
    }
}

/// The next multiple of 4.
pub(crate) fn padded(n: usize) -> usize {
    n.next_multiple_of(4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factor_solve_and_invert() {
        let a = [4.0, 1.0, 0.5, 1.0, 3.0, -0.4, 0.5, -0.4, 2.0];
        let mut l = a;
        assert!(cholesky(&mut l, 3, 0.0));
        let mut x = [1.0, -2.0, 3.0];
        solve_lower(&l, 3, &mut x);
        solve_upper(&l, 3, &mut x);
        for i in 0..3 {
            let back: f64 = (0..3).map(|j| a[3 * i + j] * x[j]).sum();
            assert!((back - [1.0, -2.0, 3.0][i]).abs() < 1e-14);
        }
        let mut inverted = [0.0; 9];
        inverse(&l, 3, &mut inverted);
        let det: f64 = log_det(&l, 3).exp();
        assert!((det - 20.21).abs() < 1e-12, "{det}");
        let unit: f64 = (0..3).map(|j| a[j] * inverted[3 * j]).sum();
        assert!((unit - 1.0).abs() < 1e-14);
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        assert!(!cholesky(&mut [1.0, 2.0, 2.0, 1.0], 2, 0.0));
        assert!(!cholesky(&mut [f64::NAN], 1, 0.0));
    }
}
