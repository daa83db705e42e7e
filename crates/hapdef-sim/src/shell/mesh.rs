//! The mid-surface of a shell: triangles, thickness and directors.

use hapdef_mesh::{FeNodeId, SurfaceMesh};
use nalgebra::{Point3, Vector3};

use super::facet::{Facet, MIN_COS};
use super::quadrature::centroid;
use crate::elements::parts::DisjointSets;
use crate::loads::nodal::check_node;
use crate::loads::patch::unit;
use crate::{SimError, SymmetryPlane};

/// How a shell mesh is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShellMeshParams {
    /// Two triangles that meet at a larger angle than this (between their normals, rad) meet at a
    /// fold: each keeps its own normal there. Below it they are facets of one curved surface.
    pub fold_rad: f64,
}

impl Default for ShellMeshParams {
    /// 40°.
    fn default() -> Self {
        Self { fold_rad: 40.0_f64.to_radians() }
    }
}

/// A triangulated mid-surface with its wall.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellMesh {
    nodes: Vec<Point3<f64>>,
    triangles: Vec<[FeNodeId; 3]>,
    thickness_m: Vec<f64>,
    directors: Vec<[Vector3<f64>; 3]>,
}

impl ShellMesh {
    /// The shell on `triangles` (corners counter-clockwise seen from outside) between `nodes`, m,
    /// with the wall `thickness_m` `[n_nodes]` centred on them and default params.
    ///
    /// # Errors
    /// As [`Self::with_params`].
    pub fn new(
        nodes: Vec<Point3<f64>>,
        triangles: Vec<[FeNodeId; 3]>,
        thickness_m: Vec<f64>,
    ) -> Result<Self, SimError> {
        Self::with_params(nodes, triangles, thickness_m, &ShellMeshParams::default())
    }

    /// The shell on a welded surface, all of one thickness, with default params.
    ///
    /// # Errors
    /// As [`Self::with_params`].
    pub fn of_surface(surface: &SurfaceMesh, thickness_m: f64) -> Result<Self, SimError> {
        let nodes = surface.vertices().to_vec();
        let triangles = surface.triangles().iter();
        let triangles = triangles.map(|t| t.map(|v| FeNodeId::from_index(v as usize)));
        let thickness_m = vec![thickness_m; nodes.len()];
        Self::new(nodes, triangles.collect(), thickness_m)
    }

    /// The shell with directors from the surface: at each node the mean of the normals of the
    /// triangles around it, weighted by their angles there (Thürmer and Wüthrich, J. Graphics Tools
    /// 3, 1998), over those that meet without a fold.
    ///
    /// # Errors
    /// [`SimError::NodeOutOfRange`], [`SimError::Length`], [`SimError::UnusedNode`];
    /// [`SimError::ShellElement`] on a triangle without area or a thickness that is not positive.
    pub fn with_params(
        nodes: Vec<Point3<f64>>,
        triangles: Vec<[FeNodeId; 3]>,
        thickness_m: Vec<f64>,
        params: &ShellMeshParams,
    ) -> Result<Self, SimError> {
        check_triangles(&triangles, nodes.len())?;
        if thickness_m.len() != nodes.len() {
            return Err(SimError::Length {
                what: "the shell's thickness",
                expected: nodes.len(),
                found: thickness_m.len(),
            });
        }
        let mut mesh = Self { directors: Vec::new(), nodes, triangles, thickness_m };
        mesh.directors = mesh.surface_directors(params)?;
        Ok(mesh)
    }

    /// The shell cut at mirror planes: directors of the planes' nodes are laid into them, as those
    /// of the whole surface would be.
    ///
    /// # Errors
    /// [`SimError::NodeOutOfRange`], [`SimError::Direction`].
    pub fn cut_at(mut self, planes: &[SymmetryPlane]) -> Result<Self, SimError> {
        for plane in planes {
            let normal = unit("the normal of a symmetry plane", &plane.normal)?;
            let mut in_plane = vec![false; self.nodes.len()];
            for &node in &plane.nodes {
                check_node("a symmetry plane", node, self.nodes.len())?;
                in_plane[node.index()] = true;
            }
            for (triangle, directors) in self.triangles.iter().zip(&mut self.directors) {
                for (node, director) in triangle.iter().zip(directors) {
                    let flat = *director - normal * normal.dot(director);
                    if in_plane[node.index()]
                        && let Some(flat) = flat.try_normalize(MIN_COS)
                    {
                        *director = flat;
                    }
                }
            }
        }
        Ok(self)
    }

    /// Node positions `[n_nodes]`, m.
    #[must_use]
    pub fn nodes(&self) -> &[Point3<f64>] {
        &self.nodes
    }

