//! Columns brought to mean 0 and standard deviation 1.

use serde::{Deserialize, Serialize};

use crate::error::DataError;

/// Mean and standard deviation of every column: `standardised = (raw − mean) / std`.
///
/// A column that was constant has the deviation 0. Nothing is known of what its changes mean: it
/// is 0 standardised, whatever it shows later, and its mean when brought back to raw units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Standardiser {
    /// Mean of every column, in the column's unit.
    pub mean: Vec<f32>,
    /// Population standard deviation of every column, in the column's unit; 0 for constant ones.
    pub std: Vec<f32>,
}

/// Collects the means and deviations of rows that arrive block by block, in f64, by the method of
/// B. P. Welford, "Note on a Method for Calculating Corrected Sums of Squares and Products",
/// Technometrics 4(3), 1962, pp. 419–420.
#[derive(Debug, Clone)]
pub struct StandardiserFit {
    n_rows: u64,
    mean: Vec<f64>,
    sum_of_squares: Vec<f64>,
}

/// What was seen while fitting.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StandardiserInfo {
    /// Rows seen.
    pub n_rows: u64,
    /// Columns whose spread is below the resolution of an f32; their deviation is set to 0.
    pub constant_columns: Vec<usize>,
}

impl StandardiserFit {
    /// Starts with no rows of `width` columns.
    pub fn new(width: usize) -> Self {
        Self { n_rows: 0, mean: vec![0.0; width], sum_of_squares: vec![0.0; width] }
    }

    /// Takes in rows, `[m, width]`, row-major, any m.
    ///
    /// Fails on a slice that is not whole rows and on a value that is not finite.
    pub fn push(&mut self, rows: &[f32]) -> Result<(), DataError> {
        let width = self.mean.len();
        check_rows(width, rows.len())?;
        if let Some(at) = rows.iter().position(|v| !v.is_finite()) {
            return Err(DataError::StandardiserInput {
                row: self.n_rows + (at / width) as u64,
                column: at % width,
                value: rows[at],
            });
        }
        for row in rows.chunks_exact(width) {
            self.n_rows += 1;
            let weight = 1.0 / self.n_rows as f64;
            for ((&x, mean), m2) in row.iter().zip(&mut self.mean).zip(&mut self.sum_of_squares) {
                let delta = f64::from(x) - *mean;
                *mean += delta * weight;
                *m2 += delta * (f64::from(x) - *mean);
            }
        }
        Ok(())
    }

    /// The standardiser of all rows seen. Fails if there were none, or no columns.
    pub fn finish(self) -> Result<(Standardiser, StandardiserInfo), DataError> {
        let width = self.mean.len();
        if self.n_rows == 0 || width == 0 {
            return Err(DataError::StandardiserEmpty { width, n_rows: self.n_rows });
        }
        let mut constant_columns = vec![];
        let mut std = Vec::with_capacity(width);
        for (column, (mean, m2)) in self.mean.iter().zip(&self.sum_of_squares).enumerate() {
            let deviation = (m2 / self.n_rows as f64).sqrt();
            let resolution = f64::from(f32::EPSILON) * mean.abs();
            let varies = deviation > resolution && (deviation as f32).is_normal();
            std.push(if varies { deviation as f32 } else { 0.0 });
            if !varies {
                constant_columns.push(column);
            }
        }
        let mean = self.mean.iter().map(|&m| m as f32).collect();
        let info = StandardiserInfo { n_rows: self.n_rows, constant_columns };
        Ok((Standardiser { mean, std }, info))
    }
}

impl Standardiser {
    /// Number of columns.
    pub fn width(&self) -> usize {
        self.mean.len()
    }

    /// Standardises rows in place: `rows` is `[m, width]` in raw units, row-major; constant
    /// columns become 0. Fails on a slice that is not whole rows.
    pub fn apply(&self, rows: &mut [f32]) -> Result<(), DataError> {
        self.each_value(rows, |x, mean, std| if std > 0.0 { (x - mean) / std } else { 0.0 })
    }

    /// Brings standardised rows back to raw units, in place; constant columns become their means.
    /// Fails on a slice that is not whole rows.
    pub fn invert(&self, rows: &mut [f32]) -> Result<(), DataError> {
        self.each_value(rows, |x, mean, std| x * std + mean)
    }

    fn each_value(
        &self,
        rows: &mut [f32],
        change: impl Fn(f32, f32, f32) -> f32,
    ) -> Result<(), DataError> {
        let width = self.width();
        check_rows(width, self.std.len())?;
        check_rows(width, rows.len())?;
        for row in rows.chunks_exact_mut(width) {
            for ((x, &mean), &std) in row.iter_mut().zip(&self.mean).zip(&self.std) {
                *x = change(*x, mean, std);
            }
        }
        Ok(())
    }
}

fn check_rows(width: usize, got: usize) -> Result<(), DataError> {
    if width > 0 && got.is_multiple_of(width) {
        return Ok(());
    }
    Err(DataError::StandardiserWidth { width, got })
}
