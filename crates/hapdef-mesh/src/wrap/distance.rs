//! Unsigned distances to a soup of triangles.

use nalgebra::Point3;
use parry3d::math::Vector;
use parry3d::query::PointQuery;
use parry3d::shape::TriMesh;

use crate::surface::quality::is_flat;
use crate::surface::topology::repeats;
use crate::{MeshError, SurfaceMesh};

/// Inside are millimetres from the surface's middle: parry's single precision has tolerances that
/// are made for lengths about 1.
const MM_PER_M: f64 = 1e3;

/// Distances to the triangles of a surface that have an area.
pub(super) struct Distances {
    tree: TriMesh,
    middle: Point3<f64>,
}

impl Distances {
    pub(super) fn to(mesh: &SurfaceMesh) -> Result<Self, MeshError> {
        let middle = mesh.bounding_box().centre();
        let vertices = mesh.vertices().iter().map(|p| local(p, &middle)).collect();
        let has_area = |&(t, corners): &(usize, &[u32; 3])| !repeats(corners) && !is_flat(mesh, t);
        let triangles = mesh.triangles().iter().enumerate().filter(has_area);
        let tree = TriMesh::new(vertices, triangles.map(|(_, corners)| *corners).collect());
        let nothing = MeshError::NoTriangles { n_vertices: mesh.vertices().len() };
        Ok(Self { tree: tree.map_err(|_| nothing)?, middle })
    }

    /// The distance of `point`, m.
    pub(super) fn at_m(&self, point: &Point3<f64>) -> f64 {
        let query = local(point, &self.middle);
        let nearest = self.tree.project_local_point(query, false).point;
        f64::from((nearest - query).length()) / MM_PER_M
    }
}

fn local(point: &Point3<f64>, middle: &Point3<f64>) -> Vector {
    let mm = (point - middle) * MM_PER_M;
    Vector::new(mm.x as f32, mm.y as f32, mm.z as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ClosestPoint;
    use crate::surface::triangles::tests::sphere;

    #[test]
    fn as_in_double_precision() {
        let ball = sphere(3).scaled(0.05).unwrap();
        let moved = ball.vertices().iter().map(|p| p + nalgebra::Vector3::new(0.3, -2.0, 0.1));
        let ball = SurfaceMesh::new(moved.collect(), ball.triangles().to_vec()).unwrap();
        let (fast, exact) = (Distances::to(&ball).unwrap(), ClosestPoint::of_surface(&ball));
        for i in 0..200 {
            let at = |k: usize| 0.17 * ((i * k) as f64).sin();
            let p = Point3::new(0.3 + at(3), -2.0 + at(5), 0.1 + at(7));
            let wanted = exact.nearest(&p).unwrap().distance_m;
            assert!((fast.at_m(&p) - wanted).abs() < 1e-7, "{} {wanted}", fast.at_m(&p));
        }
    }
}
