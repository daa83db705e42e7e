//! The rows of docs/verification.md.

mod authors;
mod beams;
mod calculix;
mod closed_forms;
mod curved_shells;
mod decks;
mod hook;
mod hypar;
mod inp;
mod invariance;
mod manufactured;
mod membranes;
mod nafems_shells;
mod nafems_solids;
mod patch;
mod prelude;

use crate::Case;

/// Every case, in the order of the table: solids, then shells.
pub fn all_cases() -> Vec<Case> {
    let groups = [
        patch::solids(),
        invariance::solids(),
        beams::solids(),
        membranes::solids(),
        nafems_solids::cases(),
        closed_forms::cases(),
        manufactured::cases(),
        authors::cases(),
        calculix::cases(),
        patch::shells(),
        invariance::shells(),
        beams::shells(),
        hook::cases(),
        membranes::shells(),
        curved_shells::cases(),
        hypar::cases(),
        nafems_shells::cases(),
        decks::cases(),
    ];
    groups.into_iter().flatten().collect()
}
