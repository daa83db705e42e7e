//! The factored elastic model of a limb.

use std::sync::Arc;
use std::time::Instant;

use hapdef_mesh::{FeNodeId, Tet10Mesh};
use nalgebra::Vector3;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::assembly::{BlockMatrix, BlockPattern, StiffnessExtremes, assemble};
use crate::factor::{Analysis, Factor};
use crate::iterative::{
    ChoiceReason, CornerInterpolation, Iterative, IterativeParams, Solver, SolverChoice,
    SolverInfo, SolverKind, choose,
};
use crate::load::check_node;
use crate::ordering::{NodeGraph, NodeOrder};
use crate::rigid_modes::check_supports;
use crate::solve::{SolveInfo, SolveParams, solve_all};
use crate::{IsotropicMaterial, NodalLoad, SimError};

/// What an elastic model is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct ElasticParams {
    /// The material of all elements.
    pub material: IsotropicMaterial,
    /// A factor on Young's modulus per element `[n_elements]`; none means 1 everywhere.
    pub element_stiffness_scale: Option<Vec<f64>>,
    /// Nodes held at zero in all directions; repeats are allowed.
    pub clamped: Vec<FeNodeId>,
    /// How its systems are solved.
    pub solver: SolverChoice,
    /// Worker threads, at least 1. Results do not depend on it, bit for bit.
    pub n_threads: usize,
}

/// What building an elastic model took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FactorInfo {
    /// Nodes of the mesh, clamped ones included.
    pub n_fe_nodes: usize,
    /// Equations: three per free node.
    pub n_equations: usize,
    /// Structural non-zeros in the lower triangle of K, diagonal included.
    pub nnz_lower: usize,
    /// Non-zeros in the Cholesky factor L, diagonal included, without the zeros that merged
    /// supernodes store; 0 on the iterative path.
    pub nnz_l: usize,
    /// Entries of L as stored: [`Self::nnz_l`] and the zeros of merged supernodes.
    pub nnz_l_stored: usize,
    /// Seconds for the support check, ordering and analysis; 0 where they were reused.
    pub order_s: f64,
    /// Seconds for element matrices and assembly.
    pub assemble_s: f64,
    /// Seconds for the numeric factorisation, or for the levels of the iterative path.
    pub factor_s: f64,
}

/// A limb's stiffness, assembled, ordered and factored: displacements for any load.
#[derive(Debug)]
pub struct ElasticModel {
    pub(crate) structure: Arc<Structure>,
    pub(crate) stiffness: BlockMatrix,
    pub(crate) solver: Solver,
    /// ‖K̂‖∞ of the Jacobi-scaled stiffness.
    pub(crate) scaled_norm: f64,
    pub(crate) pool: Arc<ThreadPool>,
    info: FactorInfo,
    solver_info: SolverInfo,
    extremes: StiffnessExtremes,
}

/// What depends on the mesh and its supports alone.
#[derive(Debug)]
pub(crate) struct Structure {
    pub(crate) order: NodeOrder,
    pattern: Arc<BlockPattern>,
    plan: Plan,
    reason: ChoiceReason,
    n_elements: usize,
}

/// What a solver needs of the mesh and its supports.
#[derive(Debug)]
enum Plan {
    Direct(Arc<Analysis>),
    Iterative(CornerInterpolation, IterativeParams),
}

impl ElasticModel {
    /// Assembles, orders and factors the stiffness of `mesh`.
    ///
    /// # Errors
    /// [`SimError::NodeOutOfRange`], [`SimError::Length`], [`SimError::StiffnessScale`] and
    /// [`SimError::Parameter`] on unusable parameters; [`SimError::FreeRigidModes`] and
    /// [`SimError::AllClamped`] on unusable supports, before any factoring;
    /// [`SimError::ElementInverted`] and [`SimError::NotPositiveDefinite`] on a bad mesh;
    /// [`SimError::TooLarge`] and [`SimError::Threads`] on lack of resources.
    pub fn build(mesh: &Tet10Mesh, params: &ElasticParams) -> Result<Self, SimError> {
        let pool = thread_pool(params.n_threads)?;
        let started = Instant::now();
        let structure = Arc::new(Structure::build(mesh, &params.clamped, params.solver)?);
        let order_s = started.elapsed().as_secs_f64();
        let scale = params.element_stiffness_scale.as_deref();
        Self::fill(mesh, structure, &params.material, scale, pool, order_s)
    }

