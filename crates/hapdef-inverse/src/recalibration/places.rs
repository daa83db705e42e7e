//! Places that were touched before.

use nalgebra::Point3;

/// A place is an old one where the map's error is correlated as much as this with its error there.
const LEAST_ALIKE: f64 = 0.5;

/// A place at which the map's error is followed.
#[derive(Clone, Debug)]
struct Place {
    position: Point3<f64>,
    /// Number of the last touch there.
    last_touch: usize,
}

/// The places touched so far, in the order of the state.
#[derive(Clone, Debug, Default)]
pub(super) struct Places(Vec<Place>);

impl Places {
    /// The place whose map error is most like that at `position`, and their correlation; none where all are far.
    pub(super) fn like(&self, position: &Point3<f64>, length_m: f64) -> Option<(usize, f64)> {
        let alike = |place: &Place| {
            (-(place.position - position).norm_squared() / (2.0 * length_m * length_m)).exp()
        };
        let all = self.0.iter().map(alike).enumerate();
        all.filter(|(_, alike)| *alike >= LEAST_ALIKE).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// A place was touched.
    pub(super) fn touched(&mut self, place: usize, touch: usize) {
        self.0[place].last_touch = touch;
    }

    /// Forgets the place that was touched longest ago, where there are as many as `most`; says which.
    pub(super) fn make_room(&mut self, most: usize) -> Option<usize> {
        let all = self.0.iter().enumerate();
        let oldest = all.min_by_key(|(_, place)| place.last_touch).map(|(i, _)| i);
        let oldest = oldest.filter(|_| self.0.len() >= most)?;
        self.0.remove(oldest);
        Some(oldest)
    }

    /// Adds a place; says which it is.
    pub(super) fn add(&mut self, position: Point3<f64>, touch: usize) -> usize {
        self.0.push(Place { position, last_touch: touch });
        self.0.len() - 1
    }
}
