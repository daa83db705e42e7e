//! The examples, whose figures are pinned.

#[path = "../../examples/tube_wall.rs"]
#[allow(dead_code, reason = "its main and what it prints")]
mod tube_wall;
