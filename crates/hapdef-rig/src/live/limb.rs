//! The perturbed limb at run time: strain for a force anywhere on its surface, without a solve.

use hapdef_mesh::{PointIndex, tri6};
use nalgebra::{Point3, Vector3};

use super::loads::MovingLoads;
use super::nearest::closest_weights;
use crate::error::RigError;

/// Nodes around a place whose triangles are looked at.
const N_NEAR: usize = 8;

/// Nodes of the four flat triangles of a six-node face.
const PARTS: [[usize; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];

/// A point of the limb's touchable surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Six-node face, in the order in which the faces were given.
    pub face: u32,
    /// Coordinates on it, by its corners; their sum is 1.
    pub bary: [f64; 3],
}

/// The touchable surface as six-node faces, with what is known at its nodes.
#[derive(Clone, Debug)]
pub struct LiveSurface {
    /// Nodes `[n_nodes]`, m.
    pub nodes: Vec<Point3<f64>>,
    /// Faces: three corners, then the middles of the sides 0–1, 1–2, 2–0.
    pub faces: Vec<[u32; 6]>,
    /// Direction of a normal press at each node `[n_nodes]`, unit length, into the limb.
    pub inward: Vec<Vector3<f64>>,
}

/// Gauge strains of the simulated "real" limb for forces at any points of its surface: the columns
/// of the adjoint solves at the nodes, interpolated on the faces by their quadratic shape functions.
#[derive(Debug)]
pub struct LiveLimb {
    surface: LiveSurface,
    n_gauges: usize,
    columns_ue_per_n: Vec<Vector3<f64>>,
    loads: MovingLoads,
    /// Faces at each node: `faces_at[starts[n]..starts[n + 1]]`.
    starts: Vec<u32>,
    faces_at: Vec<u32>,
    index: PointIndex,
}

impl LiveLimb {
    /// A limb from the columns at the nodes, `[n_nodes, n_gauges]`: reading of each gauge per newton
    /// along x, y and z, µε/N.
    ///
    /// # Errors
    /// [`RigError::Surface`] for a surface without faces, a face of nodes that are not there, lists
    /// of another length than the nodes', or a number that is not finite.
    pub fn new(
        surface: LiveSurface,
        n_gauges: usize,
        columns_ue_per_n: Vec<Vector3<f64>>,
    ) -> Result<Self, RigError> {
        check(&surface, n_gauges, &columns_ue_per_n)?;
        let (starts, faces_at) = faces_at_nodes(&surface);
        Ok(Self {
            index: PointIndex::new(&surface.nodes),
            surface,
            n_gauges,
            columns_ue_per_n,
            loads: MovingLoads::default(),
            starts,
            faces_at,
        })
    }

    /// The same beside loads that are no contacts.
    #[must_use]
    pub fn with_loads(self, loads: MovingLoads) -> Self {
        Self { loads, ..self }
    }

    /// The loads that are no contacts.
    #[must_use]
    pub fn loads(&self) -> &MovingLoads {
        &self.loads
    }

    /// Number of gauges.
    #[must_use]
    pub fn n_gauges(&self) -> usize {
        self.n_gauges
    }

    /// The surface.
    #[must_use]
    pub fn surface(&self) -> &LiveSurface {
        &self.surface
    }

    /// Columns at the nodes `[n_nodes, n_gauges]`, µε/N along x, y and z.
    #[must_use]
    pub fn columns_ue_per_n(&self) -> &[Vector3<f64>] {
        &self.columns_ue_per_n
    }

    /// The point of the surface nearest to `position_m` and its distance, m; `None` if a coordinate is not
    /// finite. Meant for places at the skin: among the faces around the eight nearest nodes.
    #[must_use]
    pub fn nearest(&self, position_m: &Point3<f64>) -> Option<(SurfacePoint, f64)> {
        let mut best: Option<(f64, SurfacePoint)> = None;
        for node in self.index.k_nearest(position_m, N_NEAR) {
            let faces = self.starts[node] as usize..self.starts[node + 1] as usize;
            for &face in &self.faces_at[faces] {
                let (distance_2, bary) = self.nearest_on(face, position_m);
                let is_nearer = |b: &(f64, SurfacePoint)| {
                    distance_2 < b.0 || (distance_2 <= b.0 && face < b.1.face)
                };
                if best.as_ref().is_none_or(is_nearer) {
                    best = Some((distance_2, SurfacePoint { face, bary }));
                }
            }
        }
        best.map(|(distance_2, point)| (point, distance_2.sqrt()))
    }

    /// Where a point is, m.
    #[must_use]
    pub fn position_m(&self, point: &SurfacePoint) -> Point3<f64> {
        let sum = self.weighted(point, |node| self.surface.nodes[node].coords);
        Point3::from(sum)
    }

