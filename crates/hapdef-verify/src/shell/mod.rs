//! Cases of the triangular shells.

mod beams;
mod benchmark;
mod curved;
mod decks;
mod grid;
mod hook;
mod hypar;
mod inp;
mod model;
mod nafems;
mod nafems_solid;
mod patch;
mod plane;
mod problem;
mod stress;

use crate::Case;

/// All of them, in the order of the table.
pub(crate) fn cases() -> Vec<Case> {
    let groups = [
        patch::cases(),
        beams::cases(),
        hook::cases(),
        plane::cases(),
        curved::cases(),
        hypar::cases(),
        nafems::cases(),
        nafems_solid::cases(),
        decks::cases(),
    ];
    groups.into_iter().flatten().collect()
}
