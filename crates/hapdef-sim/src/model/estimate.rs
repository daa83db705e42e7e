//! What a factorisation would take, from the structure of the stiffness alone.

use hapdef_mesh::Tet10Mesh;

use crate::elements::element_set::SolidElements;
use crate::model::elastic_model::thread_pool;
use crate::model::structure::{FactorInfo, Structure};
use crate::{ElasticModel, ElasticParams, SimError};

impl ElasticModel {
    /// Sizes and operations of what [`Self::build`] would make of the same mesh and parameters. The stiffness is ordered and
    /// its fill counted; nothing is assembled, factored or solved, and no time is measured.
    ///
    /// # Errors
    /// As [`Self::build`] before any factoring.
    pub fn estimate(mesh: &Tet10Mesh, params: &ElasticParams) -> Result<FactorInfo, SimError> {
        let scale = params.element_stiffness_scale.as_deref();
        let elements = SolidElements::new(mesh, &params.material, &params.regions, scale)?;
        let (clamped, supports) = (&params.clamped, &params.supports);
        let structure = thread_pool(params.n_threads)?
            .install(|| Structure::build(&elements, clamped, supports, params.solver))?;
        Ok(structure.info(0.0, 0.0, 0.0))
    }
}
