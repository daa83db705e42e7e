//! A shell problem, solved by a sparse factorisation of its free degrees of freedom.

use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use hapdef_sim::{IsotropicMaterial, ShellKind, shell_stiffness};
use nalgebra::{Point3, Vector3};

use super::grid::Grid;

/// Degrees of freedom of a node: displacement (m) and rotation (rad).
pub type Nodal = [f64; 6];

pub struct Problem {
    pub nodes: Vec<Point3<f64>>,
    pub triangles: Vec<[usize; 3]>,
    pub thickness_m: f64,
    pub material: IsotropicMaterial,
    fixed: Vec<[bool; 6]>,
    symmetric: Vec<[bool; 3]>,
    load: Vec<Nodal>,
}

pub struct Solution {
    pub values: Vec<Nodal>,
    /// Half the work of the load, J.
    pub energy_j: f64,
}

impl Problem {
    pub fn new(grid: &Grid, thickness_m: f64, youngs_modulus_pa: f64, poissons_ratio: f64) -> Self {
        let n = grid.nodes.len();
        Self {
            nodes: grid.nodes.clone(),
            triangles: grid.triangles.clone(),
            thickness_m,
            material: IsotropicMaterial::new(youngs_modulus_pa, poissons_ratio, 1.0).unwrap(),
            fixed: vec![[false; 6]; n],
            symmetric: vec![[false; 3]; n],
            load: vec![[0.0; 6]; n],
        }
    }

    pub fn fix(&mut self, nodes: &[usize], dofs: &[usize]) {
        for &node in nodes {
            for &dof in dofs {
                self.fixed[node][dof] = true;
            }
        }
    }

    pub fn clamp(&mut self, nodes: &[usize]) {
        self.fix(nodes, &[0, 1, 2, 3, 4, 5]);
    }

    /// The nodes lie in a mirror plane across the axis.
    pub fn mirror(&mut self, nodes: &[usize], axis: usize) {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        self.fix(nodes, &[axis, 3 + b, 3 + c]);
        for &node in nodes {
            self.symmetric[node][axis] = true;
        }
    }

    pub fn force(&mut self, node: usize, dof: usize, value: f64) {
        self.load[node][dof] += value;
    }

    /// A total force over a line of nodes, uniform along it.
    pub fn line_force(&mut self, line: &[usize], dof: usize, total: f64) {
        let length = |a: usize, b: usize| (self.nodes[a] - self.nodes[b]).norm();
        let all: f64 = line.windows(2).map(|w| length(w[0], w[1])).sum();
        let parts: Vec<f64> = line
            .windows(2)
            .map(|w| total * length(w[0], w[1]) / all)
            .collect();
        for (w, part) in line.windows(2).zip(parts) {
            self.force(w[0], dof, 0.5 * part);
            self.force(w[1], dof, 0.5 * part);
        }
    }

    /// A force per area of the mid-surface.
    pub fn area_force(&mut self, traction_pa: Vector3<f64>) {
        for i in 0..self.triangles.len() {
            let t = self.triangles[i];
            let p = t.map(|n| self.nodes[n]);
            let forces = hapdef_sim::shell_traction_load(&p, &[traction_pa; 3]);
            for (node, force) in t.iter().zip(forces) {
                for c in 0..3 {
                    self.load[*node][c] += force[c];
                }
            }
        }
    }

    /// Angle-weighted normals, in the mirror planes where there are any.
    pub fn directors(&self) -> Vec<Vector3<f64>> {
        let mut sum = vec![Vector3::zeros(); self.nodes.len()];
        for t in &self.triangles {
            for k in 0..3 {
                let [a, b, c] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
                let (p, q) = (self.nodes[b] - self.nodes[a], self.nodes[c] - self.nodes[a]);
                let normal = p.cross(&q);
                sum[a] += normal / normal.norm() * p.angle(&q);
            }
        }
        for (sum, mirror) in sum.iter_mut().zip(&self.symmetric) {
            for c in 0..3 {
                if mirror[c] {
                    sum[c] = 0.0;
                }
            }
            *sum /= sum.norm();
        }
        sum
    }

    pub fn solve(&self, kind: ShellKind) -> Solution {
        let (index, n_free) = self.numbering();
        let directors = self.directors();
        let mut triplets = Vec::new();
        for t in &self.triangles {
            let k = shell_stiffness(
                kind,
                &t.map(|n| self.nodes[n]),
                Some(&t.map(|n| directors[n])),
                &[self.thickness_m; 3],
                &self.material,
            )
            .unwrap();
            let dof = |i: usize| index[6 * t[i / 6] + i % 6];
            for i in 0..18 {
                for j in 0..18 {
                    if let (Some(r), Some(c)) = (dof(i), dof(j)) {
                        if r >= c {
                            triplets.push(Triplet::new(r, c, k[i][j]));
                        }
                    }
                }
            }
        }
        let a =
            SparseColMat::<usize, f64>::try_new_from_triplets(n_free, n_free, &triplets).unwrap();
        let mut rhs = faer::Mat::<f64>::zeros(n_free, 1);
        for (i, dof) in index.iter().enumerate() {
            if let Some(dof) = dof {
                rhs[(*dof, 0)] = self.load[i / 6][i % 6];
            }
        }
        let x = a.sp_cholesky(faer::Side::Lower).unwrap().solve(&rhs);
        let mut values = vec![[0.0; 6]; self.nodes.len()];
        let mut energy_j = 0.0;
        for (i, dof) in index.iter().enumerate() {
            if let Some(dof) = dof {
                values[i / 6][i % 6] = x[(*dof, 0)];
                energy_j += 0.5 * x[(*dof, 0)] * rhs[(*dof, 0)];
            }
        }
        Solution { values, energy_j }
    }

    fn numbering(&self) -> (Vec<Option<usize>>, usize) {
        let mut n_free = 0;
        let index = self
            .fixed
            .iter()
            .flatten()
            .map(|&fixed| {
                (!fixed).then(|| {
                    n_free += 1;
                    n_free - 1
                })
            })
            .collect();
        (index, n_free)
    }
}
