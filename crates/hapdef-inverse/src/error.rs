//! The one error type of the crate.

use thiserror::Error;

/// What can be wrong with the arguments of this crate's functions.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum InverseError {
    #[error("{what}: expected {expected} values, found {found}")]
    Length { what: &'static str, expected: usize, found: usize },
    #[error("{what} is {found}: expected {expected}")]
    Parameter { what: &'static str, found: f64, expected: &'static str },
    #[error("{what}, entry {index}, is {found}: give finite numbers only")]
    NotFinite { what: &'static str, index: usize, found: f64 },
    #[error("the reading of gauge {gauge} is {found:?}: mask the gauge as dead, or drop the frame")]
    Reading { gauge: usize, found: f64 },
    #[error("face {face} names node {node}, but there are {n_nodes} nodes")]
    NodeOutOfRange { face: usize, node: usize, n_nodes: usize },
    #[error("face {face} does not exist: the skin has {n_faces} faces")]
    FaceOutOfRange { face: usize, n_faces: usize },
    #[error("face {face} has no area or folds back onto itself: repair or straighten it")]
    BadFace { face: usize },
    #[error(
        "faces {first} and {second} do not share their edge properly: at most two faces at an \
         edge, both turning the same way round, with the same mid-side node"
    )]
    BadEdge { first: usize, second: usize },
    #[error("node {node} belongs to no face or has no normal: drop it, or give its normal")]
    NoNormal { node: usize },
    #[error("the point on face {face} with coordinates {coordinates:?} is not on the skin")]
    PointOffSkin { face: usize, coordinates: [f64; 3] },
    #[error("{what} is not positive definite: check its diagonal, symmetry and units")]
    NotPositiveDefinite { what: &'static str },
    #[error("{n_live} gauges are alive, {needed} are needed for one contact")]
    TooFewGauges { n_live: usize, needed: usize },
    #[error(
        "the press at {position_m:.6?} m is {distance_m:.6} m from the skin, {max_distance_m} m are \
         allowed: check its frame and unit, or leave it out"
    )]
    PressOffSkin { position_m: [f64; 3], distance_m: f64, max_distance_m: f64 },
    #[error("press {press} has a force of {found} N: give presses with a force above 0")]
    PressForce { press: usize, found: f64 },
    #[error("press {press}, gauge {gauge}: the reading is {found}; leave the press out")]
    PressReading { press: usize, gauge: usize, found: f64 },
    #[error(
        "the presses' readings of gauge {gauge} are {ratio:.2} times what the response tells, expected \
         {least} to {most}: check its sign, its unit, and that it is this gauge's channel"
    )]
    PressScale { gauge: usize, ratio: f64, least: f64, most: f64 },
    #[error("{found} usable presses, at least {needed} are needed: record more")]
    TooFewPresses { found: usize, needed: usize },
    #[error(
        "all presses lie within {extent_m:.6} m of each other, on a skin of {skin_extent_m:.6} m: spread \
         them over the skin"
    )]
    PressesInOneSpot { extent_m: f64, skin_extent_m: f64 },
    #[error("{found} contacts asked for, at most {most} can be had")]
    TooManyContacts { found: usize, most: usize },
    #[error("no thread for searches in the background: {reason}; search in the caller's thread")]
    NoThread { reason: String },
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
