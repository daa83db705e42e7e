//! Meshes of the benchmarks: mapped grids of ten-node tetrahedra whose mid-side nodes lie on the
//! true geometry, and of triangles.

mod blocks;
mod body;
mod grid;

pub(crate) use blocks::{Blocks, hollow_octant, moved, straight};
pub(crate) use body::{Body, BodyMesh, Place};
pub(crate) use grid::{Pattern, Triangles, grid};
