//! `compare`: contacts by superposition against the paper's trained pipeline, on the same frames of
//! the same simulated rig.

mod bench;
mod cells;
mod frontier;
mod paper;
mod run;
mod score;
mod sequence;
mod tables;
mod world;

pub(crate) use bench::{BenchInverseArgs, run as run_bench};
pub(crate) use frontier::{FrontierInverseArgs, run as run_frontier};
pub(crate) use run::{CompareArgs, run};
