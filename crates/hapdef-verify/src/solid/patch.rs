//! Patch tests: a linear displacement field is met exactly on any mesh.

use crate::Case;

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    Vec::new()
}
