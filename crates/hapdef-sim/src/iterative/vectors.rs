//! Sums over vectors of K right-hand sides, in an order that no thread count changes.

use rayon::prelude::*;

/// Entries that one task sums.
const CHUNK: usize = 4096;

/// Σ aᵢ bᵢ for each of the K columns.
pub(super) fn dot<const K: usize>(a: &[[f64; K]], b: &[[f64; K]]) -> [f64; K] {
    let parts: Vec<[f64; K]> = a
        .par_chunks(CHUNK)
        .zip(b.par_chunks(CHUNK))
        .map(|(a, b)| {
            let mut sum = [0.0; K];
            for (a, b) in a.iter().zip(b) {
                for l in 0..K {
                    sum[l] += a[l] * b[l];
                }
            }
            sum
        })
        .collect();
    let mut sum = [0.0; K];
    for part in parts {
        for l in 0..K {
            sum[l] += part[l];
        }
    }
    sum
}

/// The largest |scaleᵢ aᵢ| (or |aᵢ / scaleᵢ|, if `divide`) of each column; NaN if there is one.
pub(super) fn scaled_max<const K: usize>(a: &[[f64; K]], scale: &[f64], divide: bool) -> [f64; K] {
    let parts: Vec<[f64; K]> = a
        .par_chunks(CHUNK)
        .zip(scale.par_chunks(CHUNK))
        .map(|(a, scale)| {
            let mut largest = [0.0; K];
            for (a, &s) in a.iter().zip(scale) {
                let s = if divide { 1.0 / s } else { s };
                for l in 0..K {
                    larger(&mut largest[l], (s * a[l]).abs());
                }
            }
            largest
        })
        .collect();
    let mut largest = [0.0; K];
    for part in parts {
        for l in 0..K {
            larger(&mut largest[l], part[l]);
        }
    }
    largest
}

/// y ← y + aₗ x per column.
pub(super) fn add_scaled<const K: usize>(factor: &[f64; K], x: &[[f64; K]], y: &mut [[f64; K]]) {
    y.par_chunks_mut(CHUNK).zip(x.par_chunks(CHUNK)).for_each(|(y, x)| {
        for (y, x) in y.iter_mut().zip(x) {
            for l in 0..K {
                y[l] += factor[l] * x[l];
            }
        }
    });
}

/// y ← x + aₗ y per column.
pub(super) fn scale_and_add<const K: usize>(factor: &[f64; K], x: &[[f64; K]], y: &mut [[f64; K]]) {
    y.par_chunks_mut(CHUNK).zip(x.par_chunks(CHUNK)).for_each(|(y, x)| {
        for (y, x) in y.iter_mut().zip(x) {
            for l in 0..K {
                y[l] = x[l] + factor[l] * y[l];
            }
        }
    });
}

/// As max(), but a NaN survives.
fn larger(largest: &mut f64, value: f64) {
    if !largest.is_nan() && (value.is_nan() || value > *largest) {
        *largest = value;
    }
}
