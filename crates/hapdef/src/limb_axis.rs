//! The long axis of a limb, where nobody states it.

use hapdef_mesh::{BoundarySurface, Tet10Mesh};
use nalgebra::{Matrix3, Point3, Unit, Vector3};

use crate::scene::Axis;

/// The longest principal axis of a solid's boundary, its largest component above 0, through the middle
/// of the bounding box.
pub(crate) fn principal_axis(mesh: &Tet10Mesh, boundary: &BoundarySurface) -> Axis {
    let corners = boundary.faces.iter().map(|face| [0, 1, 2].map(|i| mesh.position(face.nodes[i])));
    longest_axis(corners)
}

/// The longest principal axis of triangles as [`principal_axis`].
pub(crate) fn longest_axis(triangles: impl Iterator<Item = [Point3<f64>; 3]>) -> Axis {
    let (mut area, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
    let mut bounds = [Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])];
    for [a, b, c] in triangles {
        let of_triangle = 0.5 * (b - a).cross(&(c - a)).norm();
        let [a, b, c] = [a.coords, b.coords, c.coords];
        let centre = (a + b + c) / 3.0;
        // ∫ x xᵀ dA = A/12 (a aᵀ + b bᵀ + c cᵀ + 9 m mᵀ), m the centroid
        let corners = [a, b, c].iter().map(|x| x * x.transpose()).sum::<Matrix3<f64>>();
        second += (corners + 9.0 * centre * centre.transpose()) * (of_triangle / 12.0);
        first += centre * of_triangle;
        area += of_triangle;
        for x in [a, b, c] {
            bounds = [bounds[0].inf(&x.into()), bounds[1].sup(&x.into())];
        }
    }
    if area <= 0.0 {
        return Axis { point_m: [0.0; 3], direction: [1.0, 0.0, 0.0] };
    }
    let spread = (second - first * first.transpose() / area).symmetric_eigen();
    let axis: Vector3<f64> = spread.eigenvectors.column(spread.eigenvalues.imax()).into();
    let up = axis[axis.iamax()].signum();
    let direction = axis.map(|x| x * up);
    Axis { point_m: nalgebra::center(&bounds[0], &bounds[1]).into(), direction: direction.into() }
}

/// The least and the largest place along a direction, m.
pub(crate) fn extent_m(points: &[Point3<f64>], along: &Unit<Vector3<f64>>) -> [f64; 2] {
    let places = points.iter().map(|x| x.coords.dot(along));
    places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_box_has_its_axis_through_its_middle() {
        let mesh = Tet10Mesh::block([0.02, 0.03, 0.1], [2, 3, 5]).unwrap();
        let axis = principal_axis(&mesh, &mesh.boundary());
        let expected = [[0.01, 0.015, 0.05], [0.0, 0.0, 1.0]];
        for (found, expected) in [axis.point_m, axis.direction].iter().zip(expected) {
            let off = Vector3::from(*found) - Vector3::from(expected);
            assert!(off.norm() < 1e-9, "{axis:?}");
        }
    }
}
