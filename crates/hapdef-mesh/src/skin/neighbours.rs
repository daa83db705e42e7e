//! Nearest-point queries.

use nalgebra::Point3;
use rstar::primitives::GeomWithData;
use rstar::{AABB, PointDistance, RTree};

/// Points indexed for nearest-neighbour queries.
///
/// A query or a point that is not finite matches nothing: never "any point".
#[derive(Debug)]
pub struct PointIndex {
    tree: RTree<GeomWithData<[f64; 3], usize>>,
}

impl PointIndex {
    /// The index of `points` `[n]`, m; answers name points by their position in this slice.
    #[must_use]
    pub fn new(points: &[Point3<f64>]) -> Self {
        let entries = points
            .iter()
            .enumerate()
            .filter(|(_, p)| is_finite(p))
            .map(|(i, p)| GeomWithData::new(p.coords.into(), i))
            .collect();
        Self { tree: RTree::bulk_load(entries) }
    }

    /// The nearest point and its distance, m; of points equally near the one with the smallest
    /// index. `None` if there are no points or `query` is not finite.
    #[must_use]
    pub fn nearest(&self, query: &Point3<f64>) -> Option<(usize, f64)> {
        let found = *self.k_nearest(query, 1).first()?;
        let distance_2 = self.by_distance(query).next()?.1;
        Some((found, distance_2.sqrt()))
    }

    /// All points within `radius_m` of `query`, ends included, ascending by index. Empty if
    /// `query` or `radius_m` is not finite or the radius is negative.
    #[must_use]
    pub fn within(&self, query: &Point3<f64>, radius_m: f64) -> Vec<usize> {
        if !is_finite(query) || !radius_m.is_finite() || radius_m < 0.0 {
            return Vec::new();
        }
        let centre: [f64; 3] = query.coords.into();
        let envelope =
            AABB::from_corners(centre.map(|c| c - radius_m), centre.map(|c| c + radius_m));
        let mut found: Vec<usize> = self
            .tree
            .locate_in_envelope_intersecting(envelope)
            .filter(|entry| entry.distance_2(&centre) <= radius_m * radius_m)
            .map(|entry| entry.data)
            .collect();
        found.sort_unstable();
        found
    }

    /// The `k` nearest points by ascending distance, ties by index; fewer if there are fewer,
    /// none if `query` is not finite.
    #[must_use]
    pub fn k_nearest(&self, query: &Point3<f64>, k: usize) -> Vec<usize> {
        let mut found: Vec<(f64, usize)> = Vec::with_capacity(k);
        for (index, distance_2) in self.by_distance(query) {
            let full = found.len() >= k;
            if full && found.last().is_none_or(|last| distance_2 > last.0) {
                break;
            }
            found.push((distance_2, index));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.truncate(k);
        found.into_iter().map(|(_, index)| index).collect()
    }

    /// `(index, squared distance)` by ascending distance; nothing if `query` is not finite.
    fn by_distance(&self, query: &Point3<f64>) -> impl Iterator<Item = (usize, f64)> + '_ {
        let centre: Option<[f64; 3]> = is_finite(query).then(|| query.coords.into());
        centre.into_iter().flat_map(|centre| {
            self.tree
                .nearest_neighbor_iter_with_distance_2(centre)
                .map(|(entry, distance_2)| (entry.data, distance_2))
        })
    }
}

fn is_finite(point: &Point3<f64>) -> bool {
    point.iter().all(|c| c.is_finite())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Points on a small grid, so that equal distances are common.
    fn points() -> impl Strategy<Value = Vec<Point3<f64>>> {
        let coordinate = || (0..5_i32).prop_map(f64::from);
        let point = (coordinate(), coordinate(), coordinate());
        proptest::collection::vec(point.prop_map(|(x, y, z)| Point3::new(x, y, z)), 1..60)
    }

    fn by_brute_force(points: &[Point3<f64>], query: &Point3<f64>) -> Vec<(f64, usize)> {
        let mut all: Vec<_> =
            points.iter().enumerate().map(|(i, p)| ((p - query).norm_squared(), i)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        all
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn queries_agree_with_brute_force(points in points(), k in 0..70_usize, twice in 0..9_i32) {
            let query = Point3::new(f64::from(twice) * 0.5, 2.0, 1.5);
            let index = PointIndex::new(&points);
            let expected = by_brute_force(&points, &query);
            let (distance_2, first) = expected[0];
            prop_assert_eq!(index.nearest(&query), Some((first, distance_2.sqrt())));
            let nearest: Vec<_> = expected.iter().take(k).map(|(_, i)| *i).collect();
            prop_assert_eq!(index.k_nearest(&query, k), nearest);
            let radius_m = f64::from(twice) * 0.4;
            let mut within: Vec<_> =
                expected.iter().filter(|(d, _)| *d <= radius_m * radius_m).map(|(_, i)| *i).collect();
            within.sort_unstable();
            prop_assert_eq!(index.within(&query, radius_m), within);
        }
    }

    #[test]
    fn what_is_not_finite_matches_nothing() {
        let nowhere = Point3::new(0.0, f64::NAN, 0.0);
        let index = PointIndex::new(&[Point3::origin(), nowhere]);
        assert_eq!(index.nearest(&nowhere), None);
        assert!(index.k_nearest(&nowhere, 3).is_empty());
        assert!(index.within(&nowhere, 1.0).is_empty());
        assert!(index.within(&Point3::origin(), f64::NAN).is_empty());
        assert!(index.within(&Point3::origin(), -1.0).is_empty());
        assert_eq!(index.k_nearest(&Point3::origin(), 3), [0]);
        assert_eq!(PointIndex::new(&[]).nearest(&Point3::origin()), None);
    }
}
