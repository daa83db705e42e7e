//! The residual in twice the precision.
//!
//! Every product and sum keeps its rounding error (T. J. Dekker, Numer. Math. 18, 1971; D. E.
//! Knuth, The Art of Computer Programming 2, section 4.2.2), so that b − K x is right to the last
//! digit even where it cancels. It serves refinement of badly conditioned systems only.

use crate::factor::panel::Columns;
use crate::system::product::Residual;

/// A sum of two numbers that do not overlap.
#[derive(Clone, Copy, Default)]
struct Twofold {
    high: f64,
    low: f64,
}

impl Twofold {
    #[inline]
    fn add(&mut self, value: f64) {
        let sum = self.high + value;
        let rest = sum - self.high;
        self.low += (self.high - (sum - rest)) + (value - rest);
        self.high = sum;
    }

    #[inline]
    fn subtract_product(&mut self, a: f64, x: f64) {
        let product = a * x;
        self.add(-product);
        self.low -= a.mul_add(x, -product);
    }
}

impl Residual<'_> {
    /// Writes b − K x of the first `n_columns` columns to `out`.
    pub(crate) fn extended(&self, out: &mut Columns, n_columns: usize) {
        let (pattern, blocks) = (&self.matrix.pattern, &self.matrix.blocks);
        let stride = self.x.stride();
        let mut entries = self.entries;
        let mut sums = vec![Twofold::default(); 3 * n_columns];
        for node in 0..self.analysis.n_nodes() {
            sums.fill(Twofold::default());
            let here = entries.partition_point(|entry| entry.place as usize == node);
            for entry in &entries[..here] {
                for c in 0..3 {
                    sums[c * n_columns + entry.column as usize].add(entry.force[c]);
                }
            }
            entries = &entries[here..];
            for &(row, slot) in self.analysis.column(node) {
                let a = &blocks[slot as usize];
                let a = std::array::from_fn(|i| a[3 * (i % 3) + i / 3]);
                subtract(&mut sums, &a, self.x, 3 * row as usize, n_columns);
            }
            for slot in pattern.row_ptr[node]..pattern.row_ptr[node + 1] {
                let column = 3 * pattern.columns[slot] as usize;
                subtract(&mut sums, &blocks[slot], self.x, column, n_columns);
            }
            let rows = out.rows_mut(3 * node..3 * node + 3);
            for (row, sums) in rows.chunks_exact_mut(stride).zip(sums.chunks_exact(n_columns)) {
                for (value, sum) in row.iter_mut().zip(sums) {
                    *value = sum.high + sum.low;
                }
            }
        }
    }
}

/// sums −= A x, with A row-major and the three rows of x from `first` on.
fn subtract(sums: &mut [Twofold], a: &[f64; 9], x: &Columns, first: usize, n_columns: usize) {
    for c in 0..3 {
        let row = &x.row(first + c)[..n_columns];
        for r in 0..3 {
            let a = a[3 * r + c];
            for (sum, x) in sums[r * n_columns..(r + 1) * n_columns].iter_mut().zip(row) {
                sum.subtract_product(a, *x);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cancels_in_one_precision_is_kept_in_two() {
        let mut sum = Twofold::default();
        let (a, x) = (1.0 + f64::EPSILON, 1.0 - f64::EPSILON);
        sum.add(1.0);
        sum.subtract_product(a, x);
        assert_eq!(sum.high + sum.low, f64::EPSILON * f64::EPSILON);
        assert_eq!(1.0 - a * x, 0.0, "plain arithmetic loses it");
    }
}
