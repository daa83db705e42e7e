//! Places that were touched before, and what the map's error there has to do with the gains so far.

use nalgebra::{DMatrix, Point3};

/// A place is an old one where the map's error is correlated as much as this with its error there.
const LEAST_ALIKE: f64 = 0.5;

/// A place and the map's error there, which is the same whenever it is touched.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) position: Point3<f64>,
    /// Covariance of the map's error, per N² `[n_gauges, n_gauges]`.
    pub(super) error: DMatrix<f64>,
    /// Covariance of the state's error with the map's `[2 n_gauges, n_gauges]`.
    pub(super) cross: DMatrix<f64>,
    /// Number of the last touch there.
    pub(super) last_touch: usize,
}

/// The places touched so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Places(pub(super) Vec<Place>);

impl Places {
    /// The place whose map error is most like that at `position`, and their correlation; none where all are far.
    pub(super) fn like(&self, position: &Point3<f64>, length_m: f64) -> Option<(usize, f64)> {
        let alike = |place: &Place| {
            (-(place.position - position).norm_squared() / (2.0 * length_m * length_m)).exp()
        };
        let all = self.0.iter().map(alike).enumerate();
        all.filter(|(_, alike)| *alike >= LEAST_ALIKE).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Adds a place of which nothing is known but the map's `error`, in place of the oldest where there are `most`.
    pub(super) fn add(
        &mut self,
        position: Point3<f64>,
        error: DMatrix<f64>,
        touch: usize,
        most: usize,
    ) -> usize {
        let m = error.nrows();
        let cross = DMatrix::zeros(2 * m, m);
        if self.0.len() >= most {
            let all = self.0.iter().enumerate();
            let oldest = all.min_by_key(|(_, place)| place.last_touch).map_or(0, |(i, _)| i);
            self.0.remove(oldest);
        }
        self.0.push(Place { position, error, cross, last_touch: touch });
        self.0.len() - 1
    }
}
