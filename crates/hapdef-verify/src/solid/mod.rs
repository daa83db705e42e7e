//! Cases of the ten-node tetrahedron.

mod beams;
mod closed_forms;
mod manufactured;
mod membranes;
mod patch;
mod problem;
mod thermal;

use crate::Case;

/// All of them, in the order of the table.
pub(crate) fn cases() -> Vec<Case> {
    let groups = [
        patch::cases(),
        beams::cases(),
        membranes::cases(),
        thermal::cases(),
        closed_forms::cases(),
        manufactured::cases(),
    ];
    groups.into_iter().flatten().collect()
}
