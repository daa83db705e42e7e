//! Rows of numbers in 64 bits, and orthonormal ones.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A matrix by rows, f64.
pub(crate) struct Rows {
    pub(crate) n: usize,
    pub(crate) width: usize,
    values: Vec<f64>,
}

impl Rows {
    /// Zeros.
    pub(crate) fn new(n: usize, width: usize) -> Self {
        Self { n, width, values: vec![0.0; n * width] }
    }

    /// The values of a row-major matrix.
    pub(crate) fn of(n: usize, width: usize, values: &[f32]) -> Self {
        debug_assert_eq!(values.len(), n * width);
        Self { n, width, values: values.iter().map(|&v| f64::from(v)).collect() }
    }

    /// Orthonormal rows in directions that are always the same and as good as random.
    pub(crate) fn random_orthonormal(n: usize, width: usize) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut rows = Self::new(n, width);
        for value in &mut rows.values {
            *value = f64::from(rng.next_u32()) / f64::from(u32::MAX) - 0.5;
        }
        rows.orthonormalise();
        rows
    }

    pub(crate) fn row(&self, i: usize) -> &[f64] {
        &self.values[i * self.width..(i + 1) * self.width]
    }

    pub(crate) fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.values[i * self.width..(i + 1) * self.width]
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &[f64]> {
        self.values.chunks_exact(self.width)
    }

    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut [f64]> {
        self.values.chunks_exact_mut(self.width)
    }

    /// Takes the mean row off every row and returns it.
    pub(crate) fn centre(&mut self) -> Vec<f64> {
        let mut mean = vec![0.0; self.width];
        for row in self.iter() {
            axpy(1.0 / self.n as f64, row.iter().copied(), &mut mean);
        }
        for row in self.iter_mut() {
            axpy(-1.0, mean.iter().copied(), row);
        }
        mean
    }

    /// Gram–Schmidt, twice, which is enough; a row that depends on those before it becomes 0.
    pub(crate) fn orthonormalise(&mut self) {
        let width = self.width;
        for i in 0..self.n {
            let (before, rest) = self.values.split_at_mut(i * width);
            let row = &mut rest[..width];
            let whole = dot(row, row).sqrt();
            for _ in 0..2 {
                for other in before.chunks_exact(width) {
                    let share = dot(other, row);
                    axpy(-share, other.iter().copied(), row);
                }
            }
            let length = dot(row, row).sqrt();
            let inverse = if length > 1e-12 * whole { 1.0 / length } else { 0.0 };
            row.iter_mut().for_each(|v| *v *= inverse);
        }
    }
}

/// Sum of products in eight independent sums, which the compiler turns to vectors.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, a_rest) = a.as_chunks::<8>();
    let (b, b_rest) = b.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for l in 0..8 {
            sums[l] += a[l] * b[l];
        }
    }
    let rest = a_rest.iter().zip(b_rest).map(|(a, b)| a * b);
    sums.iter().sum::<f64>() + rest.sum::<f64>()
}

/// `y ← y + s x`.
pub(crate) fn axpy(s: f64, x: impl Iterator<Item = f64>, y: &mut [f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += s * x);
}
