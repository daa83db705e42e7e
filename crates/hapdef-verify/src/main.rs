//! `hapdef-verify`: whether the elasticity solver is right. Every row is a problem whose answer is known
//! from a publication, a closed form or another program, solved on a sequence of meshes.
//!
//! - [`Case`]: one problem, its reference with the source, and the target it is judged by.
//! - [`cases`]: the table of docs/verification.md; a case is a row of data in one of its files.
//! - [`run`]: solves cases and judges them, giving a [`Report`].
//! - [`robustness`]: the solver at extremes, the table of docs/stability-fe.md.
//! - [`deck`]: a deck against its known results; [`mod@bench`]: times against other solvers.
//!
//! Knows nothing of scenes, networks, gauges or the paper. Each case states its own units; those of
//! published benchmarks (inch and pound, mm and MPa) are kept, since statics is free of units.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a command line program prints")]

mod answer;
mod bench;
mod case;
mod cases;
mod ccx;
mod check;
mod cli;
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

use std::process::ExitCode;

use clap::Parser;

use crate::answer::{Element, KnownMiss, Measured, Reference, Target};
use crate::case::Case;
use crate::error::VerifyError;
use crate::inputs::shared;
use crate::run::{CaseReport, Report, Row, Verdict};

fn main() -> ExitCode {
    match cli::run(&cli::Cli::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}
