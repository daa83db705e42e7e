//! The elastic model of a shell.

use std::sync::Arc;
use std::time::Instant;

use hapdef_mesh::FeNodeId;
use nalgebra::Point3;

use super::{ShellKind, ShellMesh, shell_stiffness};
use crate::SolverChoice;
use crate::elements::element_set::Elements;
use crate::elements::parts::DisjointSets;
use crate::model::elastic_model::thread_pool;
use crate::model::structure::{FactorInfo, Structure};
use crate::{ElasticModel, IsotropicMaterial, SimError, Supports};

/// What an elastic shell model is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellParams {
    /// The bending theory.
    pub kind: ShellKind,
    /// The material of the wall.
    pub material: IsotropicMaterial,
    /// Nodes held at zero, displacement and rotation; repeats are allowed.
    pub clamped: Vec<FeNodeId>,
    /// Symmetry planes, Winkler foundations, rigid bodies, single motions.
    pub supports: Supports,
    /// Worker threads, at least 1. Results do not depend on it, bit for bit.
    pub n_threads: usize,
}

impl ShellParams {
    /// The default kind, clamped nodes, one thread, nothing else.
    #[must_use]
    pub fn new(material: IsotropicMaterial, clamped: Vec<FeNodeId>) -> Self {
        Self {
            kind: ShellKind::default(),
            material,
            clamped,
            supports: Supports::default(),
            n_threads: 1,
        }
    }
}

impl ElasticModel {
    /// Assembles, orders and factors the stiffness of a shell.
    ///
    /// Nodes have a displacement and a rotation: see [`ElasticModel::solve_motion`]. A mesh cut at
    /// symmetry planes wants [`ShellMesh::cut_at`] as well as the planes in the supports.
    ///
    /// # Errors
    /// As [`ElasticModel::build`], and [`SimError::ShellElement`] on an unusable triangle.
    pub fn build_shell(mesh: &ShellMesh, params: &ShellParams) -> Result<Self, SimError> {
        let elements = ShellElements { mesh, kind: params.kind, material: params.material };
        let pool = thread_pool(params.n_threads)?;
        let started = Instant::now();
        let structure = Structure::build(
            &elements,
            &params.clamped,
            &params.supports,
            SolverChoice::default(),
        )?;
        let order_s = started.elapsed().as_secs_f64();
        Self::fill(&elements, Arc::new(structure), pool, order_s)
    }

    /// Sizes and operations of what [`Self::build_shell`] would make; nothing is factored or solved.
    ///
    /// # Errors
    /// As [`Self::build_shell`] before any factoring.
    pub fn estimate_shell(mesh: &ShellMesh, params: &ShellParams) -> Result<FactorInfo, SimError> {
        let elements = ShellElements { mesh, kind: params.kind, material: params.material };
        let (clamped, supports) = (&params.clamped, &params.supports);
        let structure = thread_pool(params.n_threads)?
            .install(|| Structure::build(&elements, clamped, supports, SolverChoice::default()))?;
        Ok(structure.info(0.0, 0.0, 0.0))
    }
}

struct ShellElements<'a> {
    mesh: &'a ShellMesh,
    kind: ShellKind,
    material: IsotropicMaterial,
}

impl Elements for ShellElements<'_> {
    fn positions(&self) -> &[Point3<f64>] {
        self.mesh.nodes()
    }

    fn n_elements(&self) -> usize {
        self.mesh.triangles().len()
    }

    fn nodes(&self, element: usize) -> &[FeNodeId] {
        &self.mesh.triangles()[element]
    }

    fn has_rotations(&self) -> bool {
        true
    }

    /// A shared node shares its rotation too, so triangles that meet anywhere move together.
    fn rigid_parts(&self) -> Vec<usize> {
        let triangles = self.mesh.triangles();
        let mut first = vec![None; self.mesh.nodes().len()];
        let mut sets = DisjointSets::new(triangles.len());
        for (element, nodes) in triangles.iter().enumerate() {
            for node in nodes {
                match first[node.index()] {
                    Some(other) => sets.join(other, element),
                    None => first[node.index()] = Some(element),
                }
            }
        }
        sets.roots()
    }

    fn stiffness(&self, element: usize, k: &mut [f64]) -> Result<(), SimError> {
        let matrix = shell_stiffness(
            self.kind,
            &self.mesh.corners(element),
            Some(&self.mesh.directors()[element]),
            &self.mesh.corner_thickness_m(element),
            &self.material,
        )
        .map_err(|problem| SimError::ShellElement { element, problem })?;
        k.copy_from_slice(matrix.as_flattened());
        Ok(())
    }
}
