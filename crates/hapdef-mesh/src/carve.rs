//! Cuts into a closed body, for printing it.

use manifold_rust::linalg::Vec3;
use manifold_rust::manifold::Manifold;
use manifold_rust::types::{Error, MeshGL64};
use nalgebra::{Point3, Vector3};

use crate::{MeshError, SurfaceMesh};

/// A box-shaped pocket in a body's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pocket {
    /// Its middle, on the surface, m.
    pub centre: Point3<f64>,
    /// Out of the body there, unit length.
    pub outward: Vector3<f64>,
    /// Along its longer side, unit length, at a right angle to `outward`.
    pub along: Vector3<f64>,
    /// Length, width, and depth below the centre, m.
    pub size_m: [f64; 3],
}

/// The part of a closed body on the side of a plane that `direction` points to.
///
/// # Errors
/// [`MeshError::Carve`]: the body is not closed, or nothing is left.
pub fn trimmed(
    body: &SurfaceMesh,
    plane: &Point3<f64>,
    direction: &Vector3<f64>,
) -> Result<SurfaceMesh, MeshError> {
    let normal = Vec3::new(direction.x, direction.y, direction.z);
    surface(&solid(body)?.trim_by_plane(normal, plane.coords.dot(direction)))
}

/// A closed body without the pockets.
///
/// # Errors
/// [`MeshError::Carve`]: the body is not closed, or nothing is left.
pub fn with_pockets(body: &SurfaceMesh, pockets: &[Pocket]) -> Result<SurfaceMesh, MeshError> {
    let mut left = solid(body)?;
    for pocket in pockets {
        left = left.difference(&solid(&pocket.tool()?)?);
    }
    surface(&left)
}

impl Pocket {
    /// What is cut away: down to the depth, and up by half the width, so that walls that rise beside the
    /// pocket go, too.
    fn tool(&self) -> Result<SurfaceMesh, MeshError> {
        let [length_m, width_m, depth_m] = self.size_m;
        let across = self.outward.cross(&self.along);
        let corner = |i: u32| {
            let side = |bit: u32| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
            let height_m = if i >> 2 == 1 { 0.5 * width_m } else { -depth_m };
            self.centre
                + self.along * (side(0) * length_m)
                + across * (side(1) * width_m)
                + self.outward * height_m
        };
        let quads: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        SurfaceMesh::new((0..8).map(corner).collect(), triangles)
    }
}

fn solid(body: &SurfaceMesh) -> Result<Manifold, MeshError> {
    let mesh = MeshGL64 {
        num_prop: 3,
        vert_properties: body.vertices().iter().flat_map(|p| [p.x, p.y, p.z]).collect(),
        tri_verts: body.triangles().iter().flatten().map(|v| u64::from(*v)).collect(),
        ..MeshGL64::default()
    };
    checked(Manifold::from_mesh_gl64(&mesh))
}

fn checked(solid: Manifold) -> Result<Manifold, MeshError> {
    match solid.status() {
        Error::NoError => Ok(solid),
        other => Err(MeshError::Carve { cause: format!("{other:?}") }),
    }
}

/// The surface of a solid, if there is any.
pub(crate) fn surface(solid: &Manifold) -> Result<SurfaceMesh, MeshError> {
    let mesh = solid.get_mesh_gl64(-1);
    let n_values = mesh.num_prop.max(3) as usize;
    let vertices = mesh.vert_properties.chunks_exact(n_values);
    let triangles = mesh.tri_verts.chunks_exact(3);
    SurfaceMesh::new(
        vertices.map(|v| Point3::new(v[0], v[1], v[2])).collect(),
        triangles.map(|t| [t[0] as u32, t[1] as u32, t[2] as u32]).collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::QualityReport;
    use crate::surface::triangles::tests::cuboid;

    #[test]
    fn a_box_loses_what_is_below_the_plane_and_in_the_pocket() {
        let body = cuboid(0.04, 0.03, 0.05);
        let upper = trimmed(&body, &Point3::new(0.0, 0.0, 0.01), &Vector3::z()).unwrap();
        assert!((upper.signed_volume_m3() - 0.04 * 0.03 * 0.04).abs() < 1e-12);
        let pocket = Pocket {
            centre: Point3::new(0.02, 0.015, 0.05),
            outward: Vector3::z(),
            along: Vector3::y(),
            size_m: [0.008, 0.005, 0.001],
        };
        let carved = with_pockets(&upper, &[pocket]).unwrap();
        let report = QualityReport::of(&carved);
        assert!(report.is_closed() && report.n_bodies == 1, "{report}");
        let lost_m3 = upper.signed_volume_m3() - carved.signed_volume_m3();
        assert!((lost_m3 - 0.008 * 0.005 * 0.001).abs() < 1e-13, "{lost_m3}");
    }

    #[test]
    fn open_bodies_and_empty_results_are_refused() {
        let body = cuboid(0.04, 0.03, 0.05);
        let open = body.with_triangles(body.triangles()[1..].to_vec());
        let error = trimmed(&open, &Point3::origin(), &Vector3::z()).unwrap_err();
        assert!(matches!(error, MeshError::Carve { .. }), "{error}");
        assert!(trimmed(&body, &Point3::new(0.0, 0.0, 0.06), &Vector3::z()).is_err());
    }
}
