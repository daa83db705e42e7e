//! The one error type of the crate.

use thiserror::Error;

/// What can be wrong with the arguments of this crate's functions.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum KMaxError {
    /// Too few nodes for the number of neighbours asked for.
    #[error(
        "{k_neighbours} neighbours asked for, but {n_points} points leave 1..={} possible: \
         choose a smaller k or more points",
        n_points.saturating_sub(1)
    )]
    NeighbourCount {
        /// Neighbours asked for.
        k_neighbours: usize,
        /// Points given.
        n_points: usize,
    },
    /// A point has a coordinate that is NaN or infinite.
    #[error("point {index} is not finite: {point:?} m")]
    PointNotFinite {
        /// Index of the point.
        index: usize,
        /// Its coordinates in metres.
        point: [f64; 3],
    },
    /// A radius that is not a positive finite number.
    #[error("the radius must be positive and finite, got {radius_m} m")]
    Radius {
        /// Radius given.
        radius_m: f64,
    },
    /// A field whose length is not the number of nodes.
    #[error("the field has {got} values, but the graph has {expected} nodes")]
    FieldLength {
        /// Nodes of the graph.
        expected: usize,
        /// Values of the field.
        got: usize,
    },
    /// A neighbour that is no node.
    #[error("a neighbour is node {neighbour}, but there are {n_nodes} nodes, counted from 0")]
    NeighbourOutOfRange {
        /// The neighbour.
        neighbour: u32,
        /// Nodes of the graph.
        n_nodes: usize,
    },
    /// A candidate names a node that does not exist.
    #[error("a candidate names node {node}, but there are {n_points} points")]
    NodeOutOfRange {
        /// Node of the candidate.
        node: usize,
        /// Points given.
        n_points: usize,
    },
    /// An amplitude tolerance that is negative, NaN or infinite.
    #[error("the amplitude tolerance must be finite and at least 0, got {tolerance}")]
    Tolerance {
        /// Tolerance given (a share, 0.10 for 10 %).
        tolerance: f32,
    },
}
