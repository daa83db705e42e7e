//! The skin that may be touched, the wall behind it, and the places of gauges on it.

mod gauge_patch;
mod neighbours;
pub(crate) mod rays;
pub(crate) mod regions;
mod sites;
mod wall;

pub use gauge_patch::{GaugePatch, gauge_patch};
pub use neighbours::PointIndex;
pub use regions::{RadialRegionParams, SkinRegion, face_positions, radial_region};
pub use sites::{clear_nodes, farthest_nodes};
pub use wall::{OuterSkinParams, Wall, outer_skin, wall};
