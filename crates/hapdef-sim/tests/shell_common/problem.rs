//! A shell problem in the degrees of freedom that benchmarks are stated in.

use super::grid::Grid;
use hapdef_mesh::FeNodeId;
use hapdef_sim::{
    ElasticModel, HeldMotion, Hold, IsotropicMaterial, NodalLoad, ShellKind, ShellMesh,
    ShellParams, SymmetryPlane,
};
use nalgebra::{Point3, Vector3};

/// Nodes, supports and loads; degrees of freedom 0..3 are displacements, 3..6 rotations.
pub struct Problem {
    nodes: Vec<Point3<f64>>,
    triangles: Vec<[FeNodeId; 3]>,
    thickness_m: f64,
    params: ShellParams,
    load: NodalLoad,
    traction_pa: Vector3<f64>,
}

pub struct Solution {
    pub displacement: Vec<Vector3<f64>>,
    /// Half the work of the load, J.
    pub energy_j: f64,
    pub n_nodes: usize,
}

fn ids(nodes: &[usize]) -> Vec<FeNodeId> {
    nodes.iter().map(|&n| FeNodeId::from_index(n)).collect()
}

impl Problem {
    pub fn new(grid: &Grid, thickness_m: f64, youngs_modulus_pa: f64, poissons_ratio: f64) -> Self {
        let material = IsotropicMaterial::new(youngs_modulus_pa, poissons_ratio, 1.0).unwrap();
        let triangles = grid.triangles.iter();
        Self {
            nodes: grid.nodes.clone(),
            triangles: triangles.map(|t| t.map(FeNodeId::from_index)).collect(),
            thickness_m,
            params: ShellParams::new(material, Vec::new()),
            load: NodalLoad::default(),
            traction_pa: Vector3::zeros(),
        }
    }

    pub fn fix(&mut self, nodes: &[usize], dofs: &[usize]) {
        for &dof in dofs {
            self.params.supports.holds.push(Hold {
                nodes: ids(nodes),
                motion: if dof < 3 {
                    HeldMotion::Translation
                } else {
                    HeldMotion::Rotation
                },
                direction: Vector3::ith(dof % 3, 1.0),
            });
        }
    }

    pub fn clamp(&mut self, nodes: &[usize]) {
        self.params.clamped.extend(ids(nodes));
    }

    /// The nodes lie in a mirror plane across the axis.
    pub fn mirror(&mut self, nodes: &[usize], axis: usize) {
        self.params.supports.symmetry.push(SymmetryPlane {
            nodes: ids(nodes),
            normal: Vector3::ith(axis, 1.0),
        });
    }

    pub fn force(&mut self, node: usize, dof: usize, value: f64) {
        let force = Vector3::ith(dof, value);
        self.load.forces_n.push((FeNodeId::from_index(node), force));
    }

    /// A total force over a line of nodes, uniform along it.
    pub fn line_force(&mut self, line: &[usize], dof: usize, total: f64) {
        let length = |w: &[usize]| (self.nodes[w[0]] - self.nodes[w[1]]).norm();
        let all: f64 = line.windows(2).map(length).sum();
        for w in line.windows(2) {
            let part = 0.5 * total * (self.nodes[w[0]] - self.nodes[w[1]]).norm() / all;
            self.force(w[0], dof, part);
            self.force(w[1], dof, part);
        }
    }

    /// A force per area of the mid-surface.
    pub fn area_force(&mut self, traction_pa: Vector3<f64>) {
        self.traction_pa = traction_pa;
    }

    pub fn solve(mut self, kind: ShellKind) -> Solution {
        self.params.kind = kind;
        let n_nodes = self.nodes.len();
        let thickness = vec![self.thickness_m; n_nodes];
        let mesh = ShellMesh::new(self.nodes, self.triangles, thickness).unwrap();
        let mesh = mesh.cut_at(&self.params.supports.symmetry).unwrap();
        let all: Vec<usize> = (0..mesh.triangles().len()).collect();
        let traction = mesh.traction_load(&all, &self.traction_pa).unwrap();
        let load = self.load.plus(&traction);
        let model = ElasticModel::build_shell(&mesh, &self.params).unwrap();
        let (displacement, _) = model.solve(&load).unwrap();
        Solution {
            energy_j: 0.5 * load.work_j(&displacement).unwrap(),
            displacement,
            n_nodes,
        }
    }
}
