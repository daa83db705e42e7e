//! The examples, whose figures are pinned.

#[path = "../../examples/tour/main.rs"]
#[allow(dead_code, reason = "its main and what it prints")]
mod tour;
