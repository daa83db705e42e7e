//! The surface at a level of a field on a grid.

use manifold_rust::linalg::Vec3;
use manifold_rust::manifold::Manifold;
use manifold_rust::types::Box as Bounds;
use nalgebra::Point3;

use super::grid::Grid;
use crate::{MeshError, SurfaceMesh, carve};

/// The closed surface where the field is 0, with edges of about `edge_m`, facing where it is
/// positive.
pub(super) fn zero_surface(
    grid: &Grid,
    values: &[f32],
    edge_m: f64,
) -> Result<SurfaceMesh, MeshError> {
    let corner = |p: Point3<f64>| Vec3::new(p.x, p.y, p.z);
    let bounds =
        Bounds { min: corner(grid.origin), max: corner(grid.point(grid.n.map(|n| n - 1))) };
    let inside = |p: Vec3| -grid.between(values, &Point3::new(p.x, p.y, p.z));
    carve::surface(&Manifold::level_set(inside, bounds, edge_m))
}
