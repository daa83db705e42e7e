//! What a model needs of a mesh and its supports, whatever the stiffness: unknowns, their order, the
//! pattern of the stiffness, the solver that is planned for it.

use std::sync::Arc;

use hapdef_mesh::FeNodeId;

use crate::assembly::{BlockPattern, motions_of};
use crate::dissection::{Ordering, sequence};
use crate::elements::Elements;
use crate::iterative::{SolverChoice, SolverPlan};
use crate::ordering::{Cliques, NodeGraph};
use crate::rigid_modes::{Restraints, check_supports};
use crate::supports::{FaceSpring, Held, bedded_directions};
use crate::unknowns::{Link, Unknowns};
use crate::{FactorInfo, MaterialRegion, SimError, Supports};

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
        let inserts = &supports.rigid_inserts;
        let natural = Unknowns::natural(positions, per_node, &held, inserts)?;
        let bedded = bedded_directions(&springs);
        check_supports(elements, &Restraints { held: &held, bedded, inserts })?;
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
