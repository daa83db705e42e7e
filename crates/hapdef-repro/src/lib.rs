//! The paper's baselines, tables and figures, as functions on slices and plain structs.
//!
//! "The paper" is Sun & Martius, Frontiers in Neurorobotics 13:51, 2019.
//!
//! - [`LinearAccumulator`], [`Knn`], [`Svr`]: the methods the paper compares its networks with.
//! - [`Table1`], [`Table2`]: what was measured beside what the paper prints, and the verdicts.
//! - [`Learner`]: one method with its settings, on samples in memory; [`tactile_scores`]: the
//!   methods on a real tactile skin.
//!
//! Knows nothing of how samples arise or where datasets lie: rows come in as slices or through
//! closures. Lengths are metres and forces newtons; micrometres and
//! millimetres appear only in what is printed.

mod baselines;
mod error;
mod report;
mod robustness;
mod search;
mod tables;
mod tactile;

pub use baselines::{
    Knn, KnnParams, LinearAccumulator, LinearInfo, LinearParams, LinearRegression, Neighbours,
    OwnRow, Svr, SvrInfo, SvrParams,
};
pub use error::ReproError;
pub use report::{Golden, GoldenValue, check_results, results_markdown};
pub use robustness::{
    INVERSE_TABLE, InverseWorld, NETS_TABLE, PARTS_TABLE, inverse_rows, nets_rows, parts_rows,
};
pub use search::{
    Fitted, FittedKnn, Knob, KnobValues, Learner, NetSettings, Samples, SearchMethod, Trial,
    TrialBudget, TrialHeader, TrialLog, TrialSource, best_trial, forward, merge_trials,
    paper_values, propose, read_trials, search_figures, search_markdown, trials_text,
    values_in_words,
};
pub use tables::{
    CellCount, CellState, Check, Claim, Fate, MapMetric, Method, MetricVerdict, OwnAccuracy,
    PAPER_FVU_DOUBLE, PAPER_FVU_SINGLE, PAPER_TABLE2, PaperAccuracy, Table1, Table1Record, Table2,
    TestSet, TrainSet, claims_text, fnn_over_lr, table1_bars, table1_claims,
};
pub use tactile::{
    TactileMethod, TactileParams, TactileRun, TactileScore, numpy_permutations, read_tactile_runs,
    seeded_permutation, tactile_distances_mm, tactile_folder, tactile_scores,
};
