//! What a factorisation would take, from the structure of the stiffness alone.

use hapdef_mesh::Tet10Mesh;

use crate::elements::element_set::{Elements, SolidElements};
use crate::iterative::SolverKind;
use crate::model::elastic_model::thread_pool;
use crate::model::structure::Structure;
use crate::{ElasticModel, ElasticParams, SimError};

/// Sizes and work of a model that has not been built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FactorEstimate {
    /// Nodes of the mesh, clamped ones included.
    pub n_fe_nodes: usize,
    /// Its elements.
    pub n_elements: usize,
    /// Equations: three per unknown motion.
    pub n_equations: usize,
    /// The solver that the model would get.
    pub solver: SolverKind,
    /// Non-zeros of the Cholesky factor L; 0 on the iterative path.
    pub nnz_l: usize,
    /// Operations of the numeric factorisation, Σ c² over the c entries of every column of L as
    /// stored (A. George and J. Liu, Computer Solution of Large Sparse Positive Definite Systems,
    /// 1981, section 2.2); 0 on the iterative path.
    pub factor_flops: f64,
}

impl ElasticModel {
    /// What [`Self::build`] would make of the same mesh and parameters. The stiffness is ordered and
    /// its fill counted; nothing is assembled, factored or solved.
    ///
    /// # Errors
    /// As [`Self::build`] before any factoring.
    pub fn estimate(mesh: &Tet10Mesh, params: &ElasticParams) -> Result<FactorEstimate, SimError> {
        let scale = params.element_stiffness_scale.as_deref();
        let elements = SolidElements::new(mesh, &params.material, &params.regions, scale)?;
        let (clamped, supports) = (&params.clamped, &params.supports);
        let structure = thread_pool(params.n_threads)?
            .install(|| Structure::build(&elements, clamped, supports, params.solver))?;
        let info = structure.info(0.0, 0.0, 0.0);
        let factor_flops = structure.plan.factor_flops();
        Ok(FactorEstimate {
            n_fe_nodes: info.n_fe_nodes,
            n_elements: elements.n_elements(),
            n_equations: info.n_equations,
            solver: if factor_flops > 0.0 { SolverKind::Direct } else { SolverKind::Iterative },
            nnz_l: info.nnz_l,
            factor_flops,
        })
    }
}
