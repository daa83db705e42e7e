//! Runs the pipeline.
fn main() {}
