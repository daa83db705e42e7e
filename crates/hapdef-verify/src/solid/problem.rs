//! A solid statics problem from mesh to value.

use hapdef_mesh::{FeNodeId, Tet10Mesh, Tri6Face, face_positions, tri6};
use hapdef_sim::{
    ElasticModel, ElasticParams, HeldMotion, Hold, IsotropicMaterial, NodalLoad, Supports,
    patch_stress,
};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::meshes::nodes_where;
use crate::{Measured, VerifyError};

/// A mesh, its material and what holds it.
pub(crate) struct Problem {
    /// The mesh.
    pub(crate) mesh: Tet10Mesh,
    /// The material, in the case's own units.
    pub(crate) material: IsotropicMaterial,
    clamped: Vec<FeNodeId>,
    holds: Vec<Hold>,
}

/// Displacements of a problem.
pub(crate) struct Solution<'a> {
    problem: &'a Problem,
    /// Displacement per node.
    pub(crate) u: Vec<Vector3<f64>>,
    /// The factored model.
    pub(crate) model: ElasticModel,
}

impl Problem {
    /// A problem with modulus `e` and Poisson's ratio `nu`, held nowhere yet.
    pub(crate) fn new(mesh: Tet10Mesh, e: f64, nu: f64) -> Result<Self, VerifyError> {
        Ok(Self {
            mesh,
            material: IsotropicMaterial::new(e, nu, 1.0)?,
            clamped: Vec::new(),
            holds: Vec::new(),
        })
    }

    /// Holds the nodes where `take` in all directions.
    pub(crate) fn clamp(mut self, take: impl Fn(&Point3<f64>) -> bool) -> Self {
        self.clamped.extend(nodes_where(&self.mesh, take));
        self
    }

    /// Holds the nodes where `take` along axis 0, 1 or 2.
    pub(crate) fn hold(self, axis: usize, take: impl Fn(&Point3<f64>) -> bool) -> Self {
        let nodes = nodes_where(&self.mesh, take);
        self.hold_nodes(axis, nodes)
    }

    /// Holds `nodes` along axis 0, 1 or 2.
    pub(crate) fn hold_nodes(mut self, axis: usize, nodes: Vec<FeNodeId>) -> Self {
        let mut direction = Vector3::zeros();
        direction[axis] = 1.0;
        self.holds.push(Hold { nodes, motion: HeldMotion::Translation, direction });
        self
    }

    /// The displacements under `load`.
    pub(crate) fn solve(&self, load: &NodalLoad) -> Result<Solution<'_>, VerifyError> {
        let params = ElasticParams {
            supports: Supports { holds: self.holds.clone(), ..Supports::default() },
            n_threads: std::thread::available_parallelism().map_or(1, usize::from),
            ..ElasticParams::new(self.material, self.clamped.clone())
        };
        let model = ElasticModel::build(&self.mesh, &params)?;
        let (u, _) = model.solve(load)?;
        Ok(Solution { problem: self, u, model })
    }

    /// The load of a traction that depends on place and outward unit normal: fᵢ = ∫ Nᵢ t dA.
    pub(crate) fn traction(
        &self,
        faces: &[Tri6Face],
        traction: impl Fn(&Point3<f64>, &Vector3<f64>) -> Vector3<f64>,
    ) -> NodalLoad {
        let mut load = NodalLoad::default();
        for face in faces {
            let nodes = face_positions(&self.mesh, face);
            for q in tri6::QUADRATURE {
                let area = tri6::area_vector(&nodes, q.xi, q.eta);
                let force = traction(&tri6::position(&nodes, q.xi, q.eta), &(area / area.norm()))
                    * (area.norm() * q.weight);
                let shares = face.nodes.iter().zip(tri6::shape(q.xi, q.eta));
                load.forces_n.extend(shares.map(|(&node, n)| (node, force * n)));
            }
        }
        load
    }
}

impl Solution<'_> {
    /// The node at `point`.
    pub(crate) fn node(&self, point: [f64; 3]) -> Result<FeNodeId, VerifyError> {
        let point = Point3::from(point);
        let close = nodes_where(&self.problem.mesh, |p| (p - point).norm() < 1e-6);
        close.first().copied().ok_or_else(|| VerifyError::Setup {
            what: "the place where the value is read",
            expected: format!("a node at {point}"),
            found: "none within 1e-6".to_owned(),
        })
    }

    /// The displacement of the node at `point`.
    pub(crate) fn displacement(&self, point: [f64; 3]) -> Result<Vector3<f64>, VerifyError> {
        Ok(self.u[self.node(point)?.index()])
    }

    /// The recovered stress at the node at `point`.
    pub(crate) fn stress(&self, point: [f64; 3]) -> Result<Matrix3<f64>, VerifyError> {
        self.stress_beside(point, |_| Matrix3::zeros())
    }

    /// The recovered stress of the strain beside `initial`, at the node at `point`.
    pub(crate) fn stress_beside(
        &self,
        point: [f64; 3],
        initial: impl Fn(&Point3<f64>) -> Matrix3<f64>,
    ) -> Result<Matrix3<f64>, VerifyError> {
        let node = self.node(point)?;
        let problem = self.problem;
        let all = patch_stress(&problem.mesh, &problem.material, &self.u, initial)?;
        Ok(all[node.index()])
    }

    /// `value` with the sizes of this solution.
    pub(crate) fn measured(&self, value: f64, mesh: String, h: f64) -> Measured {
        Measured {
            value,
            mesh,
            n_nodes: self.problem.mesh.nodes().len(),
            n_equations: self.model.info().n_equations,
            h,
        }
    }
}

/// `n` cells in words.
pub(crate) fn cells(n: [usize; 3]) -> String {
    format!("{} × {} × {} cells", n[0], n[1], n[2])
}

/// Whether two numbers are the same but for round-off.
pub(crate) fn same(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9 * (1.0 + b.abs())
}
