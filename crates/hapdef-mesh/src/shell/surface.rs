//! A shell's middle surface with its thickness.

use nalgebra::{Point3, Vector3};

use crate::surface::find_defects::check_manifold;
use crate::{MeshError, SurfaceFault, SurfaceMesh};

/// Where in the wall a skin lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkinSide {
    /// The skin is the wall's outside; the wall lies against the normals.
    Outer,
    /// The skin is the middle of the wall.
    Middle,
    /// The skin is the wall's inside; the wall lies along the normals.
    Inner,
}

impl SkinSide {
    /// The share of the thickness that lies beyond the skin, along its normals.
    pub(crate) fn share_outside(self) -> f64 {
        match self {
            Self::Outer => 0.0,
            Self::Middle => 0.5,
            Self::Inner => 1.0,
        }
    }
}

/// What a shell model needs of a limb: the middle surface, the thickness and the director at every
/// node. The triangles form an oriented manifold, open or closed, seen counter-clockwise from
/// outside.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellSurface {
    middle: SurfaceMesh,
    thickness_m: Vec<f64>,
    directors: Vec<Vector3<f64>>,
}

impl ShellSurface {
    /// The shell whose wall has `skin` on its side `side` and is `thickness_m` `[n_vertices]`
    /// thick, measured across the wall.
    ///
    /// Where the skin is not the middle, each node moves half the thickness along the mean normal
    /// of its triangles, farther at an edge so that the planes of its triangles move by just that
    /// half.
    ///
    /// # Errors
    /// [`MeshError::Surface`]: a skin that is no oriented manifold, or has degenerate or doubled
    /// triangles or vertices without a normal; a thickness that is not above 0 and finite; a
    /// triangle that turns over on the way ([`SurfaceFault::OffsetFolds`]).
    pub fn from_skin(
        skin: &SurfaceMesh,
        thickness_m: &[f64],
        side: SkinSide,
    ) -> Result<Self, MeshError> {
        check_manifold(skin)?;
        check_thickness(skin.vertices().len(), thickness_m)?;
        let directors = skin.vertex_normals();
        let steps = steps(skin, &directors)?;
        let middle = match side.share_outside() - 0.5 {
            0.0 => skin.clone(),
            share => moved(skin, &steps, thickness_m, share)?,
        };
        Ok(Self { middle, thickness_m: thickness_m.to_vec(), directors })
    }

    /// The shell of one thickness, m: see [`from_skin`](Self::from_skin).
    ///
    /// # Errors
    /// Those of [`from_skin`](Self::from_skin).
    pub fn with_constant_thickness(
        skin: &SurfaceMesh,
        thickness_m: f64,
        side: SkinSide,
    ) -> Result<Self, MeshError> {
        Self::from_skin(skin, &vec![thickness_m; skin.vertices().len()], side)
    }

    /// The middle surface, m.
    #[must_use]
    pub fn middle(&self) -> &SurfaceMesh {
        &self.middle
    }

    /// Node positions on the middle surface `[n_nodes]`, m.
    #[must_use]
    pub fn nodes(&self) -> &[Point3<f64>] {
        self.middle.vertices()
    }

    /// Triangles `[n_triangles]`, three nodes each.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        self.middle.triangles()
    }

    /// Thickness `[n_nodes]`, m.
    #[must_use]
    pub fn thickness_m(&self) -> &[f64] {
        &self.thickness_m
    }

    /// Outward unit vectors across the wall `[n_nodes]`.
    #[must_use]
    pub fn directors(&self) -> &[Vector3<f64>] {
        &self.directors
    }

    /// Σ area × mean thickness over the triangles, m³.
    #[must_use]
    pub fn volume_m3(&self) -> f64 {
        let of_triangle = |(triangle, corners): (usize, &[u32; 3])| {
            let sum: f64 = corners.iter().map(|&v| self.thickness_m[v as usize]).sum();
            self.middle.area_normal_m2(triangle).norm() * sum / 3.0
        };
        self.triangles().iter().enumerate().map(of_triangle).sum()
    }
}

pub(crate) fn check_thickness(n_nodes: usize, thickness_m: &[f64]) -> Result<(), SurfaceFault> {
    let n_values = thickness_m.len();
    if n_values != n_nodes {
        return Err(SurfaceFault::ThicknessCount { n_values, n_nodes });
    }
    match thickness_m.iter().position(|t| !(t.is_finite() && *t > 0.0)) {
        None => Ok(()),
        Some(node) => Err(SurfaceFault::Thickness { node, thickness_m: thickness_m[node] }),
    }
}

/// The farthest a node moves at an edge, in units of the offset: the mitre of a 60° edge.
const LONGEST_STEP: f64 = 2.0;

/// How every vertex moves per metre of offset `[n_vertices]`: along `normals`, so long that the
/// planes of its triangles move one metre in the angle-weighted mean, and at most
/// [`LONGEST_STEP`]. Exact where all triangles make the same angle with the normal: on smooth
/// surfaces, straight edges and the corners of boxes.
pub(crate) fn steps(
    skin: &SurfaceMesh,
    normals: &[Vector3<f64>],
) -> Result<Vec<Vector3<f64>>, SurfaceFault> {
    let mut sums = vec![(0.0, 0.0); normals.len()];
    for (triangle, corners) in skin.triangles().iter().enumerate() {
        let normal = skin.area_normal_m2(triangle).try_normalize(0.0);
        let normal = normal.unwrap_or_else(Vector3::zeros);
        let angles = crate::surface::triangles::corner_angles_rad(&skin.corners(triangle));
        for (&v, angle) in corners.iter().zip(angles) {
            let sum = &mut sums[v as usize];
            *sum = (sum.0 + angle * normal.dot(&normals[v as usize]), sum.1 + angle);
        }
    }
    let step = |(node, (cosines, angles)): (usize, (f64, f64))| {
        if angles <= 0.0 || normals[node] == Vector3::zeros() {
            return Err(SurfaceFault::NoNormal { node });
        }
        Ok(normals[node] / (cosines / angles).max(1.0 / LONGEST_STEP))
    };
    sums.into_iter().enumerate().map(step).collect()
}

/// The skin moved by `share` of its thickness along `steps`.
fn moved(
    skin: &SurfaceMesh,
    steps: &[Vector3<f64>],
    thickness_m: &[f64],
    share: f64,
) -> Result<SurfaceMesh, MeshError> {
    let places = skin.vertices().iter().zip(steps).zip(thickness_m);
    let vertices = places.map(|((p, step), t)| p + step * (share * t)).collect();
    let moved = SurfaceMesh::new(vertices, skin.triangles().to_vec())?;
    for (triangle, corners) in skin.triangles().iter().enumerate() {
        if turns_over(skin, &moved, triangle) {
            let distance = |&v: &u32| thickness_m[v as usize] * share.abs();
            let offset_m = corners.iter().map(distance).fold(0.0, f64::max);
            return Err(SurfaceFault::OffsetFolds { triangle, offset_m }.into());
        }
    }
    Ok(moved)
}

/// Whether a triangle's normal or one of its edges has turned round: beyond the centre of a sphere
/// the edges have, but not the normal.
fn turns_over(old: &SurfaceMesh, new: &SurfaceMesh, triangle: usize) -> bool {
    let [a, b] = [old, new].map(|mesh| mesh.area_normal_m2(triangle));
    let [p, q] = [old, new].map(|mesh| mesh.corners(triangle));
    let turns = |i: usize| (p[(i + 1) % 3] - p[i]).dot(&(q[(i + 1) % 3] - q[i])) <= 0.0;
    a.dot(&b) <= 0.0 || (0..3).any(turns)
}
