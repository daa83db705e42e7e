//! Solids of ten-node tetrahedra: the mesh, its boundary, shape functions, refinement, blocks and
//! tubes, and a file for ParaView.

mod bodies;
pub(crate) mod boundary;
mod fault;
mod kuhn;
mod refine;
mod refined;
pub mod tet10;
mod tetrahedra;
pub mod tri6;
mod vtu;

pub use bodies::SolidBody;
pub use boundary::{BoundarySurface, TET10_FACES, Tri6Face, connected_faces};
pub use fault::SolidFault;
pub use kuhn::{kuhn_block, kuhn_cell, kuhn_tube};
pub use refined::{RefinedSolid, is_folded, refine_unfolded};
pub use tet10::TET10_EDGES;
pub use tetrahedra::Tet10Mesh;
pub use vtu::{PointField, PointValues, write_vtu};
