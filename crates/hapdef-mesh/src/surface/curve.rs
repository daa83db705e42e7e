//! Where the middle of an edge lies when the faces of a triangle surface stand for curved ones.

use std::fmt;

use nalgebra::{Point3, Vector3};

use crate::SurfaceMesh;
use crate::surface::topology::sorted_half_edges;

/// The surface that a triangle surface stands for, as far as the middles of its edges go.
#[derive(Clone, Copy, Default)]
pub enum FaceCurve<'a> {
    /// The triangles themselves.
    #[default]
    Flat,
    /// Curved point-normal triangles: the middle of the cubic edge given by both ends' positions
    /// and normals (Vlachos, Peters, Boyd and Mitchell, Curved PN Triangles, Symposium on
    /// Interactive 3D Graphics 2001, section 3). Edges sharper than `feature_angle_rad` stay
    /// straight; an edge that ends on one takes the normals of its own triangles there.
    PointNormal {
        /// Triangles that differ in direction by more than this meet in a sharp edge, rad.
        feature_angle_rad: f64,
    },
    /// A given surface: the map from a point near it to a point on it.
    Onto(&'a dyn Fn(&Point3<f64>) -> Point3<f64>),
}

/// Sharp edges of a given surface, rad: 40°.
const FEATURE_ANGLE_RAD: f64 = 40.0 * std::f64::consts::PI / 180.0;

impl fmt::Debug for FaceCurve<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flat => f.write_str("Flat"),
            Self::PointNormal { feature_angle_rad } => {
                f.debug_struct("PointNormal").field("feature_angle_rad", feature_angle_rad).finish()
            }
            Self::Onto(_) => f.write_str("Onto(..)"),
        }
    }
}

/// The edges of a surface with their middles.
pub(crate) struct EdgeMiddles {
    /// Ends ascending, in order.
    pub edges: Vec<[u32; 2]>,
    /// The middle of each edge.
    pub middles: Vec<Point3<f64>>,
    /// Which vertices are on a sharp edge `[n_vertices]`; all of them where faces are flat.
    pub is_sharp: Vec<bool>,
    /// Unit normals of the smooth surface `[n_vertices]`, see [`smooth_normals`].
    pub normals: Vec<Vector3<f64>>,
}

impl EdgeMiddles {
    pub fn of(mesh: &SurfaceMesh, curve: &FaceCurve<'_>) -> Self {
        let feature_angle_rad = match curve {
            FaceCurve::Flat => 0.0,
            FaceCurve::PointNormal { feature_angle_rad } => *feature_angle_rad,
            FaceCurve::Onto(_) => FEATURE_ANGLE_RAD,
        };
        let edges = Edge::all(mesh);
        let is_feature = |edge: &Edge| edge.angle_rad > feature_angle_rad;
        let mut is_sharp = vec![matches!(curve, FaceCurve::Flat); mesh.vertices().len()];
        for vertex in edges.iter().filter(|e| is_feature(e)).flat_map(|e| e.ends) {
            is_sharp[vertex as usize] = true;
        }
        let normals = smooth_normals(mesh);
        let middle = |edge: &Edge| {
            let [a, b] = edge.ends.map(|v| mesh.vertices()[v as usize]);
            let straight = nalgebra::center(&a, &b);
            match curve {
                FaceCurve::Onto(surface) => surface(&straight),
                FaceCurve::PointNormal { .. } if !is_feature(edge) => {
                    let [n_a, n_b] = edge.ends.map(|v| match is_sharp[v as usize] {
                        true => edge.normal,
                        false => normals[v as usize],
                    });
                    // (b300 + 3 b210 + 3 b120 + b030) / 8 of the paper's control points.
                    straight - (n_a * n_a.dot(&(b - a)) + n_b * n_b.dot(&(a - b))) / 8.0
                }
                _ => straight,
            }
        };
        Self {
            middles: edges.iter().map(middle).collect(),
            edges: edges.iter().map(|edge| edge.ends).collect(),
            is_sharp,
            normals,
        }
    }

    /// The number of the edge between two vertices, which must be one of the surface.
    pub fn number(&self, a: u32, b: u32) -> usize {
        let ends = [a.min(b), a.max(b)];
        self.edges.partition_point(|edge| *edge < ends)
    }
}

/// Outward unit normals where the surface is smooth: a triangle with edges e₁, e₂ at the vertex
/// counts e₁ × e₂ / (|e₁|² |e₂|²), which is exact for vertices of any triangulated sphere (Max,
/// Weights for Computing Vertex Normals from Facet Normals, J. Graphics Tools 4(2), 1999). Zero
/// where there is none.
fn smooth_normals(mesh: &SurfaceMesh) -> Vec<Vector3<f64>> {
    let mut sums = vec![Vector3::zeros(); mesh.vertices().len()];
    for (triangle, corners) in mesh.triangles().iter().enumerate() {
        let p = mesh.corners(triangle);
        for i in 0..3 {
            let (e1, e2) = (p[(i + 1) % 3] - p[i], p[(i + 2) % 3] - p[i]);
            let weight = e1.norm_squared() * e2.norm_squared();
            if weight > 0.0 {
                sums[corners[i] as usize] += e1.cross(&e2) / weight;
            }
        }
    }
    let unit = |sum: &Vector3<f64>| sum.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    sums.iter().map(unit).collect()
}

struct Edge {
    ends: [u32; 2],
    /// How much its two triangles differ in direction, rad; 0 on a rim.
    angle_rad: f64,
    /// The mean unit normal of its triangles.
    normal: Vector3<f64>,
}

impl Edge {
    fn all(mesh: &SurfaceMesh) -> Vec<Self> {
        let halves = sorted_half_edges(mesh.triangles());
        let edges = halves.chunk_by(|a, b| a.ends() == b.ends()).map(|uses| {
            let unit = |t| mesh.area_normal_m2(t).try_normalize(0.0);
            let normals: Vec<Vector3<f64>> =
                uses.iter().filter_map(|half| unit(half.triangle)).collect();
            let sum: Vector3<f64> = normals.iter().sum();
            Self {
                ends: [uses[0].low, uses[0].high],
                angle_rad: match normals[..] {
                    [a, b] => a.angle(&b),
                    _ => 0.0,
                },
                normal: sum.try_normalize(0.0).unwrap_or_else(Vector3::zeros),
            }
        });
        edges.collect()
    }
}
