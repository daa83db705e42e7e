//! `compare`: contacts by superposition against the paper's trained pipeline, on the same frames of
//! the same simulated rig.

mod arrivals;
pub(crate) mod bench;
mod cases;
pub(crate) mod cells;
mod diagnose;
mod figures;
pub(crate) mod frontier;
mod loads;
mod palm;
pub(crate) mod paper;
pub(crate) mod rig;
mod run;
pub(crate) mod score;
pub(crate) mod sequence;
mod setup;
mod tables;
pub(crate) mod world;

pub(crate) use bench::{BenchInverseArgs, run as run_bench};
pub(crate) use frontier::run as run_frontier;
pub(crate) use run::run;
pub(crate) use setup::CompareArgs;
