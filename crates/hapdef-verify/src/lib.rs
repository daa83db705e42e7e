//! Whether the elasticity solver is right: every row is a problem whose answer is known from a
//! publication, a closed form or another program, solved on a sequence of meshes.
//!
//! - [`Case`]: one problem, its reference with the source, and the target it is judged by.
//! - [`all_cases`]: the table of docs/verification.md; a case is a row of data in one of its files.
//! - [`run_cases`]: solves cases and judges them, giving a [`Report`].
//! - [`robustness_trials`]: the solver at extremes, the table of docs/stability-fe.md.
//!
//! Knows nothing of scenes, networks, gauges or the paper. Each case states its own units; those of
//! published benchmarks (inch and pound, mm and MPa) are kept, since statics is free of units.

mod answer;
pub mod bench;
mod case;
mod cases;
mod ccx;
mod check;
mod deck;
mod error;
mod inputs;
mod memo;
mod meshes;
mod model;
mod page;
mod problem;
mod robustness;
mod run;
mod stress;
mod table;

pub use answer::{Element, KnownMiss, Measured, Reference, Target};
pub use case::Case;
pub use cases::all_cases;
pub use check::differences;
pub use deck::{DeckMetrics, DeckResults, largest_difference};
pub use error::VerifyError;
pub(crate) use inputs::shared;
pub use page::verification_page;
pub use robustness::{ROBUSTNESS_TABLE, RobustnessTrials, robustness_trials};
pub use run::{CaseReport, Report, Row, Verdict, run_case, run_cases};
pub use table::{markdown, people_table};
