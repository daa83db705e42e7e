//! Triangle surfaces.

use nalgebra::{Matrix3, Matrix4, Point3, Vector3};

use crate::MeshError;

/// A triangle surface: vertices in metres, and triangles whose corners run counter-clockwise seen
/// from outside.
///
/// Every corner names a vertex, every coordinate is finite and there is at least one triangle.
/// Nothing else is promised: a surface may be open, doubled or degenerate, which
/// [`QualityReport`](crate::QualityReport) tells.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceMesh {
    vertices: Vec<Point3<f64>>,
    triangles: Vec<[u32; 3]>,
}

/// The smallest axis-aligned box around a surface, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingBox {
    /// The corner with the smallest coordinates.
    pub min: Point3<f64>,
    /// The corner with the largest coordinates.
    pub max: Point3<f64>,
}

impl BoundingBox {
    /// Edge lengths along x, y, z, m.
    #[must_use]
    pub fn size_m(&self) -> Vector3<f64> {
        self.max - self.min
    }

    /// The middle of the box.
    #[must_use]
    pub fn centre(&self) -> Point3<f64> {
        nalgebra::center(&self.min, &self.max)
    }

    /// The longest edge, m.
    #[must_use]
    pub fn longest_m(&self) -> f64 {
        self.size_m().max()
    }
}

impl SurfaceMesh {
    /// A surface from `vertices` (m) and `triangles` (corner indices into `vertices`).
    ///
    /// # Errors
    /// A corner that names no vertex, a coordinate that is not finite, no triangle, or more
    /// vertices than 32 bits can count.
    pub fn new(vertices: Vec<Point3<f64>>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        let n_vertices = vertices.len();
        if triangles.is_empty() {
            return Err(MeshError::NoTriangles { n_vertices });
        }
        if u32::try_from(n_vertices).is_err() {
            return Err(MeshError::TooManyVertices { n_vertices });
        }
        check_finite(&vertices)?;
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= n_vertices) {
                return Err(MeshError::VertexOutOfRange { triangle, vertex, n_vertices });
            }
        }
        Ok(Self { vertices, triangles })
    }

    /// The surface with its triangles' corners in another order.
    pub(crate) fn with_triangles(&self, triangles: Vec<[u32; 3]>) -> Self {
        Self { vertices: self.vertices.clone(), triangles }
    }

    /// Vertex positions `[n_vertices]`, m.
    #[must_use]
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.vertices
    }

    /// Corner indices `[n_triangles]`.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The corners of triangle `triangle`, m.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[must_use]
    pub fn corners(&self, triangle: usize) -> [Point3<f64>; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize])
    }

    /// The normal of triangle `triangle` with the triangle's area as length, m²; outward, and zero
    /// for a degenerate triangle.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[must_use]
    pub fn area_normal_m2(&self, triangle: usize) -> Vector3<f64> {
        let [a, b, c] = self.corners(triangle);
        0.5 * (b - a).cross(&(c - a))
    }

    /// Outward unit normals `[n_vertices]`: the normals of the adjoining triangles, weighted by
    /// the angle each has at the vertex (Thürmer and Wüthrich, Computing Vertex Normals from
    /// Polygonal Facets, J. Graphics Tools 3(1), 1998). The zero vector where there is no normal:
    /// at a vertex that no triangle of positive area uses, or where the normals cancel.
    #[must_use]
    pub fn vertex_normals(&self) -> Vec<Vector3<f64>> {
        let mut sums = vec![Vector3::zeros(); self.vertices.len()];
        for (triangle, corners) in self.triangles.iter().enumerate() {
            let Some(normal) = self.area_normal_m2(triangle).try_normalize(0.0) else {
                continue;
            };
            let angles = corner_angles_rad(&self.corners(triangle));
            for (&vertex, angle) in corners.iter().zip(angles) {
                sums[vertex as usize] += angle * normal;
            }
        }
        sums.iter().map(|sum| sum.try_normalize(1e-12).unwrap_or_else(Vector3::zeros)).collect()
    }

    /// The sum of all triangle areas, m².
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        (0..self.triangles.len()).map(|t| self.area_normal_m2(t).norm()).sum()
    }

    /// The enclosed volume by the divergence theorem, V = ⅓ ∮ x·n dA, m³: positive when the
    /// triangles face outward. Means something only for a closed surface; the origin of x is the
    /// centre of the bounding box, which keeps the rounding small.
    #[must_use]
    pub fn signed_volume_m3(&self) -> f64 {
        let origin = self.bounding_box().centre();
        let flux = |t: usize| (self.corners(t)[0] - origin).dot(&self.area_normal_m2(t));
        (0..self.triangles.len()).map(flux).sum::<f64>() / 3.0
    }

    /// The box around all vertices, used by a triangle or not.
    #[must_use]
    pub fn bounding_box(&self) -> BoundingBox {
        let first = self.vertices[0];
        self.vertices.iter().fold(BoundingBox { min: first, max: first }, |b, v| BoundingBox {
            min: b.min.inf(v),
            max: b.max.sup(v),
        })
    }

    /// The surface under an affine map (last row 0 0 0 1); triangles are turned over where the map
    /// mirrors, so that they keep facing outward.
    ///
    /// # Errors
    /// A coordinate that is no longer finite.
    pub fn transformed(&self, world_from_local: &Matrix4<f64>) -> Result<Self, MeshError> {
        let vertices = self.vertices.iter().map(|v| affine(world_from_local, v)).collect();
        let mut triangles = self.triangles.clone();
        if linear_part(world_from_local).determinant() < 0.0 {
            triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        Self::new(vertices, triangles)
    }

    /// The surface with every coordinate multiplied by `factor`: how a surface read as metres is
    /// brought to metres once its unit is known.
    ///
    /// # Errors
    /// A coordinate that is no longer finite.
    pub fn scaled(&self, factor: f64) -> Result<Self, MeshError> {
        self.transformed(&Matrix4::new_scaling(factor))
    }
}

