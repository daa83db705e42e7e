//! Cases of the ten-node tetrahedron.

mod beams;
mod closed_forms;
mod membranes;
mod patch;
mod problem;

use crate::Case;

/// All of them, in the order of the table.
pub(crate) fn cases() -> Vec<Case> {
    [
        patch::cases(),
        beams::cases(),
        membranes::cases(),
        closed_forms::cases(),
    ]
    .into_iter()
    .flatten()
    .collect()
}
