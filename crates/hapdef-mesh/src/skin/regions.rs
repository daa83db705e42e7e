//! The contact surface of a solid limb: which boundary faces can be touched from outside.

use nalgebra::{Point3, Vector3};

use crate::solid::boundary::nodes_of;
use crate::{BoundarySurface, FeNodeId, MeshError, SurfaceMesh, Tet10Mesh, Tri6Face, tri6};

/// A part of the boundary that contacts can touch.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinRegion {
    /// The faces, in boundary order.
    pub faces: Vec<Tri6Face>,
    /// The nodes of these faces, mid-side nodes included, ascending; a node's place in this list
    /// is its [`crate::SurfaceNodeId`].
    pub nodes: Vec<FeNodeId>,
    /// The outward unit normal at each node `[n_surface_nodes]`.
    pub normals: Vec<Vector3<f64>>,
}

/// A region seen from an axis: the outer barrel of a limb, without rims, ribs and end plates.
#[derive(Clone, Debug, PartialEq)]
pub struct RadialRegionParams {
    /// A point on the axis; axial positions count from it, m.
    pub axis_point: Point3<f64>,
    /// The axis direction, of any length.
    pub axis_dir: Vector3<f64>,
    /// A face is taken if its normal's component away from the axis exceeds this.
    pub min_normal_dot_radial: f64,
    /// A face is taken if its centroid is farther from the axis than this, m.
    pub min_radius_m: f64,
    /// A face is taken if its centroid lies between these along the axis, ends excluded, m.
    pub axial_range_m: (f64, f64),
}

impl SkinRegion {
    /// The region made of `faces`.
    ///
    /// A node's normal is the direction of the sum of its faces' area vectors at that node.
    ///
    /// # Errors
    /// [`MeshError::EmptySkin`] without faces; [`MeshError::SkinNormal`] at a node whose faces'
    /// area vectors cancel.
    pub fn new(mesh: &Tet10Mesh, faces: Vec<Tri6Face>) -> Result<Self, MeshError> {
        if faces.is_empty() {
            return Err(MeshError::EmptySkin { size_m: size_m(mesh) });
        }
        let nodes = nodes_of(&faces);
        let mut sums = vec![Vector3::zeros(); nodes.len()];
        for face in &faces {
            let positions = face_positions(mesh, face);
            for (id, [xi, eta]) in face.nodes.iter().zip(tri6::NODE_COORDINATES) {
                if let Ok(i) = nodes.binary_search(id) {
                    sums[i] += tri6::area_vector(&positions, xi, eta);
                }
            }
        }
        let normals = nodes
            .iter()
            .zip(sums)
            .map(|(&node, sum)| {
                sum.try_normalize(0.0).ok_or(MeshError::SkinNormal { node: node.0 })
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { faces, nodes, normals })
    }

    /// The region as a triangle surface: vertex `i` is surface node `i`, and each six-node face
    /// becomes the four flat triangles between its nodes.
    ///
    /// # Errors
    /// What [`SurfaceMesh::new`] refuses, which a region of a valid mesh is not.
    pub fn surface(&self, mesh: &Tet10Mesh) -> Result<SurfaceMesh, MeshError> {
        let vertices = self.nodes.iter().map(|node| mesh.position(*node)).collect();
        let place = |node: &FeNodeId| self.nodes.partition_point(|other| other < node) as u32;
        let triangles = self
            .faces
            .iter()
            .flat_map(|face| {
                let [a, b, c, ab, bc, ca] = face.nodes.map(|node| place(&node));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
        SurfaceMesh::new(vertices, triangles)
    }

    /// The region's area, m².
    #[must_use]
    pub fn area_m2(&self, mesh: &Tet10Mesh) -> f64 {
        self.faces.iter().map(|face| tri6::area(&face_positions(mesh, face))).sum()
    }
}

/// Edges of the solid's bounding box, m.
fn size_m(mesh: &Tet10Mesh) -> [f64; 3] {
    [0, 1, 2].map(|axis| {
        let along = || mesh.nodes().iter().map(|node| node[axis]);
        let low = along().fold(f64::INFINITY, f64::min);
        let high = along().fold(f64::NEG_INFINITY, f64::max);
        high - low
    })
}

/// The six node positions of `face`, m.
#[must_use]
pub fn face_positions(mesh: &Tet10Mesh, face: &Tri6Face) -> [Point3<f64>; 6] {
    face.nodes.map(|node| mesh.position(node))
}

/// The boundary faces that look away from an axis.
///
/// # Errors
/// [`MeshError::RegionParams`] if the axis has no direction, a number is not finite, or the axial
/// range is empty; [`MeshError::EmptySkin`] if no face qualifies.
pub fn radial_region(
    mesh: &Tet10Mesh,
    boundary: &BoundarySurface,
    params: &RadialRegionParams,
) -> Result<SkinRegion, MeshError> {
    let axis = checked_axis(params)?;
    let faces = boundary
        .faces
        .iter()
        .filter(|face| looks_outward(&face_positions(mesh, face), &axis, params))
        .copied()
        .collect();
    SkinRegion::new(mesh, faces)
}

fn checked_axis(params: &RadialRegionParams) -> Result<Vector3<f64>, MeshError> {
    let (low, high) = params.axial_range_m;
    let refuse = |why| MeshError::RegionParams { why };
    if !(params.axis_point.iter().all(|c| c.is_finite()) && params.min_radius_m.is_finite()) {
        return Err(refuse("axis_point and min_radius_m must be finite"));
    }
    if !(-1.0..1.0).contains(&params.min_normal_dot_radial) {
        return Err(refuse("min_normal_dot_radial must be at least -1 and below 1"));
    }
    if low.is_nan() || high.is_nan() || low >= high {
        return Err(refuse("axial_range_m must rise from its first to its second value"));
    }
    params
        .axis_dir
        .try_normalize(0.0)
        .filter(|axis| axis.iter().all(|c| c.is_finite()))
        .ok_or(refuse("axis_dir must be finite and not zero"))
}

fn looks_outward(
    nodes: &[Point3<f64>; 6],
    axis: &Vector3<f64>,
    params: &RadialRegionParams,
) -> bool {
    let third = 1.0 / 3.0;
    let offset = tri6::position(nodes, third, third) - params.axis_point;
    let axial_m = offset.dot(axis);
    let radial = offset - axis * axial_m;
    let (low, high) = params.axial_range_m;
    let Some(outward) = radial.try_normalize(0.0) else {
        return false;
    };
    let Some(normal) = tri6::area_vector(nodes, third, third).try_normalize(0.0) else {
        return false;
    };
    low < axial_m
        && axial_m < high
        && radial.norm() > params.min_radius_m
        && normal.dot(&outward) > params.min_normal_dot_radial
}
