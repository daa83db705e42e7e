//! An octant of a hollow sphere.

use hapdef_mesh::Tet10Mesh;
use nalgebra::Point3;

use super::Blocks;
use crate::VerifyError;

/// The octant x, y, z ≥ 0 of a hollow sphere, inner radius 1, outer 2, `n` cells through the wall:
/// concentric cubes blown up to spheres.
///
/// The cube's Kuhn cells have no tetrahedron across the planes x = y, y = z, z = x, where the map
/// has a kink.
///
/// # Errors
/// [`VerifyError::Mesh`] never for n ≥ 1.
pub fn hollow_octant(n: usize) -> Result<Tet10Mesh, VerifyError> {
    let in_wall = |cell: [usize; 3]| cell.iter().any(|&c| c >= n);
    Blocks::new(1e-6)
        .block_of([2 * n; 3], in_wall, |p| {
            let cube = p.coords * 2.0;
            Point3::from(cube * (cube.amax() / cube.norm()))
        })
        .finish()
}
