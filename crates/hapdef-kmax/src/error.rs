//! The one error type of the crate.

use thiserror::Error;

/// What can be wrong with the arguments of this crate's functions.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum KMaxError {
    #[error(
        "{k_neighbours} neighbours asked for, but {n_points} points leave 1..={} possible: \
         choose a smaller k or more points",
        n_points.saturating_sub(1)
    )]
    NeighbourCount { k_neighbours: usize, n_points: usize },
    #[error("point {index} is not finite: {point:?} m")]
    PointNotFinite { index: usize, point: [f64; 3] },
    #[error("the radius must be positive and finite, got {radius_m} m")]
    Radius { radius_m: f64 },
    #[error("the field has {got} values, but the graph has {expected} nodes")]
    FieldLength { expected: usize, got: usize },
    #[error("a neighbour is node {neighbour}, but there are {n_nodes} nodes, counted from 0")]
    NeighbourOutOfRange { neighbour: u32, n_nodes: usize },
    #[error("a candidate names node {node}, but there are {n_points} points")]
    NodeOutOfRange { node: usize, n_points: usize },
    #[error("the amplitude tolerance must be finite and at least 0, got {tolerance}")]
    Tolerance { tolerance: f32 },
}