    /// The model of the same mesh and supports with another material or other stiffness scales;
    /// ordering and analysis are reused.
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
            if expected == found {
                Ok(())
            } else {
                Err(SimError::Length {
                    what,
                    expected,
                    found,
                })
            }
        };
        expect(
            "the mesh's node list",
            self.structure.order.n_fe_nodes(),
            mesh.nodes().len(),
        )?;
        expect(
            "the mesh's element list",
            self.structure.n_elements,
            mesh.elements().len(),
        )?;
        let (structure, pool) = (Arc::clone(&self.structure), Arc::clone(&self.pool));
        Self::fill(
            mesh,
            structure,
            material,
            element_stiffness_scale,
            pool,
            0.0,
        )
    }

    fn fill(
        mesh: &Tet10Mesh,
        structure: Arc<Structure>,
        material: &IsotropicMaterial,
        scale: Option<&[f64]>,
        pool: Arc<ThreadPool>,
        order_s: f64,
    ) -> Result<Self, SimError> {
        check_scale(scale, mesh.elements().len())?;
        let started = Instant::now();
        let pattern = Arc::clone(&structure.pattern);
        let (stiffness, extremes) =
            pool.install(|| assemble(mesh, material, scale, &structure.order, pattern))?;
        let assemble_s = started.elapsed().as_secs_f64();
        let started = Instant::now();
        let solver = pool
            .install(|| structure.solver(mesh, &stiffness))
            .map_err(|error| name_node(error, &structure.order))?;
        let factor_s = started.elapsed().as_secs_f64();
        let info = structure.info(order_s, assemble_s, factor_s);
        let scaled_norm = stiffness.scaled_norm(solver.scale());
        Ok(Self {
            solver_info: structure.solver_info(&solver),
            structure,
            stiffness,
            solver,
            scaled_norm,
            pool,
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

    /// The displacements `[n_fe_nodes]`, m, under `load`; clamped nodes have zero.
    ///
    /// # Errors
    /// [`SimError::NodeOutOfRange`], [`SimError::LoadNotFinite`], [`SimError::Residual`].
    pub fn solve(&self, load: &NodalLoad) -> Result<(Vec<Vector3<f64>>, SolveInfo), SimError> {
        let mut displacement = Vec::new();
        let loads = std::slice::from_ref(load);
        let info = solve_all(
            self,
            loads,
            &SolveParams::default(),
            |block| block.field(0),
            |_, field| displacement = field,
        )?;
        Ok((displacement, info))
    }

    /// The strain energy ½ uᵀ K u of displacements `[n_fe_nodes]`, m, in J; clamped nodes count as
    /// zero.
    ///
    /// # Errors
    /// [`SimError::Length`].
    pub fn strain_energy_j(&self, displacement: &[Vector3<f64>]) -> Result<f64, SimError> {
        let order = &self.structure.order;
        if displacement.len() != order.n_fe_nodes() {
            return Err(SimError::Length {
                what: "the displacement field",
                expected: order.n_fe_nodes(),
                found: displacement.len(),
            });
        }
        let u: Vec<f64> = order
            .nodes()
            .iter()
            .flat_map(|node| <[f64; 3]>::from(displacement[node.index()]))
            .collect();
        let mut ku = vec![0.0; u.len()];
        self.stiffness.multiply_add(1.0, &u, 1, &mut ku);
        Ok(0.5 * u.iter().zip(&ku).map(|(u, f)| u * f).sum::<f64>())
    }
}

impl Structure {
    fn build(
        mesh: &Tet10Mesh,
        clamped: &[FeNodeId],
        choice: SolverChoice,
    ) -> Result<Self, SimError> {
        let n_nodes = mesh.nodes().len();
        let mut is_clamped = vec![false; n_nodes];
        for &node in clamped {
            check_node("the list of clamped nodes", node, n_nodes)?;
            is_clamped[node.index()] = true;
        }
        if is_clamped.iter().all(|&clamped| clamped) {
            return Err(SimError::AllClamped { n_nodes });
        }
        check_supports(mesh, &is_clamped)?;
        let order = NodeOrder::build(mesh, &is_clamped)?;
        let pattern = Arc::new(BlockPattern::build(&NodeGraph::build(mesh, &order)));
        let (kind, reason, params) = choose(choice, &pattern)?;
        let plan = match kind {
            SolverKind::Direct => Plan::Direct(Arc::new(Analysis::build(&pattern)?)),
            SolverKind::Iterative => {
                Plan::Iterative(CornerInterpolation::build(mesh, &order), params)
            }
        };
        Ok(Self {
            order,
            pattern,
            plan,
            reason,
            n_elements: mesh.elements().len(),
        })
    }

    fn solver(&self, mesh: &Tet10Mesh, stiffness: &BlockMatrix) -> Result<Solver, SimError> {
        match &self.plan {
            Plan::Direct(analysis) => {
                Factor::build(stiffness, Arc::clone(analysis)).map(Solver::Direct)
            }
            Plan::Iterative(corners, params) => {
                let nodes = self.order.nodes().iter();
                let positions: Vec<_> = nodes.map(|&node| mesh.position(node)).collect();
                let iterative = Iterative::build(stiffness, &positions, corners, *params)?;
                Ok(Solver::Iterative(Box::new(iterative)))
            }
        }
    }

    fn solver_info(&self, solver: &Solver) -> SolverInfo {
        let (kind, multigrid) = match solver {
            Solver::Direct(_) => (SolverKind::Direct, None),
            Solver::Iterative(i) => (SolverKind::Iterative, Some(i.multigrid.info().clone())),
        };
        SolverInfo {
            kind,
            reason: self.reason,
            multigrid,
        }
    }

    fn info(&self, order_s: f64, assemble_s: f64, factor_s: f64) -> FactorInfo {
        let (nnz_l, nnz_l_stored) = match &self.plan {
            Plan::Direct(analysis) => (analysis.nnz_l, analysis.nnz_l_stored),
            Plan::Iterative(..) => (0, 0),
        };
        let n_free = self.order.nodes().len();
        FactorInfo {
            n_fe_nodes: self.order.n_fe_nodes(),
            n_equations: 3 * n_free,
            nnz_lower: 9 * self.pattern.columns.len() - 3 * n_free,
            nnz_l,
            nnz_l_stored,
            order_s,
            assemble_s,
            factor_s,
        }
    }
}

fn thread_pool(n_threads: usize) -> Result<Arc<ThreadPool>, SimError> {
    if n_threads == 0 {
        return Err(SimError::Parameter {
            what: "n_threads",
            value: 0.0,
            expected: "at least 1",
        });
    }
    ThreadPoolBuilder::new()
        .num_threads(n_threads)
        .build()
        .map(Arc::new)
        .map_err(|source| SimError::Threads { n_threads, source })
}

fn check_scale(scale: Option<&[f64]>, n_elements: usize) -> Result<(), SimError> {
    let Some(scale) = scale else { return Ok(()) };
    if scale.len() != n_elements {
        return Err(SimError::Length {
            what: "element_stiffness_scale",
            expected: n_elements,
            found: scale.len(),
        });
    }
    match scale.iter().position(|s| !(s.is_finite() && *s > 0.0)) {
        Some(element) => Err(SimError::StiffnessScale {
            element,
            value: scale[element],
        }),
        None => Ok(()),
    }
}

/// A failing pivot is found by its place in elimination order; the caller knows nodes.
fn name_node(error: SimError, order: &NodeOrder) -> SimError {
    match error {
        SimError::NotPositiveDefinite {
            node: place,
            direction,
        } => SimError::NotPositiveDefinite {
            node: order.nodes()[place].index(),
            direction,
        },
        SimError::Singular {
            node: place,
            direction,
            pivot,
        } => SimError::Singular {
            node: order.nodes()[place].index(),
            direction,
            pivot,
        },
        other => other,
    }
}
