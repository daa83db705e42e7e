//! A statics problem from mesh to value; degrees of freedom 0..3 are displacements, 3..6 rotations.

use hapdef_mesh::{FeNodeId, face_positions, tri6};
use hapdef_sim::{
    ElasticModel, ElasticParams, HeldMotion, Hold, IsotropicMaterial, Motion, NodalLoad,
    ShellParams, Supports, SymmetryPlane, patch_stress,
};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::meshes::{Body, BodyMesh, Place};
use crate::{Element, Measured, VerifyError};

/// A meshed body, its material and what holds it.
pub(crate) struct Problem {
    pub(crate) body: Body,
    pub(crate) element: Element,
    /// In the case's own units.
    pub(crate) material: IsotropicMaterial,
    clamped: Vec<FeNodeId>,
    supports: Supports,
}

/// What is held of some nodes.
#[derive(Clone, Copy)]
pub(crate) enum Held {
    /// All of their motion.
    All,
    /// Displacements along axes 0..3, rotations about them as 3..6.
    Only(&'static [usize]),
    /// They lie in a mirror plane across the axis.
    Mirror(usize),
}

/// The motion of a problem's nodes.
pub(crate) struct Solution {
    pub(crate) problem: Problem,
    pub(crate) load: NodalLoad,
    pub(crate) motion: Motion,
    n_equations: usize,
}

/// Adds a force (`dof` below 3) or moment on a node.
pub(crate) fn push(load: &mut NodalLoad, node: FeNodeId, dof: usize, value: f64) {
    let entries = if dof < 3 { &mut load.forces_n } else { &mut load.moments_nm };
    entries.push((node, Vector3::ith(dof % 3, value)));
}

/// Whether two numbers are the same but for round-off.
pub(crate) fn same(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9 * (1.0 + b.abs())
}

/// All cores.
pub(crate) fn n_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

impl Problem {
    /// A body with Young's modulus and Poisson's ratio, held nowhere yet.
    pub(crate) fn new(
        element: Element,
        body: Body,
        [e, nu]: [f64; 2],
    ) -> Result<Self, VerifyError> {
        let material = IsotropicMaterial::new(e, nu, 1.0)?;
        Ok(Self { body, element, material, clamped: Vec::new(), supports: Supports::default() })
    }

    pub(crate) fn is_shell(&self) -> bool {
        matches!(self.body.mesh, BodyMesh::Shell(_))
    }

    /// Holds the nodes where `on`.
    pub(crate) fn hold(&mut self, held: Held, on: impl Fn(&Point3<f64>) -> bool) {
        let nodes = self.body.nodes_where(on);
        match held {
            Held::All => self.clamped.extend(nodes),
            Held::Only(dofs) => dofs.iter().for_each(|&dof| self.fix(nodes.clone(), dof)),
            Held::Mirror(axis) if self.is_shell() => {
                let plane = SymmetryPlane { nodes, normal: Vector3::ith(axis, 1.0) };
                self.supports.symmetry.push(plane);
            }
            Held::Mirror(axis) => self.fix(nodes, axis),
        }
    }

    /// Holds a degree of freedom of nodes.
    pub(crate) fn fix(&mut self, nodes: Vec<FeNodeId>, dof: usize) {
        let motion = if dof < 3 { HeldMotion::Translation } else { HeldMotion::Rotation };
        self.supports.holds.push(Hold { nodes, motion, direction: Vector3::ith(dof % 3, 1.0) });
    }

    /// The load of a traction on a solid's faces where `on`, which depends on place and outward unit
    /// normal: fᵢ = ∫ Nᵢ t dA.
    pub(crate) fn traction(
        &self,
        on: impl Fn(&Point3<f64>) -> bool,
        traction: impl Fn(&Point3<f64>, &Vector3<f64>) -> Vector3<f64>,
    ) -> Result<NodalLoad, VerifyError> {
        let mesh = self.body.tets()?;
        let mut load = NodalLoad::default();
        for face in &mesh.faces_where(on) {
            let nodes = face_positions(mesh, face);
            for q in tri6::QUADRATURE {
                let area = tri6::area_vector(&nodes, q.xi, q.eta);
                let force = traction(&tri6::position(&nodes, q.xi, q.eta), &(area / area.norm()))
                    * (area.norm() * q.weight);
                let shares = face.nodes.iter().zip(tri6::shape(q.xi, q.eta));
                load.forces_n.extend(shares.map(|(&node, n)| (node, force * n)));
            }
        }
        Ok(load)
    }

