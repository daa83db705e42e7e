//! The table of docs/verification.md.

use crate::{Case, solid};

/// Every case, in the order of the table.
#[must_use]
pub fn all_cases() -> Vec<Case> {
    solid::cases()
}
