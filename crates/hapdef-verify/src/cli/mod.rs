//! The command line.

mod bench;
mod context;
mod deck;
mod stability;
mod verify;

use anyhow::Result;
use clap::{Parser, Subcommand};

/// Is the elasticity solver right?
#[derive(Parser)]
#[command(
    name = "hapdef-verify",
    after_help = "Example:\n  cargo xtask verify\n  cargo xtask verify --only solid.le10"
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Solves the verification table and judges every row.
    Verify(verify::VerifyArgs),
    /// Times the solver against other solvers.
    Bench(bench::BenchArgs),
    /// Tries the solver at its extremes: accurate to its bound, or a clear error.
    Stability(stability::StabilityArgs),
    /// Solves a deck's own load and compares it with known figures.
    Deck(deck::DeckArgs),
}

/// Runs the command; false where a row missed its target.
pub(crate) fn run(cli: &Cli) -> Result<bool> {
    match &cli.task {
        Task::Verify(args) => verify::run(args),
        Task::Bench(args) => bench::run(args).map(|()| true),
        Task::Stability(args) => stability::run(args),
        Task::Deck(args) => deck::run(args).map(|()| true),
    }
}
