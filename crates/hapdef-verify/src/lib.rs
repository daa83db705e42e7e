//! Whether the elasticity solver is right: every row is a problem whose answer is known from a
//! publication, a closed form or another program, solved on a sequence of meshes.
//!
//! - [`Case`]: one problem, its reference with the source, and the target it is judged by.
//! - [`run_cases`]: solves cases and judges them, giving a [`Report`].
//! - [`robustness_rows`]: the solver at extremes, the table of docs/stability-fe.md.
//! - [`all_cases`]: the table of docs/verification.md.
//!
//! Knows nothing of scenes, networks, gauges or the paper. Each case states its own units; those of
//! published benchmarks (inch and pound, mm and MPa) are kept, since statics is free of units.

pub mod bench;
mod case;
mod catalogue;
mod check;
mod deck;
mod error;
mod inputs;
pub mod meshes;
mod page;
mod robustness;
mod run;
mod shell;
mod solid;
mod table;

pub use case::{Case, KnownMiss, Measured, Reference, Target};
pub use catalogue::all_cases;
pub use check::differences;
pub use deck::{DeckResults, KnownResults, read_displacements};
pub use error::VerifyError;
pub(crate) use inputs::shared;
pub use page::verification_page;
pub use robustness::{ROBUSTNESS_TABLE, robustness_rows};
pub use run::{CaseReport, Report, Row, Verdict, run_case, run_cases};
pub use table::{markdown, people_table};
