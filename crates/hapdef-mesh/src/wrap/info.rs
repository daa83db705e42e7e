//! What a wrap gives.

use super::WrapPlaces;
use crate::SurfaceMesh;

/// A skin with its wall.
#[derive(Clone, Debug, PartialEq)]
pub struct Wrapped {
    /// One closed body that faces outward, remeshed.
    pub skin: SurfaceMesh,
    /// The wall's thickness at each vertex, inward, `[n_vertices]`, m:
    /// [`extrude`](crate::extrude()) with flat faces from the outer side takes it.
    pub wall_m: Vec<f64>,
    /// What was done, and how far the skin is from the input.
    pub info: WrapInfo,
}

/// What [`wrap`](super::wrap) did. The outside is what of the input is seen by the flood.
#[derive(Clone, Debug, PartialEq)]
pub struct WrapInfo {
    /// Openings of the input that were capped with fans.
    pub n_caps: usize,
    /// Spacing of the grid, m.
    pub grid_m: f64,
    /// The closing δ that was used, m: gaps up to twice this wide are bridged.
    pub close_m: f64,
    /// The radius r that corners are rounded to, m.
    pub round_over_m: f64,
    /// The target of the skin's edges, m.
    pub edge_m: f64,
    /// Share of the input's area that lies inside and is dropped.
    pub share_inside: f64,
    /// Share of the outside that is farther than 1.1 r from the skin.
    pub share_lost: f64,
    /// Share of the skin that is farther than 1.1 r from the input before its openings were capped.
    pub share_bridged: f64,
    /// From the outside to the skin: median and 95 %, m.
    pub input_to_skin_m: [f64; 2],
    /// From the skin to the input, its openings capped: 95 %, m.
    pub skin_to_input_m: f64,
    /// The smallest angle of the skin's triangles, degrees.
    pub smallest_angle_deg: f64,
    /// Pairs of the skin's triangles that cross.
    pub n_crossings: usize,
    /// Vertices with a wall thinner than asked for.
    pub n_thinned: usize,
    /// Where the skin is not the input.
    pub places: WrapPlaces,
    /// How long it took; differs from run to run.
    pub elapsed: WrapSeconds,
}

/// Times of the steps, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WrapSeconds {
    /// Flood, closing and opening on the grid.
    pub grid_s: f64,
    /// Surfaces at a level, remeshing, and the wall of each edge length that was tried.
    pub skin_s: f64,
    /// Distances between skin and input.
    pub check_s: f64,
}
