//! The factored elastic model of a limb.

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use hapdef_mesh::{FeNodeId, Tet10Mesh};
use nalgebra::Vector3;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::elements::element_set::{Elements, SolidElements};
use crate::iterative::{Solver, SolverChoice, SolverInfo};
use crate::model::structure::{FactorInfo, Structure};
use crate::system::assembly::{Assembled, BlockMatrix, StiffnessExtremes, assemble};
use crate::{IsotropicMaterial, MaterialRegion, SimError, Supports};

/// What a solid elastic model is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct ElasticParams {
    /// The material of all elements that no region names.
    pub material: IsotropicMaterial,
    /// Elements of other materials.
    pub regions: Vec<MaterialRegion>,
    /// A factor on Young's modulus per element `[n_elements]`; none means 1 everywhere.
    pub element_stiffness_scale: Option<Vec<f64>>,
    /// Nodes held at zero in all directions; repeats are allowed.
    pub clamped: Vec<FeNodeId>,
    /// Symmetry planes, Winkler foundations, rigid bodies.
    pub supports: Supports,
    /// How its systems are solved.
    pub solver: SolverChoice,
    /// Worker threads, at least 1. Results do not depend on it, bit for bit.
    pub n_threads: usize,
}

impl ElasticParams {
    /// One material, clamped nodes, one thread, the solver by its fill, nothing else.
    #[must_use]
    pub fn new(material: IsotropicMaterial, clamped: Vec<FeNodeId>) -> Self {
        Self {
            material,
            regions: Vec::new(),
            element_stiffness_scale: None,
            clamped,
            supports: Supports::default(),
            solver: SolverChoice::default(),
            n_threads: 1,
        }
    }
}

/// A limb's stiffness, assembled, ordered and factored: displacements for any load.
#[derive(Debug)]
pub struct ElasticModel {
    pub(crate) structure: Arc<Structure>,
    pub(crate) stiffness: BlockMatrix,
    pub(crate) solver: Solver,
    /// ‖K̂‖∞ of the Jacobi-scaled stiffness.
    pub(crate) scaled_norm: f64,
    /// The rounding of the stiffness, as a share of [`Self::scaled_norm`].
    pub(crate) rounding: f64,
    pub(crate) pool: Arc<ThreadPool>,
    pub(crate) condition: OnceLock<f64>,
    info: FactorInfo,
    solver_info: SolverInfo,
    extremes: StiffnessExtremes,
}

impl ElasticModel {
    /// Assembles, orders and factors the stiffness of `mesh`.
    ///
    /// # Errors
    /// [`SimError::NodeOutOfRange`], [`SimError::ElementOutOfRange`], [`SimError::Length`],
    /// [`SimError::StiffnessScale`], [`SimError::Direction`] and [`SimError::Parameter`] on unusable
    /// parameters; [`SimError::FreeRigidModes`], [`SimError::AllClamped`],
    /// [`SimError::RigidBodyHeld`], [`SimError::RigidBodiesShareNode`] and [`SimError::RigidBodyTooSmall`] on
    /// unusable supports, before any factoring; [`SimError::ElementInverted`] and
    /// [`SimError::NotPositiveDefinite`] and [`SimError::Singular`] on a bad mesh; [`SimError::TooLarge`] and
    /// [`SimError::Threads`] on lack of resources.
    pub fn build(mesh: &Tet10Mesh, params: &ElasticParams) -> Result<Self, SimError> {
        let scale = params.element_stiffness_scale.as_deref();
        let elements = SolidElements::new(mesh, &params.material, &params.regions, scale)?;
        let pool = thread_pool(params.n_threads)?;
        let started = Instant::now();
        let structure = Structure {
            regions: params.regions.clone(),
            ..pool.install(|| {
                let (clamped, supports) = (&params.clamped, &params.supports);
                Structure::build(&elements, clamped, supports, params.solver)
            })?
        };
        let order_s = started.elapsed().as_secs_f64();
        Self::fill(&elements, Arc::new(structure), pool, order_s)
    }

