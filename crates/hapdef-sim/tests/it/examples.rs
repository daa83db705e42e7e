//! The examples, whose figures are pinned.

#[path = "../../examples/cantilever.rs"]
#[allow(dead_code, reason = "its main and what it prints")]
mod cantilever;
