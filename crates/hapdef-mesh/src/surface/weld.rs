//! Joining vertices that lie at the same place.

use std::collections::HashMap;

use nalgebra::Point3;

use super::topology::repeats;
use crate::{MeshError, SurfaceMesh};

/// What [`SurfaceMesh::weld`] did.
#[derive(Clone, Debug, PartialEq)]
pub struct WeldInfo {
    /// Vertices that gave way to an earlier one.
    pub n_merged_vertices: usize,
    /// Triangles dropped because two of their corners became one.
    pub n_collapsed_triangles: usize,
    /// Triangles dropped because they named a vertex twice to begin with.
    pub n_repeated_corner_triangles: usize,
    /// For each old vertex its new one, `[n_vertices before]`.
    pub new_vertex: Vec<u32>,
    /// For each new triangle its old one, `[n_triangles after]`, increasing.
    pub old_triangle: Vec<usize>,
}

impl SurfaceMesh {
    /// The surface with vertices no farther apart than `tolerance_m` joined.
    ///
    /// Vertices are taken in order; each joins the first kept vertex within the tolerance, which
    /// stays where it is, or is kept itself. So all kept vertices are farther apart than the
    /// tolerance, and welding again changes nothing. Tolerance 0 joins equal coordinates only.
    /// Triangles with fewer than three different corners are dropped and counted.
    ///
    /// # Errors
    /// A tolerance that is negative or not finite, or one so large that no triangle remains.
    pub fn weld(&self, tolerance_m: f64) -> Result<(SurfaceMesh, WeldInfo), MeshError> {
        if !(tolerance_m.is_finite() && tolerance_m >= 0.0) {
            return Err(MeshError::WeldTolerance { tolerance_m });
        }
        let mut kept = KeptVertices::new(tolerance_m);
        let new_vertex: Vec<u32> = self.vertices().iter().map(|v| kept.join(v)).collect();
        let mut info = WeldInfo {
            n_merged_vertices: self.vertices().len() - kept.positions.len(),
            n_collapsed_triangles: 0,
            n_repeated_corner_triangles: 0,
            new_vertex,
            old_triangle: Vec::new(),
        };
        let mut triangles = Vec::with_capacity(self.triangles().len());
        for (old, corners) in self.triangles().iter().enumerate() {
            let new = corners.map(|v| info.new_vertex[v as usize]);
            if repeats(corners) {
                info.n_repeated_corner_triangles += 1;
            } else if repeats(&new) {
                info.n_collapsed_triangles += 1;
            } else {
                info.old_triangle.push(old);
                triangles.push(new);
            }
        }
        Ok((SurfaceMesh::new(kept.positions, triangles)?, info))
    }
}

/// The vertices kept so far in a grid of cells as wide as the tolerance.
struct KeptVertices {
    tolerance_m: f64,
    positions: Vec<Point3<f64>>,
    cells: HashMap<[u64; 3], Vec<u32>>,
}

impl KeptVertices {
    fn new(tolerance_m: f64) -> Self {
        Self { tolerance_m, positions: Vec::new(), cells: HashMap::new() }
    }

    /// The kept vertex that `position` joins, which may be itself.
    fn join(&mut self, position: &Point3<f64>) -> u32 {
        if let Some(kept) = self.first_near(position) {
            return kept;
        }
        let index = self.positions.len() as u32;
        self.positions.push(*position);
        self.cells.entry(self.cell(position, [0.0; 3])).or_default().push(index);
        index
    }

    fn first_near(&self, position: &Point3<f64>) -> Option<u32> {
        let steps: &[f64] = if self.tolerance_m == 0.0 { &[0.0] } else { &[-1.0, 0.0, 1.0] };
        let near = |&&kept: &&u32| {
            nalgebra::distance(&self.positions[kept as usize], position) <= self.tolerance_m
        };
        let mut first = None;
        for &dx in steps {
            for &dy in steps {
                for &dz in steps {
                    let cell = self.cells.get(&self.cell(position, [dx, dy, dz]));
                    let found = cell.and_then(|cell| cell.iter().find(near));
                    first = [first, found.copied()].into_iter().flatten().min();
                }
            }
        }
        first
    }

