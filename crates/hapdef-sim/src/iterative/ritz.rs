//! Extreme eigenvalues of the Lanczos matrix that conjugate gradients leave behind.

/// Bisection steps: an eigenvalue to 2⁻⁴⁰ of the interval.
const STEPS: usize = 40;

/// The smallest and largest eigenvalue of the Lanczos matrix of the coefficients (αᵢ, βᵢ) of
/// conjugate gradients: they approach those of the preconditioned matrix from inside.
///
/// The matrix is tridiagonal with 1/αᵢ + βᵢ₋₁/αᵢ₋₁ and √βᵢ/αᵢ (Golub and Van Loan, Matrix
/// Computations, 4th ed., section 11.3.5); the eigenvalues come by bisection on Sturm counts
/// (section 8.4.1).
pub(super) fn extreme_ritz_values(coefficients: &[(f64, f64)]) -> Option<(f64, f64)> {
    let mut carried = 0.0;
    let rows: Vec<(f64, f64)> = coefficients
        .iter()
        .map(|&(alpha, beta)| {
            let diagonal = 1.0 / alpha + carried;
            carried = beta / alpha;
            (diagonal, beta / (alpha * alpha))
        })
        .collect();
    let largest_sum =
        rows.iter().map(|(diagonal, off_2)| diagonal + 2.0 * off_2.sqrt()).fold(0.0, f64::max);
    if rows.is_empty() || !largest_sum.is_finite() {
        return None;
    }
    let smallest = bisect(largest_sum, |x| n_below(&rows, x) >= 1);
    let largest = bisect(largest_sum, |x| n_below(&rows, x) >= rows.len());
    Some((smallest, largest))
}

/// The least x in (0, `end`) for which `reached` holds, on a logarithmic scale.
fn bisect(end: f64, reached: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = ((end * 1e-18).ln(), (end * (1.0 + 1e-12)).ln());
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if reached(middle.exp()) {
            high = middle;
        } else {
            low = middle;
        }
    }
    (0.5 * (low + high)).exp()
}

/// Eigenvalues below `x`: the negative pivots of T − x I.
fn n_below(rows: &[(f64, f64)], x: f64) -> usize {
    let (mut pivot, mut off_2, mut n) = (1.0, 0.0, 0);
    for &(diagonal, next_off_2) in rows {
        pivot = diagonal - x - off_2 / pivot;
        if pivot == 0.0 {
            pivot = f64::MIN_POSITIVE;
        }
        n += usize::from(pivot < 0.0);
        off_2 = next_off_2;
    }
    n
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Conjugate gradients on diag(1, …, 5) run to the end, so the Ritz values are the eigenvalues.
    #[test]
    fn a_full_run_gives_the_eigenvalues() {
        let d = [1.0, 2.0, 3.0, 4.0, 5.0_f64];
        let (mut r, mut p) = ([1.0; 5], [1.0; 5]);
        let mut coefficients = Vec::new();
        for _ in 0..5 {
            let rr: f64 = r.iter().map(|v| v * v).sum();
            let alpha = rr / (0..5).map(|i| d[i] * p[i] * p[i]).sum::<f64>();
            (0..5).for_each(|i| r[i] -= alpha * d[i] * p[i]);
            let beta = r.iter().map(|v| v * v).sum::<f64>() / rr;
            (0..5).for_each(|i| p[i] = r[i] + beta * p[i]);
            coefficients.push((alpha, beta));
        }
        let (smallest, largest) = extreme_ritz_values(&coefficients).expect("five steps");
        assert!((smallest - 1.0).abs() < 1e-9, "{smallest}");
        assert!((largest - 5.0).abs() < 1e-9, "{largest}");
    }
}
