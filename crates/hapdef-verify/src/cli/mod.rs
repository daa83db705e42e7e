//! The command line.

mod bench;
mod context;
mod deck;
mod robustness;
mod verify;

use anyhow::Result;
use clap::{Parser, Subcommand};

/// Is the elasticity solver right?
#[derive(Parser)]
#[command(
    name = "hapdef-verify",
    after_help = "Examples:\n  cargo xtask verify\n  cargo xtask verify -- --only solid.le10"
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Solves the verification table and judges every row.
    #[command(after_help = "Example:\n  hapdef-verify verify --only solid.le10")]
    Verify(verify::VerifyArgs),
    /// Times the solver against other solvers.
    #[command(after_help = "Example:\n  hapdef-verify bench --skip-large")]
    Bench(bench::BenchArgs),
    /// Tries the solver at its extremes: accurate to its bound, or a clear error.
    #[command(alias = "stability", after_help = "Example:\n  hapdef-verify robustness fe")]
    Robustness(robustness::RobustnessArgs),
    /// Solves a deck's own load and compares it with known results.
    #[command(after_help = "Example:\n  hapdef-verify deck fixtures/shin/shin.inp.gz")]
    Deck(deck::DeckArgs),
}

/// Runs the command; false where a row missed its target.
pub(crate) fn run(cli: &Cli) -> Result<bool> {
    match &cli.task {
        Task::Verify(args) => verify::run(args),
        Task::Bench(args) => bench::run(args).map(|()| true),
        Task::Robustness(args) => robustness::run(args),
        Task::Deck(args) => deck::run(args).map(|()| true),
    }
}

#[cfg(test)]
#[path = "../../../hapdef-cli/tests/it/support/help.rs"]
mod help;

#[cfg(test)]
mod tests {
    use super::{Cli, help};

    #[test]
    fn every_help_has_an_example_that_is_understood() {
        help::every_help_has_an_example_that_is_understood::<Cli>("hapdef-verify");
    }
}
