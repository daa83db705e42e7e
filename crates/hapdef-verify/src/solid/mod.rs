//! Cases of the ten-node tetrahedron.

mod authors;
mod beams;
mod calculix;
mod closed_forms;
mod manufactured;
mod membranes;
mod patch;
pub(crate) mod problem;
mod row;
mod side_by_side;
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
        authors::cases(),
        calculix::cases(),
        side_by_side::cases(),
    ];
    groups.into_iter().flatten().collect()
}
