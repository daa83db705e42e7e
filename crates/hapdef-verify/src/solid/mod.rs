//! Cases of the ten-node tetrahedron.

mod patch;

use crate::Case;

/// All of them, in the order of the table.
pub(crate) fn cases() -> Vec<Case> {
    patch::cases()
}