/// The angles of a triangle at its three corners, rad; zero at a corner with a zero-length edge.
pub(crate) fn corner_angles_rad(corners: &[Point3<f64>; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let u = corners[(i + 1) % 3] - corners[i];
        let v = corners[(i + 2) % 3] - corners[i];
        u.cross(&v).norm().atan2(u.dot(&v))
    })
}

/// The upper left 3 × 3 block of an affine map.
pub(crate) fn linear_part(map: &Matrix4<f64>) -> Matrix3<f64> {
    map.fixed_view::<3, 3>(0, 0).into_owned()
}

/// A point under an affine map.
pub(crate) fn affine(map: &Matrix4<f64>, point: &Point3<f64>) -> Point3<f64> {
    Point3::from(linear_part(map) * point.coords + map.fixed_view::<3, 1>(0, 3))
}

fn check_finite(vertices: &[Point3<f64>]) -> Result<(), MeshError> {
    match vertices.iter().position(|v| !v.coords.iter().all(|x| x.is_finite())) {
        None => Ok(()),
        Some(vertex) => {
            let position = vertices[vertex].coords.into();
            Err(MeshError::VertexNotFinite { vertex, position })
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use approx::assert_relative_eq;
    use nalgebra::{Rotation3, Unit};
    use proptest::prelude::*;

    use super::*;

    /// A closed box with edges a, b, c and one corner at the origin, facing outward.
    pub(crate) fn cuboid(a: f64, b: f64, c: f64) -> SurfaceMesh {
        let corner = |i: u32| {
            let pick = |bit: u32, length: f64| if i >> bit & 1 == 1 { length } else { 0.0 };
            Point3::new(pick(0, a), pick(1, b), pick(2, c))
        };
        let quads: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        SurfaceMesh::new((0..8).map(corner).collect(), triangles).unwrap()
    }

    /// A sphere of radius 1 around the origin: an octahedron subdivided `n` times.
    pub(crate) fn sphere(n: usize) -> SurfaceMesh {
        let mut corners: Vec<[Vector3<f64>; 3]> = Vec::new();
        for (x, y, z) in (0..8).map(|i| (i & 1, i >> 1 & 1, i >> 2)) {
            let sign = |bit: i32| f64::from(1 - 2 * bit);
            let (a, b, c) =
                (Vector3::x() * sign(x), Vector3::y() * sign(y), Vector3::z() * sign(z));
            corners.push(if (x + y + z) % 2 == 0 { [a, b, c] } else { [a, c, b] });
        }
        for _ in 0..n {
            let middle = |a: Vector3<f64>, b: Vector3<f64>| (a + b).try_normalize(0.0).unwrap();
            corners = corners
                .into_iter()
                .flat_map(|[a, b, c]| {
                    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                })
                .collect();
        }
        let vertices: Vec<_> = corners.iter().flatten().map(|v| Point3::from(*v)).collect();
        let triangles = (0..corners.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        SurfaceMesh::new(vertices, triangles).unwrap().weld(1e-9).unwrap().0
    }

    fn rigid(axis: Vector3<f64>, angle: f64, shift: Vector3<f64>) -> Matrix4<f64> {
        let axis = Unit::try_new(axis, 1e-3).unwrap_or(Vector3::z_axis());
        Matrix4::new_translation(&shift) * Rotation3::from_axis_angle(&axis, angle).to_homogeneous()
    }

    fn vector(range: std::ops::Range<f64>) -> impl Strategy<Value = Vector3<f64>> {
        [range.clone(), range.clone(), range].prop_map(Vector3::from)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn volume_and_area_survive_rigid_motion(
            size in vector(0.01..0.5),
            axis in vector(-1.0..1.0),
            angle in -4.0..4.0,
            shift in vector(-10.0..10.0),
        ) {
            let mesh = cuboid(size.x, size.y, size.z);
            let moved = mesh.transformed(&rigid(axis, angle, shift)).unwrap();
            let volume = size.x * size.y * size.z;
            let area = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
            prop_assert!((moved.signed_volume_m3() - volume).abs() < 1e-10 * area);
            prop_assert!((moved.area_m2() - area).abs() < 1e-10 * area.max(1.0));
        }

        #[test]
        fn mirroring_keeps_the_outside_out(scale in vector(0.1..3.0), mirrored in 0..8_u8) {
            let sign = |bit: u8| if mirrored >> bit & 1 == 1 { -1.0 } else { 1.0 };
            let map = Matrix4::new_nonuniform_scaling(&Vector3::new(
                scale.x * sign(0), scale.y * sign(1), scale.z * sign(2),
            ));
            let mesh = cuboid(0.1, 0.2, 0.3).transformed(&map).unwrap();
            let volume = 0.006 * scale.x * scale.y * scale.z;
            prop_assert!((mesh.signed_volume_m3() - volume).abs() < 1e-12);
        }
    }

    /// The volume error of an inscribed triangulation falls with the square of the edge length.
    #[test]
    fn sphere_volume_converges_with_order_two() {
        let error = |n| 4.0 / 3.0 * std::f64::consts::PI - sphere(n).signed_volume_m3();
        let order = (error(3) / error(4)).log2();
        assert!((order - 2.0).abs() < 0.05, "observed order {order}");
    }

    #[test]
    fn normals_of_a_sphere_are_radial() {
        let mesh = sphere(4);
        for (vertex, normal) in mesh.vertices().iter().zip(mesh.vertex_normals()) {
            assert!(normal.dot(&vertex.coords) > 0.9995, "{vertex} {normal}");
        }
    }

    /// Angle weights make the normal at a box corner the diagonal however the faces are cut.
    #[test]
    fn normals_of_a_box_are_diagonal() {
        let mesh = cuboid(1.0, 1.0, 1.0);
        let centre = Point3::new(0.5, 0.5, 0.5);
        for (vertex, normal) in mesh.vertices().iter().zip(mesh.vertex_normals()) {
            let diagonal = (vertex - centre).try_normalize(0.0).unwrap();
            assert_relative_eq!(normal, diagonal, epsilon = 1e-12);
        }
    }

    #[test]
    fn a_vertex_without_triangles_has_no_normal() {
        let vertices =
            vec![Point3::origin(), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
        let vertices = [vertices, vec![Point3::new(9.0, 9.0, 9.0)]].concat();
        let mesh = SurfaceMesh::new(vertices, vec![[0, 1, 2]]).unwrap();
        assert_eq!(mesh.vertex_normals()[0], Vector3::z());
        assert_eq!(mesh.vertex_normals()[3], Vector3::zeros());
    }

    #[test]
    fn bad_surfaces_are_refused() {
        let one = vec![Point3::origin(); 3];
        let refused = |vertices: Vec<_>, triangles| {
            SurfaceMesh::new(vertices, triangles).unwrap_err().to_string()
        };
        assert_eq!(
            refused(one.clone(), vec![[0, 1, 2], [0, 1, 3]]),
            "triangle 1 uses vertex 3, but the surface has 3 vertices (0-based)"
        );
        let nan = vec![Point3::origin(), Point3::new(0.0, f64::NAN, 0.0), Point3::origin()];
        assert!(refused(nan, vec![[0, 1, 2]]).contains("vertex 1"));
        assert!(refused(one, vec![]).contains("no triangle"));
    }

    #[test]
    fn scaling_to_metres() {
        let mesh = cuboid(100.0, 200.0, 300.0).scaled(1e-3).unwrap();
        assert_relative_eq!(mesh.signed_volume_m3(), 0.006, epsilon = 1e-15);
        assert!(cuboid(1.0, 1.0, 1.0).scaled(f64::INFINITY).is_err());
    }
}
