//! The assembled system as plain arrays, for other solvers on the same matrix.

use crate::model::solved_block::unknown_forces;
use crate::{ElasticModel, NodalLoad, SimError};

/// The lower triangle of a symmetric matrix by columns.
#[derive(Clone, Debug, PartialEq)]
pub struct StiffnessMatrix {
    /// Where each column begins, and the number of entries `[n + 1]`.
    pub col_ptr: Vec<u32>,
    /// The row of each entry, ascending in a column, the diagonal first.
    pub row_idx: Vec<u32>,
    /// The value of each entry, N/m.
    pub values: Vec<f64>,
}

impl ElasticModel {
    /// The stiffness of the unknowns, in elimination order, N/m (and N m for rotations).
    ///
    /// # Errors
    /// [`SimError::TooLarge`] beyond 32-bit indices.
    pub fn stiffness_matrix(&self) -> Result<StiffnessMatrix, SimError> {
        let pattern = &self.stiffness.pattern;
        if i32::try_from(9 * pattern.columns.len()).is_err() {
            return Err(SimError::TooLarge {
                n_equations: self.info().n_equations,
                reason: "more entries than 32-bit indices can name".to_owned(),
            });
        }
        let mut matrix =
            StiffnessMatrix { col_ptr: vec![0], row_idx: Vec::new(), values: Vec::new() };
        for place in 0..pattern.n_rows() {
            for c in 0..3 {
                for slot in pattern.row_ptr[place]..pattern.row_ptr[place + 1] {
                    let other = pattern.columns[slot] as usize;
                    for r in if other == place { c } else { 0 }..3 {
                        matrix.row_idx.push((3 * other + r) as u32);
                        matrix.values.push(self.stiffness.blocks[slot][3 * c + r]);
                    }
                }
                matrix.col_ptr.push(matrix.row_idx.len() as u32);
            }
        }
        Ok(matrix)
    }

    /// The right-hand side of `load` for [`Self::stiffness_matrix`]: equations and values, which
    /// add where an equation comes twice.
    ///
    /// # Errors
    /// [`SimError::NodeOutOfRange`], [`SimError::LoadNotFinite`].
    pub fn right_hand_side(&self, load: &NodalLoad) -> Result<Vec<(u32, f64)>, SimError> {
        let unknowns = &self.structure.unknowns;
        load.check(unknowns.n_fe_nodes(), unknowns.motions_per_node() == 2)?;
        let forces = unknown_forces(load, unknowns);
        let entries =
            forces.flat_map(|(place, force)| [0, 1, 2].map(|c| ((3 * place + c) as u32, force[c])));
        Ok(entries.filter(|(_, value)| *value != 0.0).collect())
    }
}
