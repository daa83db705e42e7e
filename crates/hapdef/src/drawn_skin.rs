//! The glTF surface that the live page draws instead of a deck's skin.

use std::path::Path;

use hapdef_mesh::{ClosestPoint, GltfParams, PointIndex, SurfaceMesh, read_gltf};
use nalgebra::{Point3, Vector3};

use crate::error::HapdefError;
use crate::limb::Limb;
use crate::scene::Scene;

/// A vertex within this many times the skin's mean node spacing moves with the skin.
const BESIDE_SPACINGS: f64 = 2.0;

/// Nodes that a vertex moves with.
const N_AROUND: usize = 3;

/// A glTF surface in place of the skin. It moves as the skin beside it does.
#[derive(Clone, Debug)]
pub struct DrawnSkin {
    /// Its vertices, those beside the touchable skin first, m.
    pub vertices_m: Vec<Point3<f64>>,
    /// Outward unit normals of the vertices.
    pub normals: Vec<Vector3<f64>>,
    /// Vertices of its triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Of each of the first vertices the surface nodes that it moves with, and their weights, whose
    /// sum is 1.
    pub moves_with: Vec<[(usize, f64); N_AROUND]>,
}

impl DrawnSkin {
    /// Reads `geometry.skin_gltf`, where the scene names one.
    ///
    /// # Errors
    /// [`HapdefError::SkinGltf`] for a file that can't be read, [`HapdefError::SkinGltfElsewhere`] for a
    /// surface that is nowhere beside the touchable skin.
    pub fn load(scene: &Scene, scene_dir: &Path, limb: &Limb) -> Result<Option<Self>, HapdefError> {
        let Some(file) = &scene.geometry.skin_gltf else {
            return Ok(None);
        };
        let path = scene_dir.join(file);
        let surface = match read_gltf(&path, &GltfParams::default()) {
            Ok(surface) => surface.mesh,
            Err(source) => return Err(HapdefError::SkinGltf(Box::new(source))),
        };
        let points = limb.surface_points();
        let spacing_m = (limb.skin.area_m2(&limb.mesh) / points.len() as f64).sqrt();
        let reach_m = BESIDE_SPACINGS * spacing_m;
        Self::on(&surface, &points, reach_m).map(Some).map_err(|nearest_m| {
            HapdefError::SkinGltfElsewhere {
                path,
                nearest_mm: nearest_m * 1e3,
                reach_mm: reach_m * 1e3,
            }
        })
    }

    /// Largest distance from the touchable skin of `limb` to this one, m, and where: a contact there seems to
    /// float, or to be inside.
    ///
    /// # Errors
    /// [`HapdefError::Mesh`] for triangles that make no surface.
    pub fn farthest(&self, limb: &Limb) -> Result<(f64, Point3<f64>), HapdefError> {
        let surface = SurfaceMesh::new(self.vertices_m.clone(), self.triangles.clone())?;
        let drawn = ClosestPoint::of_surface(&surface);
        let gap_m = |point: &Point3<f64>| drawn.nearest(point).map_or(0.0, |near| near.distance_m);
        let gaps = limb.surface_points().into_iter().map(|point| (gap_m(&point), point));
        let farthest = gaps.max_by(|(a, _), (b, _)| a.total_cmp(b));
        Ok(farthest.unwrap_or_default())
    }

    /// `surface` on the nodes of a skin; how far the nearest vertex is where none is within `reach_m`.
    fn on(surface: &SurfaceMesh, nodes: &[Point3<f64>], reach_m: f64) -> Result<Self, f64> {
        let index = PointIndex::new(nodes);
        let vertices = surface.vertices();
        let far_m = |x: &Point3<f64>| index.nearest(x).map_or(f64::INFINITY, |(_, gap_m)| gap_m);
        let gaps_m: Vec<f64> = vertices.iter().map(far_m).collect();
        let is_beside = |&i: &usize| gaps_m[i] <= reach_m;
        let (beside, away): (Vec<usize>, Vec<usize>) = (0..vertices.len()).partition(is_beside);
        if beside.is_empty() {
            return Err(gaps_m.iter().copied().fold(f64::INFINITY, f64::min));
        }
        let order = || beside.iter().chain(&away).copied();
        let mut place = vec![0; vertices.len()];
        for (new, old) in order().enumerate() {
            place[old] = new as u32;
        }
        let normals = surface.vertex_normals();
        let triangles = surface.triangles().iter();
        Ok(Self {
            vertices_m: order().map(|i| vertices[i]).collect(),
            normals: order().map(|i| normals[i]).collect(),
            triangles: triangles.map(|corners| corners.map(|i| place[i as usize])).collect(),
            moves_with: beside.iter().map(|&i| around(&index, nodes, &vertices[i])).collect(),
        })
    }
}

/// The nearest nodes, weighted by inverse distance; fewer than there is room for have the weight 0.
fn around(
    index: &PointIndex,
    nodes: &[Point3<f64>],
    point: &Point3<f64>,
) -> [(usize, f64); N_AROUND] {
    let mut found = [(0, 0.0); N_AROUND];
    for (slot, node) in found.iter_mut().zip(index.k_nearest(point, N_AROUND)) {
        *slot = (node, 1.0 / ((nodes[node] - point).norm() + 1e-6));
    }
    let sum: f64 = found.iter().map(|(_, weight)| weight).sum();
    found.map(|(node, weight)| (node, weight / sum))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x0: f64) -> SurfaceMesh {
        let corner = |[x, y]: [f64; 2]| Point3::new(x0 + x, y, 0.0);
        let corners = [[9.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(corner);
        SurfaceMesh::new(corners.to_vec(), vec![[0, 1, 2], [1, 2, 3]]).unwrap()
    }

    const NODES: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];

    #[test]
    fn vertices_beside_the_skin_come_first_and_move_with_it() {
        let nodes = NODES.map(Point3::from);
        let drawn = DrawnSkin::on(&square(0.0), &nodes, 1.1).unwrap();
        assert_eq!((drawn.moves_with.len(), drawn.vertices_m[3].x), (3, 9.0));
        assert_eq!(drawn.triangles, [[3, 0, 1], [0, 1, 2]]);
        let [(node, weight), ..] = drawn.moves_with[0];
        assert!(node == 1 && weight > 1.0 - 1e-5, "{node} {weight}");
        for of_vertex in &drawn.moves_with {
            let sum: f64 = of_vertex.iter().map(|(_, weight)| weight).sum();
            assert!((sum - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_surface_that_is_elsewhere_is_told_how_far() {
        let nodes = NODES.map(Point3::from);
        let nearest_m = DrawnSkin::on(&square(5.0), &nodes, 1.1).unwrap_err();
        assert_eq!(nearest_m, 4.0, "from [5, 1] to [1, 1]");
    }
}
