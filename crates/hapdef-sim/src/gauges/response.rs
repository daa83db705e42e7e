//! What sensors read for a force anywhere, by one adjoint solve each.

use hapdef_mesh::{FeNodeId, GaugeId};
use nalgebra::Vector3;

use super::LinearFunctional;
use crate::model::solve::{Extent, solve_all};
use crate::model::solve_info::{SolveInfo, SolveParams};
use crate::{ElasticModel, NodalLoad, SimError};

/// Readings of all gauges for a unit force, and on shells a unit moment, at any FE node in any direction.
#[derive(Clone, Debug, PartialEq)]
pub struct GaugeResponse {
    n_fe_nodes: usize,
    fields: Vec<Vector3<f64>>,
    /// As long as `fields` on shells, empty for solids.
    moment_fields: Vec<Vector3<f64>>,
}

impl GaugeResponse {
    /// Gauges.
    #[must_use]
    pub fn n_gauges(&self) -> usize {
        self.fields.len().checked_div(self.n_fe_nodes).unwrap_or(0)
    }

    /// The adjoint field of `gauge` `[n_fe_nodes]`: strain per newton for a force in each direction.
    ///
    /// # Panics
    /// If `gauge` is not one of the gauges.
    #[must_use]
    pub fn field(&self, gauge: GaugeId) -> &[Vector3<f64>] {
        let first = gauge.index() * self.n_fe_nodes;
        &self.fields[first..first + self.n_fe_nodes]
    }

    /// The rotations of the adjoint field of `gauge` `[n_fe_nodes]`: strain per newton metre for a moment
    /// about each direction; empty for solids.
    ///
    /// # Panics
    /// If `gauge` is not one of the gauges of a shell.
    #[must_use]
    pub fn moment_field(&self, gauge: GaugeId) -> &[Vector3<f64>] {
        if self.moment_fields.is_empty() {
            return &[];
        }
        let first = gauge.index() * self.n_fe_nodes;
        &self.moment_fields[first..first + self.n_fe_nodes]
    }

    /// The reading of `gauge` under `load`: strain.
    ///
    /// # Panics
    /// If `gauge` is not one of the gauges, or `load` names a node the mesh does not have.
    #[must_use]
    pub fn reading(&self, gauge: GaugeId, load: &NodalLoad) -> f64 {
        let sum = |field: &[Vector3<f64>], load: &[(FeNodeId, Vector3<f64>)]| -> f64 {
            load.iter().map(|(node, part)| part.dot(&field[node.index()])).sum()
        };
        let of_forces = sum(self.field(gauge), &load.forces_n);
        match load.moments_nm[..] {
            [] => of_forces,
            _ => of_forces + sum(self.moment_field(gauge), &load.moments_nm),
        }
    }
}

impl ElasticModel {
    /// The response of `functionals` (strain gauges on solids or shells, or any other) to a force
    /// anywhere, by one adjoint solve each: K is symmetric, so the reading cᵀ K⁻¹ f is (K⁻¹ c) · f.
    ///
    /// # Errors
    /// As [`ElasticModel::solve`].
    pub fn response<F: AsRef<LinearFunctional>>(
        &self,
        functionals: &[F],
    ) -> Result<(GaugeResponse, SolveInfo), SimError> {
        let loads: Vec<NodalLoad> = functionals.iter().map(|f| f.as_ref().as_load()).collect();
        let n_fe_nodes = self.info().n_fe_nodes;
        let mut fields = vec![Vector3::zeros(); loads.len() * n_fe_nodes];
        let n_turning =
            if self.structure.unknowns.motions_per_node() == 2 { fields.len() } else { 0 };
        let mut moment_fields = vec![Vector3::zeros(); n_turning];
        let info = solve_all(
            self,
            &loads,
            &SolveParams::default(),
            Extent::Full,
            |block| (0..block.loads.len()).map(|column| block.motion(column)).collect::<Vec<_>>(),
            |block, solved| {
                for (&gauge, motion) in block.iter().zip(&solved) {
                    let nodes = gauge * n_fe_nodes..(gauge + 1) * n_fe_nodes;
                    fields[nodes.clone()].copy_from_slice(&motion.displacement);
                    if n_turning > 0 {
                        moment_fields[nodes].copy_from_slice(&motion.rotation);
                    }
                }
            },
        )?;
        Ok((GaugeResponse { n_fe_nodes, fields, moment_fields }, info))
    }
}