    /// A total force or moment over nodes of a straight line, uniform along it.
    pub(crate) fn line_load(&self, nodes: &[FeNodeId], dof: usize, total: f64) -> NodalLoad {
        let at = |node: FeNodeId| self.body.nodes()[node.index()];
        let sorted_from = |end: FeNodeId| {
            let mut line = nodes.to_vec();
            line.sort_by(|&a, &b| (at(a) - at(end)).norm().total_cmp(&(at(b) - at(end)).norm()));
            line
        };
        let furthest = nodes.first().and_then(|&first| sorted_from(first).pop());
        let line = furthest.map(sorted_from).unwrap_or_default();
        let length = |w: &[FeNodeId]| (at(w[0]) - at(w[1])).norm();
        let all: f64 = line.windows(2).map(length).sum();
        let mut load = NodalLoad::default();
        for ends in line.windows(2) {
            for &node in ends {
                push(&mut load, node, dof, 0.5 * total * length(ends) / all);
            }
        }
        load
    }

    /// The motion of the nodes under `load`.
    pub(crate) fn solve(mut self, load: NodalLoad) -> Result<Solution, VerifyError> {
        let (material, clamped, n_threads) = (self.material, self.clamped.clone(), n_threads());
        let supports = self.supports.clone();
        let model = match &mut self.body.mesh {
            BodyMesh::Solid(mesh) => {
                let params = ElasticParams::new(material, clamped);
                ElasticModel::build(mesh, &ElasticParams { supports, n_threads, ..params })?
            }
            BodyMesh::Shell(mesh) => {
                *mesh = mesh.clone().cut_at(&supports.symmetry)?;
                let kind = self.element.shell_kind();
                let params = ShellParams::new(material, clamped);
                let params = ShellParams { kind, supports, n_threads, ..params };
                ElasticModel::build_shell(mesh, &params)?
            }
        };
        let (motion, _) = model.solve_motion(&load)?;
        let n_equations = model.info().n_equations;
        Ok(Solution { problem: self, load, motion, n_equations })
    }
}

impl Solution {
    /// The displacement of a node along an axis.
    pub(crate) fn u(&self, place: Place, axis: usize) -> Result<f64, VerifyError> {
        Ok(self.motion.displacement[self.problem.body.node(place)?.index()][axis])
    }

    /// The work of the load.
    pub(crate) fn work(&self) -> f64 {
        let along = |entries: &[(FeNodeId, Vector3<f64>)], motion: &[Vector3<f64>]| -> f64 {
            entries.iter().map(|(node, value)| value.dot(&motion[node.index()])).sum()
        };
        along(&self.load.forces_n, &self.motion.displacement)
            + along(&self.load.moments_nm, &self.motion.rotation)
    }

    /// The largest displacement.
    pub(crate) fn largest(&self) -> f64 {
        largest(&self.motion.displacement)
    }

    /// The recovered stress at the node of a solid at `point`, of the strain beside `initial`.
    pub(crate) fn stress(
        &self,
        point: [f64; 3],
        initial: impl Fn(&Point3<f64>) -> Matrix3<f64>,
    ) -> Result<Matrix3<f64>, VerifyError> {
        let Problem { body, material, .. } = &self.problem;
        let node = body.node(Place::At(point))?;
        let all = patch_stress(body.tets()?, material, &self.motion.displacement, initial)?;
        Ok(all[node.index()])
    }

    /// `value` with the sizes of this solution.
    pub(crate) fn measured(&self, value: f64) -> Measured {
        let body = &self.problem.body;
        Measured {
            value,
            mesh: body.words.clone(),
            n_nodes: body.nodes().len(),
            n_equations: self.n_equations,
            h: body.h,
        }
    }
}

/// The largest norm.
pub(crate) fn largest(displacement: &[Vector3<f64>]) -> f64 {
    displacement.iter().map(Vector3::norm).fold(0.0, f64::max)
}
