//! The one error type of the crate.

use thiserror::Error;

/// What can be wrong with the arguments of this crate's functions.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum InverseError {
    /// A list of the wrong length.
    #[error("{what}: expected {expected} values, found {found}")]
    Length {
        /// Which list.
        what: &'static str,
        /// Values expected.
        expected: usize,
        /// Values found.
        found: usize,
    },
    /// A parameter outside its range.
    #[error("{what} is {found}: expected {expected}")]
    Parameter {
        /// Which parameter.
        what: &'static str,
        /// Its value.
        found: f64,
        /// The range it has to be in.
        expected: &'static str,
    },
    /// A number that is NaN or infinite.
    #[error("{what}, entry {index}, is {found}: give finite numbers only")]
    NotFinite {
        /// Which list.
        what: &'static str,
        /// Place in the list.
        index: usize,
        /// Its value.
        found: f64,
    },
    /// A reading that is NaN or infinite.
    #[error("the reading of gauge {gauge} is {found:?}: mask the gauge as dead, or drop the frame")]
    Reading {
        /// Index of the gauge.
        gauge: usize,
        /// Its value.
        found: f64,
    },
    /// A face names a node that does not exist.
    #[error("face {face} names node {node}, but there are {n_nodes} nodes")]
    NodeOutOfRange {
        /// Index of the face.
        face: usize,
        /// The node it names.
        node: usize,
        /// Nodes there are.
        n_nodes: usize,
    },
    /// A face that does not exist.
    #[error("face {face} does not exist: the skin has {n_faces} faces")]
    FaceOutOfRange {
        /// Index of the face.
        face: usize,
        /// Faces there are.
        n_faces: usize,
    },
    /// A face without area, or a curved one that folds back onto itself.
    #[error("face {face} has no area or folds back onto itself: repair or straighten it")]
    BadFace {
        /// Index of the face.
        face: usize,
    },
    /// An edge of more than two faces, or of two that turn the same way round.
    #[error(
        "faces {first} and {second} do not share their edge properly: at most two faces at an \
         edge, both turning the same way round, with the same mid-side node"
    )]
    BadEdge {
        /// One face.
        first: usize,
        /// The other.
        second: usize,
    },
    /// A node that no face has, or whose normal vanishes.
    #[error("node {node} belongs to no face or has no normal: drop it, or give its normal")]
    NoNormal {
        /// Index of the node.
        node: usize,
    },
    /// A point that is not on the skin.
    #[error("the point on face {face} with coordinates {coordinates:?} is not on the skin")]
    PointOffSkin {
        /// The face it names.
        face: usize,
        /// Its barycentric coordinates.
        coordinates: [f64; 3],
    },
    /// A covariance that is not positive definite.
    #[error("{what} is not positive definite: check its diagonal, symmetry and units")]
    NotPositiveDefinite {
        /// Which covariance.
        what: &'static str,
    },
    /// Too few gauges left to find a contact.
    #[error("{n_live} gauges are alive, {needed} are needed for one contact")]
    TooFewGauges {
        /// Gauges that are alive.
        n_live: usize,
        /// Gauges needed.
        needed: usize,
    },
    /// A press that is not on the skin.
    #[error(
        "the press at {position_m:.6?} m is {distance_m:.6} m from the skin, {max_distance_m} m are \
         allowed: check its frame and unit, or leave it out"
    )]
    PressOffSkin {
        /// Where it was said to be, m.
        position_m: [f64; 3],
        /// How far that is from the skin, m.
        distance_m: f64,
        /// The distance allowed, m.
        max_distance_m: f64,
    },
    /// A press whose force is not finite and above 0.
    #[error("press {press} has a force of {found} N: give presses with a force above 0")]
    PressForce {
        /// Index of the press.
        press: usize,
        /// Its force, N.
        found: f64,
    },
    /// A press with a reading that is NaN or infinite.
    #[error("press {press}, gauge {gauge}: the reading is {found}; leave the press out")]
    PressReading {
        /// Index of the press.
        press: usize,
        /// Index of the gauge.
        gauge: usize,
        /// Its value.
        found: f64,
    },
    /// Readings of presses that are of another size or sign than the response.
    #[error(
        "the presses' readings of gauge {gauge} are {ratio:.2} times what the response tells, expected \
         {least} to {most}: check its sign, its unit, and that it is this gauge's channel"
    )]
    PressScale {
        /// Index of the gauge.
        gauge: usize,
        /// Readings over what the response tells, the median over the presses.
        ratio: f64,
        /// The least that is taken for this gauge's.
        least: f64,
        /// The most.
        most: f64,
    },
    /// Too few presses, or too few good ones.
    #[error("{found} usable presses, at least {needed} are needed: record more")]
    TooFewPresses {
        /// Presses that can be used.
        found: usize,
        /// Presses needed.
        needed: usize,
    },
    /// All presses in one place.
    #[error(
        "all presses lie within {extent_m:.6} m of each other, on a skin of {skin_extent_m:.6} m: spread \
         them over the skin"
    )]
    PressesInOneSpot {
        /// The largest distance between two presses, m.
        extent_m: f64,
        /// The diagonal of the skin's box, m.
        skin_extent_m: f64,
    },
    /// More contacts than the arrays of this crate hold.
    #[error("{found} contacts asked for, at most {most} can be had")]
    TooManyContacts {
        /// Contacts asked for.
        found: usize,
        /// Contacts at most.
        most: usize,
    },
    /// The thread for searches in the background.
    #[error("no thread for searches in the background: {reason}; search in the caller's thread")]
    NoThread {
        /// What the system said.
        reason: String,
    },
}

/// The first number that is not finite, as an error.
pub(crate) fn check_finite(what: &'static str, values: &[f64]) -> Result<(), InverseError> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(InverseError::NotFinite { what, index, found: values[index] }),
        None => Ok(()),
    }
}

/// Refuses a list of the wrong length.
pub(crate) fn check_length(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), InverseError> {
    if expected == found {
        return Ok(());
    }
    Err(InverseError::Length { what, expected, found })
}

/// Refuses a parameter that is not finite and above 0.
pub(crate) fn check_positive(what: &'static str, found: f64) -> Result<(), InverseError> {
    if found.is_finite() && found > 0.0 {
        return Ok(());
    }
    Err(InverseError::Parameter { what, found, expected: "finite and above 0" })
}

/// Refuses a parameter that is not finite or below 0.
pub(crate) fn check_not_negative(what: &'static str, found: f64) -> Result<(), InverseError> {
    if found.is_finite() && found >= 0.0 {
        return Ok(());
    }
    Err(InverseError::Parameter { what, found, expected: "finite and not below 0" })
}
