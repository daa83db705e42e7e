//! What a model needs of a mesh and its supports, whatever the stiffness: unknowns, their order, the
//! pattern of the stiffness, the solver that is planned for it.

use std::sync::Arc;

use hapdef_mesh::FeNodeId;

use crate::elements::element_set::Elements;
use crate::factor::dissection::{Ordering, sequence};
use crate::factor::ordering::{Cliques, NodeGraph};
use crate::iterative::{SolverChoice, SolverPlan};
use crate::supports::conditions::{FaceSpring, Held, foundation_directions};
use crate::supports::rigid_modes::{Restraints, check_supports};
use crate::supports::unknowns::{Link, Unknowns};
use crate::system::assembly::{BlockPattern, motions_of};
use crate::{MaterialRegion, SimError, Supports};

/// What depends on the mesh and its supports alone.
#[derive(Debug)]
pub(crate) struct Structure {
    pub(crate) unknowns: Unknowns,
    pub(crate) pattern: Arc<BlockPattern>,
    pub(crate) plan: SolverPlan,
    pub(crate) ordering: Ordering,
    pub(crate) springs: Vec<FaceSpring>,
    pub(crate) regions: Vec<MaterialRegion>,
    pub(crate) n_elements: usize,
}

/// What building an elastic model took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FactorInfo {
    /// Nodes of the mesh, clamped ones included.
    pub n_fe_nodes: usize,
    /// Equations: three per unknown motion.
    pub n_equations: usize,
    /// Structural non-zeros in the lower triangle of K, diagonal included.
    pub nnz_lower: usize,
    /// Non-zeros in the Cholesky factor L, diagonal included, without the zeros that merged
    /// supernodes store; 0 on the iterative path.
    pub nnz_l: usize,
    /// Entries of L as stored: [`Self::nnz_l`] and the zeros of merged supernodes.
    pub nnz_l_stored: usize,
    /// Operations of the numeric factorisation, Σ c² over the c entries of every column of L as
    /// stored (A. George and J. Liu, Computer Solution of Large Sparse Positive Definite Systems,
    /// 1981, section 2.2); 0 on the iterative path.
    pub factor_flops: f64,
    /// How the elimination order was found: whichever gives the smaller fill.
    pub ordering: Ordering,
    /// Seconds for the support check, ordering and analysis; 0 where they were reused.
    pub order_s: f64,
    /// Seconds for element matrices and assembly.
    pub assemble_s: f64,
    /// Seconds for the numeric factorisation, or for the levels of the iterative path.
    pub factor_s: f64,
}

impl Structure {
    pub(crate) fn build(
        elements: &dyn Elements,
        clamped: &[FeNodeId],
        supports: &Supports,
        choice: SolverChoice,
    ) -> Result<Self, SimError> {
        let (positions, per_node) = (elements.positions(), elements.motions_per_node());
        let held = Held::new(clamped, supports, positions.len(), per_node == 2)?;
        let mut springs = Vec::new();
        for foundation in &supports.foundations {
            springs.extend(foundation.springs(positions)?);
        }
        let rigid_bodies = &supports.rigid_bodies;
        let natural = Unknowns::natural(positions, per_node, &held, rigid_bodies)?;
        let on_foundations = foundation_directions(&springs);
        check_supports(elements, &Restraints { held: &held, on_foundations, rigid_bodies })?;
        let cliques = cliques(elements, &springs, &natural);
        let graph = NodeGraph::build(natural.n_places(), &cliques);
        let (sequence, ordering) = sequence(&graph)?;
        let unknowns = natural.reordered(&sequence);
        let pattern = Arc::new(BlockPattern::build(&graph.reordered(&sequence)));
        let plan = SolverPlan::build(choice, elements, &unknowns, &pattern)?;
        Ok(Self {
            unknowns,
            pattern,
            plan,
            ordering,
            springs,
            regions: Vec::new(),
            n_elements: elements.n_elements(),
        })
    }

    pub(crate) fn info(&self, order_s: f64, assemble_s: f64, factor_s: f64) -> FactorInfo {
        let n_places = self.unknowns.n_places();
        let (nnz_l, nnz_l_stored) = self.plan.fill();
        FactorInfo {
            n_fe_nodes: self.unknowns.n_fe_nodes(),
            n_equations: 3 * n_places,
            nnz_lower: 9 * self.pattern.columns.len() - 3 * n_places,
            nnz_l,
            nnz_l_stored,
            factor_flops: self.plan.factor_flops(),
            ordering: self.ordering,
            order_s,
            assemble_s,
            factor_s,
        }
    }
}

/// The unknowns that each element, and each spring, couples.
fn cliques(elements: &dyn Elements, springs: &[FaceSpring], unknowns: &Unknowns) -> Cliques {
    let mut cliques = Cliques::default();
    for element in 0..elements.n_elements() {
        let motions = motions_of(elements.nodes(element), elements.motions_per_node());
        cliques.push(motions.iter().flat_map(|&motion| unknowns.link(motion).places()));
    }
    for spring in springs {
        let links = spring.nodes.iter().map(|&node| unknowns.translation(node));
        cliques.push(links.flat_map(Link::places));
    }
    cliques
}
