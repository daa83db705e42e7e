//! An outside check: the baselines and a net of ours on a real tactile skin that nobody here built.
//!
//! The data are two runs of a probe on a magnetic skin (eFlesh, MIT licence, github
//! notvenky/eFlesh ab5ca56a): 4,805 presses each, 15 channels and the probe's place on a
//! 30 × 30 mm field. They are read where they lie and not part of this project. Settings are
//! chosen on part of the training presses; test presses are looked at once.

mod methods;
mod numpy_split;
mod runs;

pub use methods::{TACTILE_METHODS, TactileScore, tactile_scores};
pub use numpy_split::{numpy_permutations, seeded_permutation};
pub use runs::{TactileRun, read_tactile_runs, tactile_folder};

#[cfg(test)]
mod tests;
