//! A shell statics problem from mesh to value; degrees of freedom 0..3 are displacements, 3..6
//! rotations.

use hapdef_mesh::FeNodeId;
use hapdef_sim::{
    ElasticModel, HeldMotion, Hold, IsotropicMaterial, Motion, NodalLoad, ShellKind, ShellMesh,
    ShellParams, SymmetryPlane,
};
use nalgebra::{Point3, Vector3};

use super::grid::Grid;
use crate::{Measured, VerifyError};

/// Nodes, supports and loads.
#[derive(Debug)]
pub(super) struct Problem {
    nodes: Vec<Point3<f64>>,
    triangles: Vec<[FeNodeId; 3]>,
    thickness: f64,
    params: ShellParams,
    load: NodalLoad,
    traction: Vector3<f64>,
    pressure: f64,
}

/// The motion of a problem's nodes.
#[derive(Debug)]
pub(super) struct Solution {
    pub(super) motion: Motion,
    /// Half the work of the load.
    pub(super) energy: f64,
    pub(super) mesh: ShellMesh,
    pub(super) kind: ShellKind,
    pub(super) material: IsotropicMaterial,
    n_equations: usize,
}

fn ids(nodes: &[usize]) -> Vec<FeNodeId> {
    nodes.iter().map(|&n| FeNodeId::from_index(n)).collect()
}

impl Problem {
    /// A shell of uniform thickness with modulus `e` and Poisson's ratio `nu`, held nowhere yet.
    pub(super) fn new(grid: &Grid, thickness: f64, e: f64, nu: f64) -> Result<Self, VerifyError> {
        let material = IsotropicMaterial::new(e, nu, 1.0)?;
        let triangles = grid.triangles.iter();
        Ok(Self {
            nodes: grid.nodes.clone(),
            triangles: triangles.map(|t| t.map(FeNodeId::from_index)).collect(),
            thickness,
            params: ShellParams {
                n_threads: std::thread::available_parallelism().map_or(1, usize::from),
                ..ShellParams::new(material, Vec::new())
            },
            load: NodalLoad::default(),
            traction: Vector3::zeros(),
            pressure: 0.0,
        })
    }

    /// Holds single degrees of freedom.
    pub(super) fn fix(&mut self, nodes: &[usize], dofs: &[usize]) {
        for &dof in dofs {
            self.params.supports.holds.push(Hold {
                nodes: ids(nodes),
                motion: if dof < 3 { HeldMotion::Translation } else { HeldMotion::Rotation },
                direction: Vector3::ith(dof % 3, 1.0),
            });
        }
    }

    /// Holds all six.
    pub(super) fn clamp(&mut self, nodes: &[usize]) {
        self.params.clamped.extend(ids(nodes));
    }

    /// The nodes lie in a mirror plane across the axis.
    pub(super) fn mirror(&mut self, nodes: &[usize], axis: usize) {
        self.params
            .supports
            .symmetry
            .push(SymmetryPlane { nodes: ids(nodes), normal: Vector3::ith(axis, 1.0) });
    }

    /// A force (`dof` below 3) or moment on one node.
    pub(super) fn force(&mut self, node: usize, dof: usize, value: f64) {
        let entry = (FeNodeId::from_index(node), Vector3::ith(dof % 3, value));
        if dof < 3 {
            self.load.forces_n.push(entry);
        } else {
            self.load.moments_nm.push(entry);
        }
    }

    /// A total force or moment over a line of nodes, uniform along it.
    pub(super) fn line_load(&mut self, line: &[usize], dof: usize, total: f64) {
        let length = |w: &[usize]| (self.nodes[w[0]] - self.nodes[w[1]]).norm();
        let all: f64 = line.windows(2).map(length).sum();
        let shares: Vec<f64> = line.windows(2).map(|w| 0.5 * total * length(w) / all).collect();
        for (w, share) in line.windows(2).zip(shares) {
            self.force(w[0], dof, share);
            self.force(w[1], dof, share);
        }
    }

    /// A force per area of the mid-surface.
    pub(super) fn area_force(&mut self, traction: Vector3<f64>) {
        self.traction = traction;
    }

    /// A pressure against the triangles' normals.
    pub(super) fn pressure(&mut self, pressure: f64) {
        self.pressure = pressure;
    }

    /// The motion of the nodes.
    pub(super) fn solve(mut self, kind: ShellKind) -> Result<Solution, VerifyError> {
        self.params.kind = kind;
        let thickness = vec![self.thickness; self.nodes.len()];
        let mesh = ShellMesh::new(self.nodes, self.triangles, thickness)?;
        let mesh = mesh.cut_at(&self.params.supports.symmetry)?;
        let all: Vec<usize> = (0..mesh.triangles().len()).collect();
        let load = self
            .load
            .plus(&mesh.traction_load(&all, &self.traction)?)
            .plus(&mesh.pressure_load(&all, self.pressure)?);
        let model = ElasticModel::build_shell(&mesh, &self.params)?;
        let (motion, _) = model.solve_motion(&load)?;
        let pushed = load.forces_n.iter();
        let pushed = pushed.map(|(node, force)| force.dot(&motion.displacement[node.index()]));
        let turned = load.moments_nm.iter();
        let turned = turned.map(|(node, moment)| moment.dot(&motion.rotation[node.index()]));
        Ok(Solution {
            energy: 0.5 * pushed.chain(turned).sum::<f64>(),
            motion,
            kind,
            material: self.params.material,
            n_equations: model.info().n_equations,
            mesh,
        })
    }
}

impl Solution {
    /// The displacement of a node along an axis.
    pub(super) fn u(&self, node: usize, axis: usize) -> f64 {
        self.motion.displacement[node][axis]
    }

    /// `value` with the sizes of this solution.
    pub(super) fn measured(&self, value: f64, mesh: String, h: f64) -> Measured {
        Measured { value, mesh, n_nodes: self.mesh.nodes().len(), n_equations: self.n_equations, h }
    }
}