    /// Direction of a normal press at a point, unit length, into the limb.
    #[must_use]
    pub fn inward(&self, point: &SurfacePoint) -> Vector3<f64> {
        let sum = self.weighted(point, |node| self.surface.inward[node]);
        let first = self.surface.faces[point.face as usize][0] as usize;
        sum.try_normalize(0.0).unwrap_or(self.surface.inward[first])
    }

    /// Adds the gauges' strains under `force_n` at a point to `strain_ue` `[n_gauges]`, µε.
    pub fn add_strain_ue(
        &self,
        point: &SurfacePoint,
        force_n: &Vector3<f64>,
        strain_ue: &mut [f64],
    ) {
        let face = self.surface.faces[point.face as usize];
        for (node, weight) in face.into_iter().zip(weights(point)) {
            let start = node as usize * self.n_gauges;
            let columns = &self.columns_ue_per_n[start..start + self.n_gauges];
            for (sum, column) in strain_ue.iter_mut().zip(columns) {
                *sum += weight * column.dot(force_n);
            }
        }
    }

    /// Largest reading of each gauge under a normal press of `force_n` at any node, beside loads of two standard
    /// deviations, µε.
    #[must_use]
    pub fn largest_ue(&self, force_n: f64) -> Vec<f64> {
        let at = |gauge: usize| {
            let columns = self.columns_ue_per_n.iter().skip(gauge);
            let readings = columns.step_by(self.n_gauges).zip(&self.surface.inward);
            readings.fold(0.0_f64, |m, (c, d)| m.max((c.dot(d) * force_n).abs()))
        };
        let loads = self.loads.largest_ue(self.n_gauges);
        loads.into_iter().enumerate().map(|(gauge, of_loads)| at(gauge) + of_loads).collect()
    }

    fn weighted(
        &self,
        point: &SurfacePoint,
        value: impl Fn(usize) -> Vector3<f64>,
    ) -> Vector3<f64> {
        let face = self.surface.faces[point.face as usize];
        let terms = face.into_iter().zip(weights(point));
        terms.map(|(node, w)| value(node as usize) * w).sum()
    }

    /// Squared distance to the flat parts of a face, and where on it.
    fn nearest_on(&self, face: u32, position_m: &Point3<f64>) -> (f64, [f64; 3]) {
        let nodes = self.surface.faces[face as usize];
        let mut best = (f64::INFINITY, [1.0, 0.0, 0.0]);
        for part in PARTS {
            let corners = part.map(|k| self.surface.nodes[nodes[k] as usize]);
            let w = closest_weights(&corners, position_m);
            let at = Vector3::from_fn(|i, _| (0..3).map(|k| w[k] * corners[k][i]).sum());
            let distance_2 = (at - position_m.coords).norm_squared();
            if distance_2 < best.0 {
                let on = |axis: usize| -> f64 {
                    let local = part.map(|k| tri6::NODE_COORDINATES[k][axis]);
                    (0..3).map(|k| w[k] * local[k]).sum()
                };
                let (xi, eta) = (on(0), on(1));
                best = (distance_2, [1.0 - xi - eta, xi, eta]);
            }
        }
        best
    }
}

fn weights(point: &SurfacePoint) -> [f64; 6] {
    tri6::shape(point.bary[1], point.bary[2])
}

fn check(surface: &LiveSurface, n_gauges: usize, columns: &[Vector3<f64>]) -> Result<(), RigError> {
    let n = surface.nodes.len();
    let is_there = |face: &[u32; 6]| face.iter().all(|node| (*node as usize) < n);
    let finite = |values: &[Vector3<f64>]| values.iter().all(|v| v.iter().all(|c| c.is_finite()));
    let positions = surface.nodes.iter();
    let what = if surface.faces.is_empty() || n_gauges == 0 {
        "it has no faces or no gauges"
    } else if !surface.faces.iter().all(is_there) {
        "a face has a node that is not there"
    } else if surface.inward.len() != n || columns.len() != n * n_gauges {
        "it has not one direction and one column of gauges for each node"
    } else if !finite(&surface.inward) || !finite(columns) {
        "a direction or a column is not finite"
    } else if !positions.flat_map(|x| x.iter()).all(|c| c.is_finite()) {
        "a node's position is not finite"
    } else {
        return Ok(());
    };
    Err(RigError::Surface { what })
}

fn faces_at_nodes(surface: &LiveSurface) -> (Vec<u32>, Vec<u32>) {
    let mut at = vec![Vec::new(); surface.nodes.len()];
    for (face, nodes) in (0..).zip(&surface.faces) {
        nodes.iter().for_each(|n| at[*n as usize].push(face));
    }
    let mut starts = vec![0];
    for faces in &at {
        starts.push(starts[starts.len() - 1] + faces.len() as u32);
    }
    (starts, at.concat())
}
