//! Non-negative least squares for a handful of forces.

use hapdef_contact::MAX_CONTACTS;

use crate::dense::{cholesky, solve_lower, solve_upper};

const SIZE: usize = MAX_CONTACTS * MAX_CONTACTS;

/// The x ≥ 0 that minimises ½ xᵀHx − cᵀx, H `[n, n]` positive semidefinite (Lawson and Hanson,
/// Solving Least Squares Problems, 1974, chapter 23, started with every unknown free). Unknowns
/// that H does not determine stay 0.
pub(crate) fn non_negative(h: &[f64], c: &[f64], n: usize) -> [f64; MAX_CONTACTS] {
    let mut is_free = [false; MAX_CONTACTS];
    is_free[..n].fill(true);
    let mut x = [0.0; MAX_CONTACTS];
    for _ in 0..4 * n + 4 {
        let trial = solve_free(h, c, n, &mut is_free);
        let lowest = (0..n).filter(|&i| is_free[i]).min_by(|&i, &j| trial[i].total_cmp(&trial[j]));
        match lowest {
            Some(i) if trial[i] < 0.0 => {
                is_free[i] = false;
                continue;
            }
            _ => x = trial,
        }
        let slope = |i: usize| c[i] - (0..n).map(|j| h[i * n + j] * x[j]).sum::<f64>();
        let steepest = (0..n)
            .filter(|&i| !is_free[i] && h[i * n + i] > 0.0)
            .map(|i| (i, slope(i) / h[i * n + i].sqrt()))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let scale = (0..n)
            .map(|i| c[i].abs() / h[i * n + i].max(f64::MIN_POSITIVE).sqrt())
            .fold(0.0, f64::max);
        match steepest {
            Some((i, steep)) if steep > 1e-9 * scale => is_free[i] = true,
            _ => break,
        }
    }
    x
}

/// Least squares for the free unknowns; those that make H singular are freed no more.
fn solve_free(
    h: &[f64],
    c: &[f64],
    n: usize,
    is_free: &mut [bool; MAX_CONTACTS],
) -> [f64; MAX_CONTACTS] {
    loop {
        let mut free = [0; MAX_CONTACTS];
        let mut n_free = 0;
        for i in 0..n {
            if is_free[i] {
                free[n_free] = i;
                n_free += 1;
            }
        }
        let mut l = [0.0; SIZE];
        let mut b = [0.0; MAX_CONTACTS];
        for (i, &row) in free[..n_free].iter().enumerate() {
            b[i] = c[row];
            for (j, &column) in free[..n_free].iter().enumerate() {
                l[i * n_free + j] = h[row * n + column];
            }
        }
        let mut x = [0.0; MAX_CONTACTS];
        if n_free == 0 {
            return x;
        }
        if cholesky(&mut l[..n_free * n_free], n_free, 1e-10) {
            solve_lower(&l, n_free, &mut b[..n_free]);
            solve_upper(&l, n_free, &mut b[..n_free]);
            for (i, &row) in free[..n_free].iter().enumerate() {
                x[row] = b[i];
            }
            return x;
        }
        is_free[free[n_free - 1]] = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        /// The conditions of Karush, Kuhn and Tucker.
        #[test]
        fn the_minimum_is_one(values in proptest::collection::vec(-1.0_f64..1.0, 40)) {
            let (n, rows) = (4, 8);
            let column = |i: usize| &values[i * rows..(i + 1) * rows];
            let target = &values[32..40];
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let h: Vec<f64> = (0..n * n).map(|k| product(column(k / n), column(k % n))).collect();
            let c: Vec<f64> = (0..n).map(|i| product(column(i), target)).collect();
            let x = non_negative(&h, &c, n);
            for i in 0..n {
                let slope = c[i] - (0..n).map(|j| h[i * n + j] * x[j]).sum::<f64>();
                prop_assert!(x[i] >= 0.0);
                prop_assert!(slope < 1e-6, "{slope}");
                prop_assert!(slope.abs() < 1e-6 || x[i] == 0.0, "{slope} {}", x[i]);
            }
        }
    }

    #[test]
    fn twins_share_nothing() {
        let x = non_negative(&[1.0, 1.0, 1.0, 1.0], &[2.0, 2.0], 2);
        assert!((x[0] + x[1] - 2.0).abs() < 1e-9);
    }
}
