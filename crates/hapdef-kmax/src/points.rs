//! Neighbours from positions.

use rstar::RTree;
use rstar::primitives::GeomWithData;

use crate::error::KMaxError;
use crate::graph::{Adjacency, KMaxGraph};

/// Parameters of [`KMaxGraph::new`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KMaxParams {
    /// How many nearest nodes each node is compared with (1 ≤ k < number of points).
    pub k_neighbours: usize,
}

/// Two distances closer than this share of the larger one count as equal.
const DISTANCE_TIE: f64 = 1e-9;

impl KMaxParams {
    /// The k whose neighbours span about `radius_m`: the median, over the points, of how many
    /// other points lie within `radius_m` (at least 1).
    ///
    /// The paper's k spans about 10 mm (section 3.3). Fails on fewer than two points, on a point
    /// that is not finite, and on a radius that is not positive and finite.
    pub fn spanning_radius(points: &[[f64; 3]], radius_m: f64) -> Result<Self, KMaxError> {
        if !(radius_m > 0.0 && radius_m.is_finite()) {
            return Err(KMaxError::Radius { radius_m });
        }
        check_points(points, 1)?;
        let tree = build_tree(points);
        let mut counts: Vec<usize> = points
            .iter()
            .map(|p| tree.locate_within_distance(*p, radius_m * radius_m).count().saturating_sub(1))
            .collect();
        counts.sort_unstable();
        Ok(Self { k_neighbours: counts[counts.len() / 2].max(1) })
    }
}

impl KMaxGraph {
    /// Finds the neighbours of every point (metres, any order).
    ///
    /// Fails on `k_neighbours` outside 1..n and on a point that is not finite.
    pub fn new(points: &[[f64; 3]], params: KMaxParams) -> Result<Self, KMaxError> {
        check_points(points, params.k_neighbours)?;
        let tree = build_tree(points);
        let mut outgoing = Adjacency::with_capacity(points.len(), params.k_neighbours);
        for (i, point) in points.iter().enumerate() {
            let mut reach = f64::INFINITY;
            let nearest = tree
                .nearest_neighbor_iter_with_distance_2(*point)
                .filter(|(entry, _)| entry.data as usize != i)
                .enumerate()
                .take_while(|(rank, (_, squared))| {
                    if rank + 1 == params.k_neighbours {
                        reach = squared * (1.0 + 2.0 * DISTANCE_TIE);
                    }
                    *squared <= reach
                });
            outgoing.push_row(nearest.map(|(_, (entry, _))| entry.data));
        }
        Ok(Self::of(outgoing))
    }
}

fn build_tree(points: &[[f64; 3]]) -> RTree<GeomWithData<[f64; 3], u32>> {
    let entries = points.iter().enumerate();
    RTree::bulk_load(entries.map(|(i, p)| GeomWithData::new(*p, i as u32)).collect())
}

fn check_points(points: &[[f64; 3]], k_neighbours: usize) -> Result<(), KMaxError> {
    let n_points = points.len();
    if k_neighbours == 0 || k_neighbours >= n_points || u32::try_from(n_points).is_err() {
        return Err(KMaxError::NeighbourCount { k_neighbours, n_points });
    }
    match points.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
        Some(index) => Err(KMaxError::PointNotFinite { index, point: points[index] }),
        None => Ok(()),
    }
}
