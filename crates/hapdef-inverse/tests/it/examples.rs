//! The examples, whose figures are pinned.

#[path = "../../examples/two_contacts.rs"]
#[allow(dead_code, reason = "its main and what it prints")]
mod two_contacts;
