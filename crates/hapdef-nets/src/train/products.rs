//! Products of matrices, and what follows on their rows.

use rayon::prelude::*;

use crate::train::gemm32;
use crate::train::view::View;

/// Rows that one thread finishes together. Blocks do not depend on the number of threads, and
/// neither does a sum over them.
pub(super) const ROW_BLOCK: usize = 64;

/// `out`, `[left.rows, right.columns]` row-major, becomes the product. Every block of
/// [`ROW_BLOCK`] rows (the last may be shorter) is handed to `finish` with its item; what that
/// returns comes back in the order of the blocks.
pub(super) fn multiply<T: Send, R: Send>(
    left: View<'_>,
    right: View<'_>,
    out: &mut [f32],
    items: impl IndexedParallelIterator<Item = T>,
    finish: impl Fn(&mut [f32], T) -> R + Sync,
) -> Vec<R> {
    gemm32::multiply(left, right, out);
    let blocks = out.par_chunks_mut(ROW_BLOCK * right.columns).zip(items);
    blocks.map(|(rows, item)| finish(rows, item)).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Whole numbers from −8 to 8.
    fn whole(n: usize, seed: u64) -> Vec<f32> {
        let value = |i: u64| ((i * i + 7 * i * seed + seed) % 7919 % 17) as f32 - 8.0;
        (0..n as u64).map(value).collect()
    }

    fn view(values: &[f32], rows: usize, columns: usize, transposed: bool) -> View<'_> {
        match transposed {
            true => View::new(values, columns, rows).t(),
            false => View::new(values, rows, columns),
        }
    }

    fn at(matrix: View<'_>, row: usize, column: usize) -> f32 {
        match matrix.transposed {
            true => matrix.values()[column * matrix.rows + row],
            false => matrix.values()[row * matrix.columns + column],
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        /// Sums of whole numbers are exact in 32 bits, whatever their order.
        #[test]
        fn products_of_whole_numbers_are_exact(
            m in 1..150usize,
            n in 1..150usize,
            k in 1..1200usize,
            left_transposed in any::<bool>(),
            right_transposed in any::<bool>(),
        ) {
            let (a, b) = (whole(m * k, 1), whole(k * n, 2));
            let left = view(&a, m, k, left_transposed);
            let right = view(&b, k, n, right_transposed);
            let mut out = vec![f32::NAN; m * n];
            let blocks = (0..m.div_ceil(ROW_BLOCK)).into_par_iter();
            let seen = multiply(left, right, &mut out, blocks, |rows, i| (i, rows.len()));
            for i in 0..m {
                for j in 0..n {
                    let sum: f32 = (0..k).map(|d| at(left, i, d) * at(right, d, j)).sum();
                    prop_assert_eq!(out[i * n + j], sum, "{} {}", i, j);
                }
            }
            let expected = (0..m.div_ceil(ROW_BLOCK)).map(|i| (i, (m - i * ROW_BLOCK).min(ROW_BLOCK) * n));
            prop_assert!(seen.into_iter().eq(expected));
        }
    }
}
