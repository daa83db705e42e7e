//! Why a surface has no faithful skin.

use super::places::WrapPlaces;

/// Why a surface could not be wrapped, with the numbers and with what a picture needs.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum WrapFault {
    #[error(
        "nothing deeper than {:.2} mm is enclosed (gaps up to {:.2} mm wide count as closed; {:.1} % of \
         what the flood leaves is inside): the surface is an open sheet or frame, or thinner than {:.2} mm \
         everywhere. Close it, take a thinner wall, or give it as an open skin with a wall",
        1e3 * round_over_m, 2e3 * close_m, 100.0 * share_enclosed, 2e3 * round_over_m
    )]
    NoCore { round_over_m: f64, close_m: f64, share_enclosed: f64, places: Box<WrapPlaces> },
    #[error(
        "the skin is not faithful: {:.1} % of the outside ({:.1} cm2) is lost, {:.1} % is allowed; {:.1} % of the \
         skin ({:.1} cm2) bridges where there is no surface, {:.1} % is allowed (outside to skin: median \
         {:.2} mm, 95 % {:.2} mm; gaps up to {:.2} mm wide count as closed). What is thinner than {:.2} mm \
         goes: take a thinner wall, or close the surface first",
        100.0 * share_lost, 1e4 * places.lost_m2, 100.0 * allowed_lost, 100.0 * share_bridged,
        1e4 * places.bridged_m2, 100.0 * allowed_bridged, 1e3 * input_to_skin_m[0],
        1e3 * input_to_skin_m[1], 2e3 * close_m, 2e3 * round_over_m
    )]
    NotFaithful {
        share_lost: f64,
        allowed_lost: f64,
        share_bridged: f64,
        allowed_bridged: f64,
        input_to_skin_m: [f64; 2],
        round_over_m: f64,
        close_m: f64,
        places: Box<WrapPlaces>,
    },
    #[error(
        "no skin with edges of {:.2} to {:.2} mm takes a wall of {:.2} mm: {cause}; take a thinner wall",
        1e3 * edges_m[1], 1e3 * edges_m[0], 1e3 * wall_m
    )]
    NoWall { edges_m: [f64; 2], wall_m: f64, cause: String },
    #[error(
        "where the wall is thinned to {:.2} mm at {n_thinned} of {n_vertices} vertices it still folds or \
         crosses, at triangle {triangle}; at most {max_thinned} may be thinned",
        1e3 * least_m
    )]
    Thinned {
        n_thinned: usize,
        n_vertices: usize,
        max_thinned: usize,
        least_m: f64,
        triangle: usize,
    },
    #[error(
        "a grid of {:.2} mm has {n_points} points, more than the {max_points} allowed: give a coarser one, \
         or check the unit",
        1e3 * grid_m
    )]
    Grid { grid_m: f64, n_points: f64, max_points: usize },
    #[error("no threads for the distances: {cause}")]
    Threads { cause: String },
}

impl WrapFault {
    /// The share of the outside that is lost; 1 where there is no skin.
    #[must_use]
    pub fn share_lost(&self) -> f64 {
        if let Self::NotFaithful { share_lost, .. } = self { *share_lost } else { 1.0 }
    }

    /// The lost and bridged places, where they are known.
    #[must_use]
    pub fn places(&self) -> Option<&WrapPlaces> {
        match self {
            Self::NoCore { places, .. } | Self::NotFaithful { places, .. } => Some(places),
            _ => None,
        }
    }
}