    /// The model of the same mesh and supports with another material or other stiffness scales;
    /// material regions keep theirs, ordering and analysis are reused.
    ///
    /// # Errors
    /// As [`Self::build`], and [`SimError::OtherMesh`] or [`SimError::Length`] if `mesh` is not
    /// connected as the one this model was built for.
    pub fn with_stiffness(
        &self,
        mesh: &Tet10Mesh,
        material: &IsotropicMaterial,
        element_stiffness_scale: Option<&[f64]>,
    ) -> Result<Self, SimError> {
        let expect = |what, expected, found| {
            if expected == found { Ok(()) } else { Err(SimError::Length { what, expected, found }) }
        };
        expect("the mesh's node list", self.structure.unknowns.n_fe_nodes(), mesh.nodes().len())?;
        expect("the mesh's element list", self.structure.n_elements, mesh.elements().len())?;
        let (structure, pool) = (Arc::clone(&self.structure), Arc::clone(&self.pool));
        let scale = element_stiffness_scale;
        let elements = SolidElements::new(mesh, material, &structure.regions, scale)?;
        Self::fill(&elements, Arc::clone(&structure), pool, 0.0)
    }

    pub(crate) fn fill(
        elements: &dyn Elements,
        structure: Arc<Structure>,
        pool: Arc<ThreadPool>,
        order_s: f64,
    ) -> Result<Self, SimError> {
        let started = Instant::now();
        let (pattern, unknowns) = (Arc::clone(&structure.pattern), &structure.unknowns);
        let springs = &structure.springs;
        let Assembled { matrix: stiffness, extremes, rigid_force } =
            pool.install(|| assemble(elements, springs, unknowns, pattern))?;
        let assemble_s = started.elapsed().as_secs_f64();
        let started = Instant::now();
        let solver = pool.install(|| structure.plan.solver(&stiffness, unknowns))?;
        let factor_s = started.elapsed().as_secs_f64();
        let info = structure.info(order_s, assemble_s, factor_s);
        let scaled_norm = stiffness.scaled_norm(solver.scale());
        Ok(Self {
            solver_info: structure.plan.info(&solver),
            structure,
            stiffness,
            solver,
            scaled_norm,
            rounding: f64::EPSILON + rigid_force / scaled_norm,
            pool,
            condition: OnceLock::new(),
            info,
            extremes,
        })
    }

    /// Which solver the model has, and why.
    #[must_use]
    pub fn solver_info(&self) -> &SolverInfo {
        &self.solver_info
    }

    /// Sizes and times of the build.
    #[must_use]
    pub fn info(&self) -> &FactorInfo {
        &self.info
    }

    /// The largest and smallest element-stiffness coefficient, with their elements.
    #[must_use]
    pub fn stiffness_extremes(&self) -> &StiffnessExtremes {
        &self.extremes
    }

    /// The strain energy ½ uᵀ K u of displacements `[n_fe_nodes]`, m, in J, Winkler foundations included;
    /// what is held counts as zero. For solids without rigid bodies; elsewhere half the work of
    /// the load is the energy.
    ///
    /// # Errors
    /// [`SimError::Length`]; [`SimError::NeedsRotations`] where displacements alone do not fix the
    /// deformation.
    pub fn strain_energy_j(&self, displacement: &[Vector3<f64>]) -> Result<f64, SimError> {
        let unknowns = &self.structure.unknowns;
        if displacement.len() != unknowns.n_fe_nodes() {
            return Err(SimError::Length {
                what: "the displacement field",
                expected: unknowns.n_fe_nodes(),
                found: displacement.len(),
            });
        }
        if unknowns.owners().iter().any(|owner| owner.is_rotation) {
            return Err(SimError::NeedsRotations);
        }
        let u: Vec<f64> = unknowns
            .owners()
            .iter()
            .flat_map(|owner| {
                let u = displacement[owner.node.index()];
                <[f64; 3]>::from(unknowns.translation(owner.node).motion(|_| u))
            })
            .collect();
        let mut ku = vec![0.0; u.len()];
        self.stiffness.multiply_add(1.0, &u, 1, &mut ku);
        Ok(0.5 * u.iter().zip(&ku).map(|(u, f)| u * f).sum::<f64>())
    }
}

pub(crate) fn thread_pool(n_threads: usize) -> Result<Arc<ThreadPool>, SimError> {
    if n_threads == 0 {
        return Err(SimError::Parameter { what: "n_threads", value: 0.0, expected: "at least 1" });
    }
    ThreadPoolBuilder::new()
        .num_threads(n_threads)
        .build()
        .map(Arc::new)
        .map_err(|source| SimError::Threads { n_threads, source })
}
