//! Limb geometry: triangle surfaces and solid finite-element decks, what is wrong with them, and
//! where things are on them.
//!
//! Knows nothing of forces, materials, networks or scenes. Lengths are metres throughout; a reader
//! that meets another unit scales once, at the border.

mod ids;
mod solid;

pub use ids::{FeNodeId, GaugeId, SurfaceNodeId, VirtualGaugeId};
pub use solid::{TET10_EDGES, Tet10Mesh};
