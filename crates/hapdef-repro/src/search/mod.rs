//! Settings found by Bayesian optimisation, the paper's beside them.
//!
//! A [`SearchMethod`] has [`Parameter`]s and makes a [`Learner`] of their values; [`propose`] gives the
//! next point from the trials so far; [`write_trials`] keeps them, [`merge_trials`] joins shards.

mod learner;
mod optimiser;
mod report;
mod space;
mod trials;

pub use learner::{Fitted, Learner, NetSettings, Samples, forward};
pub use optimiser::propose;
pub use report::{search_figures, search_markdown, values_in_words};
pub use space::{Parameter, ParameterValues, SearchMethod, TrialBudget};
pub use trials::{
    Trial, TrialHeader, TrialSource, best_trial, merge_trials, open_trials, read_trials,
    write_trials,
};
