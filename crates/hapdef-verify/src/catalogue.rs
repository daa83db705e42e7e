//! The table of docs/verification.md.

use crate::{Case, shell, solid};

/// Every case, in the order of the table.
#[must_use]
pub fn all_cases() -> Vec<Case> {
    [solid::cases(), shell::cases()].into_iter().flatten().collect()
}