    /// The cell `steps` away from the one that holds `position`. Cells are numbered by floating
    /// point, which neither overflows nor wraps; adding 0.0 makes -0.0 and 0.0 one cell.
    fn cell(&self, position: &Point3<f64>, steps: [f64; 3]) -> [u64; 3] {
        std::array::from_fn(|i| {
            let x = position[i];
            let number = if self.tolerance_m == 0.0 { x } else { (x / self.tolerance_m).floor() };
            (number + steps[i] + 0.0).to_bits()
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::surface::triangles::tests::{cuboid, sphere};

    /// The same triangles with three vertices of their own each.
    fn unshared(mesh: &SurfaceMesh) -> SurfaceMesh {
        let vertices = (0..mesh.triangles().len()).flat_map(|t| mesh.corners(t)).collect();
        let triangles =
            (0..mesh.triangles().len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        SurfaceMesh::new(vertices, triangles).unwrap()
    }

    #[test]
    fn a_box_of_loose_triangles_becomes_one_again() {
        let mesh = cuboid(0.1, 0.2, 0.3);
        let (welded, info) = unshared(&mesh).weld(0.0).unwrap();
        assert_eq!((welded.vertices().len(), welded.triangles().len()), (8, 12));
        assert_eq!((info.n_merged_vertices, info.n_collapsed_triangles), (28, 0));
        assert_eq!(info.old_triangle, (0..12).collect::<Vec<_>>());
        assert_eq!(welded.signed_volume_m3(), mesh.signed_volume_m3());
    }

    #[test]
    fn minus_zero_is_zero() {
        let p = Point3::new;
        let vertices =
            vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.0, 1.0, 0.0), p(-0.0, -0.0, 0.0)];
        let mesh = SurfaceMesh::new(vertices, vec![[0, 1, 2], [3, 1, 2]]).unwrap();
        assert_eq!(mesh.weld(0.0).unwrap().1.n_merged_vertices, 1);
    }

    #[test]
    fn dropped_triangles_are_counted_by_cause() {
        let p = Point3::new;
        let vertices =
            vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.0, 1.0, 0.0), p(1e-6, 0.0, 0.0)];
        let triangles = vec![[0, 1, 2], [0, 3, 2], [1, 1, 2]];
        let mesh = SurfaceMesh::new(vertices, triangles).unwrap();
        let (welded, info) = mesh.weld(1e-5).unwrap();
        assert_eq!(welded.triangles(), [[0, 1, 2]]);
        assert_eq!((info.n_merged_vertices, info.n_collapsed_triangles), (1, 1));
        assert_eq!(info.n_repeated_corner_triangles, 1);
        assert_eq!(info.new_vertex, [0, 1, 2, 0]);
    }

    #[test]
    fn bad_tolerances_are_refused() {
        for tolerance_m in [-1e-9, f64::NAN, f64::INFINITY] {
            let error = cuboid(1.0, 1.0, 1.0).weld(tolerance_m).unwrap_err();
            assert!(matches!(error, MeshError::WeldTolerance { .. }), "{error}");
        }
        let error = cuboid(1.0, 1.0, 1.0).weld(10.0).unwrap_err();
        assert!(matches!(error, MeshError::NoTriangles { n_vertices: 1 }), "{error}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn welding_again_changes_nothing(
            coordinates in prop::collection::vec([-1.0..1.0, -1.0..1.0, -1.0..1.0], 30),
            tolerance_m in prop_oneof![Just(0.0), 1e-3..0.5],
        ) {
            let vertices: Vec<_> = coordinates.into_iter().map(Point3::from).collect();
            let triangles = (0..10).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
            let mesh = SurfaceMesh::new(vertices, triangles).unwrap();
            let Ok((once, info)) = mesh.weld(tolerance_m) else { return Ok(()) };
            prop_assert_eq!(info.old_triangle.len() + info.n_collapsed_triangles, 10);
            for (a, p) in once.vertices().iter().enumerate() {
                for q in &once.vertices()[..a] {
                    prop_assert!(nalgebra::distance(p, q) > tolerance_m);
                }
            }
            for (old, p) in mesh.vertices().iter().enumerate() {
                let new = once.vertices()[info.new_vertex[old] as usize];
                prop_assert!(nalgebra::distance(p, &new) <= tolerance_m);
            }
            let (twice, again) = once.weld(tolerance_m).unwrap();
            prop_assert_eq!(again.n_merged_vertices, 0);
            prop_assert_eq!(once, twice);
        }

        #[test]
        fn jittered_copies_join(seed in prop::collection::vec(-1e-7..1e-7, 3 * 384)) {
            let mesh = sphere(2);
            let loose = unshared(&mesh);
            let jittered = loose.vertices().iter().zip(seed.chunks(3))
                .map(|(v, d)| Point3::new(v.x + d[0], v.y + d[1], v.z + d[2])).collect();
            let loose = SurfaceMesh::new(jittered, loose.triangles().to_vec()).unwrap();
            let (welded, info) = loose.weld(1e-6).unwrap();
            prop_assert_eq!(welded.vertices().len(), mesh.vertices().len());
            prop_assert_eq!(info.n_collapsed_triangles, 0);
        }
    }
}
