//! Meshes of the benchmarks: mapped grids of ten-node tetrahedra whose mid-side nodes lie on the
//! true geometry.

mod blocks;
mod pick;
mod sphere;

pub use blocks::Blocks;
pub use pick::{faces_where, nodes_where};
pub use sphere::hollow_octant;
