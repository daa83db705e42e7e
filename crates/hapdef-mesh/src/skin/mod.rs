//! The skin that may be touched, the wall behind it, the places of gauges on it, and a solid with all that.

mod gauge_patch;
mod held_solid;
mod neighbours;
pub(crate) mod rays;
pub(crate) mod regions;
mod sites;
mod wall;

pub use gauge_patch::{GaugePatch, gauge_patch};
pub use held_solid::HeldSolid;
pub use neighbours::PointIndex;
pub use regions::{RadialRegionParams, SkinRegion, face_positions, radial_region};
pub use sites::{clear_nodes, farthest_nodes};
pub use wall::{OuterSkinParams, Wall, outer_skin, wall};
