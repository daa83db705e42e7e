//! How far a limb gives way under each contact.

use hapdef_mesh::FeNodeId;

use crate::loads::nodal::check_node;
use crate::model::solve::{Extent, solve_all};
use crate::model::solve_info::{SolveInfo, SolveParams};
use crate::{ElasticModel, NodalLoad, SimError};

impl ElasticModel {
    /// The displacement magnitude of each contact node under its own load, m: `nodes` and `loads`
    /// go together, and loads of one constant force give the rigidity map (Sun and Martius 2019,
    /// figure 3).
    ///
    /// # Errors
    /// [`SimError::Length`] if the lists differ in length; else as [`ElasticModel::solve`].
    pub fn rigidity_map(
        &self,
        nodes: &[FeNodeId],
        loads: &[NodalLoad],
        params: &SolveParams,
    ) -> Result<(Vec<f64>, SolveInfo), SimError> {
        if nodes.len() != loads.len() {
            return Err(SimError::Length {
                what: "the list of contact loads",
                expected: nodes.len(),
                found: loads.len(),
            });
        }
        for &node in nodes {
            check_node("the list of contact nodes", node, self.info().n_fe_nodes)?;
        }
        let mut magnitude_m = vec![0.0; nodes.len()];
        let info = solve_all(
            self,
            loads,
            params,
            Extent::Full,
            |block| {
                let own = block.loads.iter().enumerate();
                own.map(|(column, &load)| block.displacement(column, nodes[load]).norm())
                    .collect::<Vec<f64>>()
            },
            |block, magnitudes| {
                for (&load, magnitude) in block.iter().zip(magnitudes) {
                    magnitude_m[load] = magnitude;
                }
            },
        )?;
        Ok((magnitude_m, info))
    }
}