    /// Corner nodes of each triangle `[n_triangles]`.
    #[must_use]
    pub fn triangles(&self) -> &[[FeNodeId; 3]] {
        &self.triangles
    }

    /// The wall at each node `[n_nodes]`, m.
    #[must_use]
    pub fn thickness_m(&self) -> &[f64] {
        &self.thickness_m
    }

    /// Unit directors at the corners of each triangle `[n_triangles]`.
    #[must_use]
    pub fn directors(&self) -> &[[Vector3<f64>; 3]] {
        &self.directors
    }

    /// The corners of a triangle, m.
    ///
    /// # Panics
    /// If `triangle` is not one of the mesh.
    #[must_use]
    pub fn corners(&self, triangle: usize) -> [Point3<f64>; 3] {
        self.triangles[triangle].map(|node| self.nodes[node.index()])
    }

    /// The wall at the corners of a triangle, m.
    ///
    /// # Panics
    /// If `triangle` is not one of the mesh.
    #[must_use]
    pub fn corner_thickness_m(&self, triangle: usize) -> [f64; 3] {
        self.triangles[triangle].map(|node| self.thickness_m[node.index()])
    }

    /// The enclosed material's volume Σ A t̄, m³.
    #[must_use]
    pub fn wall_volume_m3(&self) -> f64 {
        (0..self.triangles.len())
            .map(|i| {
                let [a, b, c] = self.corners(i);
                let mean: f64 = self.corner_thickness_m(i).iter().sum::<f64>() * centroid()[0];
                0.5 * (b - a).cross(&(c - a)).norm() * mean
            })
            .sum()
    }

    fn surface_directors(
        &self,
        params: &ShellMeshParams,
    ) -> Result<Vec<[Vector3<f64>; 3]>, SimError> {
        let mut normals = Vec::with_capacity(self.triangles.len());
        for triangle in 0..self.triangles.len() {
            let facet = Facet::new(&self.corners(triangle), None);
            let of_element = |problem| SimError::ShellElement { element: triangle, problem };
            normals.push(facet.map_err(of_element)?.axes[2]);
        }
        let group_of_corner = self.smooth_groups(&normals, params.fold_rad.cos());
        let mut sums = vec![Vector3::zeros(); 3 * self.triangles.len()];
        for (triangle, normal) in normals.iter().enumerate() {
            let p = self.corners(triangle);
            for k in 0..3 {
                let angle = (p[(k + 1) % 3] - p[k]).angle(&(p[(k + 2) % 3] - p[k]));
                sums[group_of_corner[3 * triangle + k]] += normal * angle;
            }
        }
        let director = |triangle: usize, k: usize| {
            sums[group_of_corner[3 * triangle + k]]
                .try_normalize(0.0)
                .filter(|d| d.dot(&normals[triangle]) >= MIN_COS)
                .unwrap_or(normals[triangle])
        };
        Ok((0..self.triangles.len())
            .map(|triangle| [0, 1, 2].map(|k| director(triangle, k)))
            .collect())
    }

    /// For each corner (3 · triangle + k), the name of its group: corners at one node whose
    /// triangles meet over sides without a fold.
    fn smooth_groups(&self, normals: &[Vector3<f64>], min_cos: f64) -> Vec<usize> {
        let mut sides: Vec<([FeNodeId; 2], usize, [usize; 2])> = Vec::new();
        for (triangle, nodes) in self.triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (3 * triangle + k, 3 * triangle + (k + 1) % 3);
                let (p, q) = (nodes[k], nodes[(k + 1) % 3]);
                let (ends, corners) = if p < q { ([p, q], [a, b]) } else { ([q, p], [b, a]) };
                sides.push((ends, triangle, corners));
            }
        }
        sides.sort_unstable();
        let mut sets = DisjointSets::new(3 * self.triangles.len());
        for pair in sides.windows(2) {
            let ((ends, s, c), (other_ends, t, d)) = (pair[0], pair[1]);
            if ends == other_ends && normals[s].dot(&normals[t]) >= min_cos {
                sets.join(c[0], d[0]);
                sets.join(c[1], d[1]);
            }
        }
        sets.roots()
    }
}

fn check_triangles(triangles: &[[FeNodeId; 3]], n_nodes: usize) -> Result<(), SimError> {
    let mut used = vec![false; n_nodes];
    for triangle in triangles {
        for &node in triangle {
            check_node("a shell triangle", node, n_nodes)?;
            used[node.index()] = true;
        }
    }
    match used.iter().position(|used| !used) {
        Some(node) => Err(SimError::UnusedNode { node }),
        None => Ok(()),
    }
}
